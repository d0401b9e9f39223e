from __future__ import annotations

from typing import Any

import moderngl
import numpy as np
import pytest

import hsr
from hsr.base.errors import MethodError
from hsr.gl.context import Context
from hsr.gl.depth import D24
from hsr.gl.drawing import Drawing, depth_of_window
from hsr.problem.view import View

PARALLEL = {"type": "orthographic", "height": 2.0, "near": 1.0, "far": 9.0, "eye": [0.0, 0.0, 5.0]}


def drawn(context: Context, view: View) -> tuple[Any, Any]:
    with Drawing(context, view) as drawing:
        drawing.draw()
        return drawing.read()


def triangle(corners: list[list[float]], **keys: Any) -> dict[str, Any]:
    return {"name": str(corners), "shape": "mesh", "vertices": corners, "faces": [[0, 1, 2]], **keys}


def test_row_0_is_the_top_row(context: Context, make_scene: Any) -> None:
    upper_left = triangle([[-1.0, 1.0, 0.0], [-1.0, -0.8, 0.0], [0.8, 1.0, 0.0]])
    face, depth = drawn(context, hsr.view(make_scene([upper_left], **PARALLEL), (4, 4)))
    np.testing.assert_array_equal(
        face,
        [[0, 0, 0, -1], [0, 0, -1, -1], [0, -1, -1, -1], [-1, -1, -1, -1]],
    )
    np.testing.assert_allclose(depth[face == 0], 5.0, rtol=1e-6)
    assert np.isposinf(depth[face == -1]).all()
    assert face.dtype == np.int32 and depth.dtype == np.float64


@pytest.mark.parametrize("size", [(1, 1), (3, 2), (7, 5)])
def test_nothing_in_sight_is_background(context: Context, make_scene: Any, size: tuple[int, int]) -> None:
    behind = triangle([[-1.0, 0.0, 9.0], [1.0, 0.0, 9.0], [0.0, 1.0, 9.0]])
    face, depth = drawn(context, hsr.view(make_scene([behind]), size))
    assert face.shape == (size[1], size[0])
    assert (face == -1).all() and np.isposinf(depth).all()


def test_of_equal_depths_the_lower_face_wins(context: Context, make_scene: Any) -> None:
    wall = {"shape": "square", "transform": [{"scale": 2.0}]}
    view = hsr.view(make_scene([{"name": "a", **wall}, {"name": "b", **wall}], **PARALLEL), (4, 4))
    assert (drawn(context, view)[0] == 0).all()


def test_triangles_carry_the_face_they_come_from(context: Context, make_scene: Any) -> None:
    ball = {"name": "ball", "shape": "sphere", "transform": [{"translate": [1.2, 0.0, 0.0]}]}
    view = hsr.view(make_scene([{"name": "can", "shape": "cylinder"}, ball], eye=[0.0, 0.0, 5.0]), (16, 16))
    face, _ = drawn(context, view)
    assert set(np.unique(face)) == {-1, 2, 3}  # the can's cap, and the ball beside it


@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_each_object_culls_for_itself(context: Context, make_scene: Any, mirror: float) -> None:
    def wall(name: str, x: float, cull: str) -> dict[str, Any]:
        steps = [{"scale": [0.3 * mirror, 0.9, 1.0]}, {"translate": [x, 0.0, 0.0]}]
        return {"name": name, "shape": "square", "cull": cull, "transform": steps}

    objects = [wall("none", -0.6, "none"), wall("back", 0.0, "back"), wall("front", 0.6, "front")]
    from_the_front = hsr.view(make_scene(objects, **PARALLEL), (8, 8))
    assert set(np.unique(drawn(context, from_the_front)[0])) == {-1, 0, 1}
    from_behind = hsr.view(make_scene(objects, **{**PARALLEL, "eye": [0.0, 0.0, -5.0]}), (8, 8))
    assert set(np.unique(drawn(context, from_behind)[0])) == {-1, 0, 2}


def test_drawing_again_gives_the_same(context: Context, make_scene: Any) -> None:
    view = hsr.view(make_scene([{"name": "cube", "shape": "cube"}]), (32, 24))
    other = hsr.view(make_scene([{"name": "ball", "shape": "sphere"}]), (8, 8))
    with Drawing(context, view) as drawing, Drawing(context, other) as between:
        drawing.draw()
        first = drawing.read()
        between.draw()
        drawing.draw()
        for before, after in zip(first, drawing.read(), strict=True):
            np.testing.assert_array_equal(before, after)


def test_depths_are_integers_over_24_bits(context: Context, make_scene: Any) -> None:
    view = hsr.view(make_scene([{"name": "cube", "shape": "cube"}], near=1.0), (32, 24))
    _, depth = drawn(context, view)
    stored = (1.0 - view.near / depth[np.isfinite(depth)]) / D24.step
    np.testing.assert_allclose(stored, np.rint(stored), atol=1e-6)
    assert len(np.unique(stored)) > 100


CAMERAS: list[dict[str, Any]] = [
    {"near": 0.5},
    {"near": 0.5, "far": 40.0},
    {"type": "orthographic", "height": 3.0, "near": -2.0, "far": 12.0},
]


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("by_matrix", [False, True])
def test_window_depth_is_inverted(make_scene: Any, camera: dict[str, Any], by_matrix: bool) -> None:
    view = hsr.view(make_scene([{"name": "cube", "shape": "cube"}], **camera), (4, 4))
    if by_matrix:
        given = view.clip_from_world.tolist()
        scene = hsr.Scene.model_validate(
            {"camera": [{"type": "matrix", "matrix": given}], "object": [{"name": "cube", "shape": "cube"}]}
        )
        view = hsr.view(scene, (4, 4))
    points = np.column_stack([np.random.default_rng(0).uniform(-1.0, 1.0, (50, 3)), np.ones(50)])
    clip = points @ view.clip_from_world.T
    window = (clip[:, 2] / clip[:, 3] + 1.0) / 2.0
    np.testing.assert_allclose(depth_of_window(view, window), points @ view.depth_row, rtol=1e-12)


def test_a_picture_beyond_the_driver_is_one_clear_line(
    context: Context, make_scene: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(context, "max_side", 64)
    with pytest.raises(MethodError, match=r"at most 64 samples a side, not 65x8"):
        Drawing(context, hsr.view(make_scene([{"name": "cube", "shape": "cube"}]), (65, 8)))


def test_a_driver_without_room_is_one_clear_line(
    context: Context, make_scene: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def incomplete(*_arguments: Any) -> Any:
        raise moderngl.Error("the framebuffer is not complete (INCOMPLETE_ATTACHMENT)")

    monkeypatch.setattr(context.gl, "framebuffer", incomplete)
    with pytest.raises(MethodError, match="no room for 8x6 samples"):
        Drawing(context, hsr.view(make_scene([{"name": "cube", "shape": "cube"}]), (8, 6)))


def test_coordinates_beyond_float32_are_one_clear_line(context: Context, make_scene: Any) -> None:
    far_away = {"name": "cube", "shape": "cube", "transform": [{"scale": 1e39}]}
    with pytest.raises(MethodError, match="beyond float32"):
        Drawing(context, hsr.view(make_scene([far_away]), (8, 8)))
