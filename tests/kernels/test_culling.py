"""The three forms of the back-face test."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest

from hsr.kernels.culling import facing_by_determinant, facing_by_normal, facing_in_ndc

FORMS = [facing_by_normal, facing_in_ndc, facing_by_determinant]
WITHOUT_CLIPPING = [facing_by_normal, facing_by_determinant]
Form = Callable[..., np.ndarray]


def facing(form: Form, triangles: np.ndarray, perspective: bool) -> np.ndarray:
    points = np.ascontiguousarray(triangles, dtype=float).reshape(-1, 3)
    count = len(points) // 3
    corner, start = np.arange(3 * count, dtype=np.int32), np.arange(0, 3 * count + 1, 3, dtype=np.int32)
    return np.sign(form(points, corner, start, perspective))


def exact_facing(triangle: np.ndarray, perspective: bool) -> int:
    rows = [[Fraction(x), Fraction(y), Fraction(d) if perspective else Fraction(1)] for x, y, d in triangle]
    (ax, ay, aw), (bx, by, bw), (cx, cy, cw) = rows
    det = ax * (by * cw - bw * cy) - ay * (bx * cw - bw * cx) + aw * (bx * cy - by * cx)
    return (det > 0) - (det < 0)


@pytest.mark.parametrize("perspective", [True, False])
@pytest.mark.parametrize("form", FORMS)
def test_counter_clockwise_faces_are_front_faces(form: Form, perspective: bool) -> None:
    front = np.array([[-0.5, -0.5, 2], [0.5, -0.5, 2], [0, 0.5, 2]])
    edge_on = np.array([[0, -0.5, 2], [0, -0.5, 4], [0, 0.5, 4]])
    assert facing(form, np.stack([front, front[::-1], edge_on]), perspective).tolist() == [1, -1, 0]


@pytest.mark.parametrize("perspective", [True, False])
@pytest.mark.parametrize("form", FORMS)
def test_signs_are_those_of_exact_arithmetic(form: Form, perspective: bool) -> None:
    triangles = np.random.default_rng(7).uniform([-1, -1, 1], [1, 1, 3], (300, 3, 3))
    exact = [exact_facing(triangle, perspective) for triangle in triangles]
    assert facing(form, triangles, perspective).tolist() == exact


@pytest.mark.parametrize("form", WITHOUT_CLIPPING)
def test_corners_behind_the_eye(form: Form) -> None:
    triangles = np.random.default_rng(8).uniform(-1, 1, (300, 3, 3))
    exact = [exact_facing(triangle, True) for triangle in triangles]
    assert facing(form, triangles, True).tolist() == exact
    assert facing(facing_in_ndc, triangles, True).tolist() != exact  # why that form clips first


@pytest.mark.parametrize("form", FORMS)
def test_polygons_of_many_corners(form: Form) -> None:
    angle = 2 * np.pi * np.arange(7) / 7
    loop = np.stack([np.cos(angle), np.sin(angle), np.full(7, 3.0)], axis=1)
    corner, start = np.array([*range(7), *reversed(range(7))], np.int32), np.array([0, 7, 14], np.int32)
    assert np.sign(form(loop, corner, start, True)).tolist() == [1, -1]


@pytest.mark.parametrize("form", FORMS)
def test_a_collinear_first_corner_decides_nothing(form: Form) -> None:
    """The cross product at the first three corners is 0; Newell's sum is not."""
    loop = np.array([[0, 0, 2], [0.5, 0, 2], [1, 0, 2], [1, 1, 2], [0, 1, 2.0]])
    corner, start = np.arange(5, dtype=np.int32), np.array([0, 5], np.int32)
    assert np.sign(form(loop, corner, start, True)).tolist() == [1]


def test_the_normal_toward_the_camera_does_not_decide_under_perspective() -> None:
    """C of the plane in the camera's frame is positive, yet the eye sees the face's back."""
    face = np.array([[-3.0, 0.0, 2.0], [-2.8, 0.0, 1.0], [-2.8, 1.0, 1.0]])
    assert facing(facing_by_normal, face, perspective=False).tolist() == [1]
    assert facing(facing_by_normal, face, perspective=True).tolist() == [exact_facing(face, True)] == [-1]
