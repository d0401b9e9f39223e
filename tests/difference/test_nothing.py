"""Why a picture shows nothing."""

from __future__ import annotations

from typing import Any

import pytest

import hsr
from hsr.difference.nothing import why_nothing


def square(name: str, z: float, x: float = 0.0, **more: Any) -> dict[str, Any]:
    return {"name": name, "shape": "square", "transform": [{"translate": [x, 0.0, z]}], **more}


@pytest.mark.parametrize(
    ("thing", "why"),
    [
        (square("a", 7.0), "behind the eye: a"),
        (square("a", 4.5), "nearer than the near plane (1): a"),
        (square("a", -9.0), "beyond the far plane (10): a"),
        (square("a", 0.0, x=30.0), "beside the window: a"),
        (square("a", 0.0, x=-30.0), "beside the window: a"),
        (square("a", 0.0, cull="front"), "culled: a"),
        (
            {"name": "a", "shape": "sphere", "transform": [{"scale": 1e-9}]},
            "edge-on, or between the samples: a",
        ),
    ],
)
def test_every_reason_is_told(make_scene: Any, thing: dict[str, Any], why: str) -> None:
    place = {"eye": [0.0, 0.0, 5.0], "near": 1.0, "far": 10.0}
    view = hsr.view(make_scene([thing], **place), (32, 32))
    assert (hsr.render(view, "raycast").face == -1).all()
    assert why_nothing(view, "raycast") == why


def test_objects_are_told_together(make_scene: Any) -> None:
    things = [square(name, 9.0) for name in "abcde"] + [square("f", 0.0, cull="front")]
    view = hsr.view(make_scene(things, eye=[0.0, 0.0, 5.0]), (16, 16))
    assert why_nothing(view, "zbuffer") == "behind the eye: a, b, c and 2 more; culled: f"


def test_a_parallel_view_has_no_eye_to_be_behind(make_scene: Any) -> None:
    camera = {"type": "orthographic", "eye": [0.0, 0.0, 5.0], "height": 4.0, "far": 10.0}
    view = hsr.view(make_scene([square("a", 7.0)], **camera), (16, 16))
    assert why_nothing(view, "zbuffer") == "nearer than the near plane (0): a"
