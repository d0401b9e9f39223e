"""The painter's algorithm: right where farthest corners tell the order, wrong where no order is right."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms.painter import back_to_front
from hsr.scene.shapes import Polygons

ABOVE = {"type": "orthographic", "eye": [0.0, 0.0, 4.0], "height": 4.0, "near": 0.0, "far": 8.0}


def square(name: str, *steps: dict[str, Any], **keys: Any) -> dict[str, Any]:
    return {"name": name, "shape": "square", "transform": list(steps), **keys}


def test_the_farthest_corner_decides_and_equal_ones_keep_their_order() -> None:
    clip = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 5.0], [0.0, 1.0, 2.0], [1.0, 1.0, 3.0], [2.0, 2.0, 5.0]])
    polygons = Polygons.of(clip, [[0, 2, 3], [0, 1, 2], [2, 3, 0, 4], [2, 3, 0]])
    assert back_to_front(clip, polygons).tolist() == [1, 2, 0, 3]


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1), (1, 2, 0)])
def test_separate_polygons_are_right_in_any_file_order(make_scene: Any, order: tuple[int, ...]) -> None:
    things = [square(f"at {z}", {"translate": [0.3 * z, 0.2 * z, float(z)]}) for z in range(3)]
    view = hsr.view(make_scene([things[k] for k in order], **ABOVE), (16, 16))
    seen, true = hsr.render(view, "painter"), hsr.render(view, "exact")
    assert np.array_equal(seen.face, true.face)
    assert seen.depth == pytest.approx(true.depth, rel=1e-12)


def test_what_is_culled_is_not_painted(make_scene: Any) -> None:
    things = [square("shown"), square("culled", {"translate": [0.0, 0.0, 1.0]}, cull="front")]
    view = hsr.view(make_scene(things, **ABOVE), (8, 8))
    assert np.array_equal(hsr.render(view, "painter").face, hsr.render(view, "exact").face)


def test_interpenetration_breaks_it_and_the_cause_is_named(make_scene: Any) -> None:
    things = [square("one", {"rotate_y": 45.0}), square("other", {"rotate_y": -45.0})]
    view = hsr.view(make_scene(things, **ABOVE), (16, 16))
    seen, true = hsr.render(view, "painter"), hsr.render(view, "exact")
    found = hsr.causes(view, seen, true)
    assert found.counts == {"no depth test": found.wrong} and found.wrong > 15
    assert found.reproduced
