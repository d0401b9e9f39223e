"""Cameras: the matrices they amount to, and what a matrix says of its own camera."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hsr.base.arrays import Floats
from hsr.base.errors import ViewError
from hsr.scene.camera import Projection, eye_of, half_tangents, projection_of
from hsr.scene.model import MatrixCamera, Orthographic, Perspective

OBLIQUE = {"eye": [1.0, 2.0, 5.0], "target": [0.5, 0.0, -1.0], "up": [0.2, 1.0, 0.1]}


def perspective(**keys: Any) -> Perspective:
    return Perspective.model_validate({"type": "perspective", "eye": [0, 0, 5], **keys})


def orthographic(**keys: Any) -> Orthographic:
    table = {"type": "orthographic", "eye": [0, 0, 5], "height": 4, "near": 1, "far": 9, **keys}
    return Orthographic.model_validate(table)


def matrix(clip: Floats | list[Any]) -> MatrixCamera:
    return MatrixCamera.model_validate({"type": "matrix", "matrix": np.asarray(clip).tolist()})


def seen(projection: Projection, point: list[float]) -> list[float]:
    x, y, z, w = projection.clip_from_world @ [*point, 1.0]
    return [float(x / w), float(y / w), float(z / w)]


def test_perspective_near_and_far_are_minus_one_and_one() -> None:
    projection = projection_of(perspective(near=1, far=9), 1.0)
    assert seen(projection, [0, 0, 4]) == [0, 0, -1] and seen(projection, [0, 0, -4]) == pytest.approx(
        [0, 0, 1]
    )
    assert projection.depth_row.tolist() == [0, 0, -1, 5]
    assert (projection.near, projection.far) == (1.0, 9.0) and projection.perspective


def test_without_far_infinity_is_one() -> None:
    projection = projection_of(perspective(near=1), 1.0)
    assert projection.far == math.inf
    x, y, z, w = projection.clip_from_world @ [0, 0, -1, 0]
    assert (x, y) == (0, 0) and z == w


@pytest.mark.parametrize(
    ("axis", "aspect", "x", "y"),
    [("y", 2.0, 2, 1), ("x", 2.0, 1, 0.5), ("min", 2.0, 2, 1), ("min", 0.5, 1, 2), ("y", 0.5, 0.5, 1)],
)
def test_the_field_of_view_lies_along_its_axis(axis: str, aspect: float, x: float, y: float) -> None:
    camera = perspective(fov=90, fov_axis=axis)
    assert half_tangents(camera, aspect) == pytest.approx((x, y))
    projection = projection_of(camera, aspect)
    assert seen(projection, [5 * x, 5 * y, 0])[:2] == pytest.approx([1, 1])


def test_orthographic_corners_of_the_viewed_volume() -> None:
    projection = projection_of(orthographic(), 1.5)
    assert seen(projection, [3, 2, 4]) == [1, 1, -1] and seen(projection, [-3, -2, -4]) == [-1, -1, 1]
    assert projection.depth_row.tolist() == [0, 0, -1, 5] and not projection.perspective


def test_near_may_lie_behind_an_orthographic_camera() -> None:
    assert seen(projection_of(orthographic(near=-3), 1.0), [0, 0, 8]) == [0, 0, -1]


def test_length_of_up_does_not_matter() -> None:
    one, other = (projection_of(perspective(up=[0, size, 0]), 1.0) for size in (1e-200, 1e200))
    assert np.array_equal(one.clip_from_world, other.clip_from_world)


@given(st.floats(-100, 100), st.floats(-100, 100), st.floats(1, 100))
def test_the_eye_is_where_it_was_put(x: float, y: float, z: float) -> None:
    projection = projection_of(perspective(eye=[x, y, z], target=[x, y - 0.5, z - 1]), 1.3)
    assert eye_of(projection) == pytest.approx([x, y, z], abs=1e-12 * 200)


# ---------------------------------------------------------------- matrices


@pytest.mark.parametrize("precision", [np.float64, np.float32])
def test_a_perspective_matrix_gives_back_its_camera(precision: Any) -> None:
    original = projection_of(perspective(**OBLIQUE, near=0.5, far=50), 1.5)
    read = projection_of(matrix(original.clip_from_world.astype(precision)), 1.0)
    tolerance = 200 * float(np.finfo(precision).eps)
    assert np.allclose(read.depth_row, original.depth_row, rtol=tolerance, atol=tolerance)
    assert read.near == pytest.approx(0.5, rel=tolerance) and read.far == pytest.approx(
        50, rel=100 * tolerance
    )


def test_a_scaled_matrix_is_the_same_camera() -> None:
    original = projection_of(perspective(**OBLIQUE, near=0.5, far=50), 1.5)
    read = projection_of(matrix(8.0 * original.clip_from_world), 1.0)
    assert np.allclose(read.depth_row, original.depth_row, rtol=1e-15)
    assert (read.near, read.far) == pytest.approx((0.5, 50.0))


def test_an_infinite_perspective_matrix() -> None:
    clip = np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, -1.0, -0.5], [0, 0, -1.0, 0]])
    read = projection_of(matrix(clip), 1.0)
    assert (read.near, read.far) == (0.25, math.inf)


def test_a_parallel_matrix_counts_depth_from_its_near_plane() -> None:
    original = projection_of(orthographic(**OBLIQUE), 1.5)
    read = projection_of(matrix(original.clip_from_world), 1.0)
    assert (read.near, read.far) == (0.0, pytest.approx(8.0))
    # Both count along the view axis; one from the eye, the other from the near plane.
    assert np.allclose(read.depth_row - original.depth_row, [0, 0, 0, -1], atol=1e-15)


def test_mirrored_cameras_know_it() -> None:
    for camera in (perspective(**OBLIQUE), orthographic(**OBLIQUE)):
        projection = projection_of(camera, 1.0)
        mirror = projection_of(matrix(np.diag([-1.0, 1, 1, 1]) @ projection.clip_from_world), 1.0)
        turned = projection_of(matrix(np.diag([-1.0, -1, 1, 1]) @ projection.clip_from_world), 1.0)
        assert (projection.mirrored, mirror.mirrored, turned.mirrored) == (False, True, False)


X, Y, W = [1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, -1.0, 0]
EXTREME = "its numbers are too extreme: the projection over- or underflows float64"


@pytest.mark.parametrize(
    ("camera", "problem"),
    [
        (
            matrix([X, Y, [1e-6, 0, -1.2, -2.2], W]),
            "its near plane is oblique; the third row must be parallel",
        ),
        (
            matrix([X, Y, [0, 0, 1.2, 2.2], W]),
            "its near plane is at 11 and its far plane at 1; needed 0 < near < far",
        ),
        (
            matrix([X, Y, [0, 0, -1.2, 2.2], W]),
            "its near plane is at -1 and its far plane at inf; needed 0 < near",
        ),
        (matrix(np.diag([1.0, 1, -1, -1])), "the last entry of a parallel matrix must be positive, got -1"),
        (perspective(fov=1e-320), EXTREME),
        (perspective(near=5e-324), EXTREME),
        (orthographic(near=-1e308, far=1e308), EXTREME),
    ],
)
def test_cameras_that_are_refused(camera: Any, problem: str) -> None:
    with pytest.raises(ViewError) as caught:
        projection_of(camera, 1.0)
    assert str(caught.value).startswith(problem)
