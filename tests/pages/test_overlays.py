from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import hsr
from hsr.difference.sightline import sightline
from hsr.pages import overlays
from hsr.pages.overlays import SMALLEST, Drawn
from hsr.problem.view import View

CAMERA = {"type": "orthographic", "eye": [0.0, 0.0, 6.0], "height": 4.0, "far": 20.0}


def seen_by(make_scene: Any, *things: dict[str, Any], camera: dict[str, Any] = CAMERA, size: int = 8) -> View:
    named = [{"name": f"thing{k}", **thing} for k, thing in enumerate(things)]
    return hsr.view(make_scene(named, **camera), (size, size))


def square(z: float, **more: Any) -> dict[str, Any]:
    return {"shape": "square", "transform": [{"translate": [0.0, 0.0, z]}], **more}


def test_faces_are_counted_where_they_overlap(make_scene: Any) -> None:
    half = square(1.0) | {"transform": [{"scale": [0.5, 1.0, 1.0]}, {"translate": [0.5, 0.0, 1.0]}]}
    count = Drawn(seen_by(make_scene, square(0.0), half)).complexity()
    expected = np.zeros((8, 8), int)
    expected[2:6, 2:6] = 1
    expected[2:6, 4:6] = 2
    assert np.array_equal(count, expected)


def test_what_is_culled_or_clipped_does_not_count(make_scene: Any) -> None:
    turned = {"shape": "square", "transform": [{"rotate_y": 180.0}]}
    things = (square(7.0), square(0.0, cull="front"), turned | {"cull": "back"}, turned | {"cull": "front"})
    assert Drawn(seen_by(make_scene, *things)).complexity().max() == 1


@pytest.mark.parametrize("at_once", [2**23, 64])
def test_complexity_counts_what_lies_on_the_line_of_sight(
    at_once: int, make_scene: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(overlays, "AT_ONCE", at_once)
    camera = {"type": "perspective", "eye": [2.0, 3.0, 4.0], "near": 3.5}
    cubes = [
        {"shape": "cube", "transform": [{"rotate_y": 17.0 * k}, {"translate": [k, 0.0, -k]}]} for k in (0, 1)
    ]
    view = seen_by(make_scene, *cubes, camera=camera, size=12)
    counted = [
        sum(layer.covered and not layer.removed for layer in sightline(view, x=column, y=row).layers)
        for row in range(12)
        for column in range(12)
    ]
    assert max(counted) > 2
    assert Drawn(view).complexity().ravel().tolist() == counted


def test_sizes_are_powers_of_two(make_scene: Any) -> None:
    tiny = {"shape": "square", "transform": [{"scale": [1e-4, 1e-4, 1.0]}]}
    sizes = Drawn(seen_by(make_scene, square(0.0), tiny)).sizes(np.array([0, 1], dtype=np.int32))
    assert sizes.tolist() == [4 - SMALLEST, 0]  # 16 pixels, and next to nothing


def test_no_faces_have_no_sizes(make_scene: Any) -> None:
    assert Drawn(seen_by(make_scene, square(0.0))).sizes(np.zeros(0, np.int32)).tolist() == []
