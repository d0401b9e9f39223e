"""The float32 arithmetic of the software driver, against exact numbers and small pictures."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from hsr.models.llvmpipe import float32

ONE = np.ones(6, np.float32)
SINGLES = st.floats(-(2.0**40), 2.0**40, width=32, allow_subnormal=False)


def nearest_float32(value: Fraction) -> np.float32:
    """Round to the nearest float32, ties to even, by looking at three candidates."""
    guess = np.float32(float(value))
    near = [np.nextafter(guess, np.float32(-np.inf)), guess, np.nextafter(guess, np.float32(np.inf))]
    return min(near, key=lambda f: (abs(Fraction(float(f)) - value), int(f.view(np.int32)) & 1))


# ---------------------------------------------------------------- multiply and add


def test_multiply_add_rounds_once() -> None:
    a, b = np.float32((1 + 2.0**-23) * 2.0**-12), np.float32((1 - 2.0**-23) * 2.0**-12)
    c = np.float32(1 + 2.0**-23)
    # The sum is 2**-70 below the middle of two float32: float64 rounds it to the middle.
    assert np.float32(float(a) * float(b) + float(c)) == np.float32(1 + 2.0**-22)
    assert float32.multiply_add(a, b, c) == c
    assert float32.multiply_add(-a, b, -c) == -c


@given(SINGLES, SINGLES, SINGLES)
def test_multiply_add_is_the_nearest_float32(a: float, b: float, c: float) -> None:
    exact = Fraction(a) * Fraction(b) + Fraction(c)
    if exact == 0 or abs(exact) > 2.0**-100:
        assert float32.multiply_add(np.float32(a), np.float32(b), np.float32(c)) == nearest_float32(exact)


def test_project_divides_then_scales_and_moves() -> None:
    clip = np.array([[1.0, -2.0, 3.0, 4.0]], dtype=np.float32)
    half = np.array([50.0, 20.0, 0.5], dtype=np.float32)
    window = np.empty((1, 3), dtype=np.float32)
    float32.project(clip, half, half, window)
    assert window.tolist() == [[62.5, 10.0, 0.875]]


# ---------------------------------------------------------------- clipping


@pytest.mark.parametrize(
    ("vertex", "code"),
    [
        ([0.0, 0.0, 0.0, 1.0], 0),
        ([1.0, -1.0, 1.0, 1.0], 0),  # on planes
        ([1.5, 0.0, 0.0, 1.0], 1),
        ([-1.5, 0.0, 0.0, 1.0], 2),
        ([0.0, 1.5, 0.0, 1.0], 4),
        ([0.0, -1.5, 0.0, 1.0], 8),
        ([0.0, 0.0, -1.5, 1.0], 16),
        ([0.0, 0.0, 1.5, 1.0], 32),
        ([0.0, 0.0, 0.0, -1.0], 63),
    ],
)
def test_outcodes(vertex: list[float], code: int) -> None:
    codes = np.empty(1, dtype=np.int32)
    float32.outcodes(np.array([vertex], dtype=np.float32), ONE, codes)
    assert codes[0] == code


def test_a_guard_band_widens_the_sides_only() -> None:
    codes = np.empty(2, dtype=np.int32)
    vertices = np.array([[1.5, -1.5, 0.0, 1.0], [0.0, 0.0, 1.5, 1.0]], dtype=np.float32)
    float32.outcodes(vertices, np.array([2, 2, 2, 2, 1, 1], np.float32), codes)
    assert codes.tolist() == [0, 32]


def clipped(triangle: ArrayLike, code: int) -> tuple[list[list[float]], list[bool]]:
    clip = np.zeros((1, float32.MOST_CORNERS, 4), dtype=np.float32)
    clip[0, :3] = triangle
    made = np.zeros(clip.shape[:2], dtype=np.bool_)
    corners = np.empty(1, dtype=np.int32)
    float32.clip_triangles(clip, made, np.array([code], dtype=np.int32), ONE, corners)
    return clip[0, : corners[0]].tolist(), made[0, : corners[0]].tolist()


def test_one_corner_outside_leaves_four() -> None:
    polygon, made = clipped([[0, 0, 0, 1], [2, 0, 0, 1], [0, 1, 0, 1]], 1)
    assert polygon == [[0, 0, 0, 1], [1, 0, 0, 1], [1, 0.5, 0, 1], [0, 1, 0, 1]]
    assert made == [False, True, True, False]


def test_two_corners_outside_leave_three() -> None:
    polygon, made = clipped([[0, 0, 0, 1], [0, 0, -3, 1], [4, 0, -3, 1]], 16)
    assert polygon == [[0, 0, 0, 1], [0, 0, -1, 1], [np.float32(4) * np.float32(1 / 3), 0, -1, 1]]
    assert made == [False, True, True]


def test_a_corner_behind_the_eye_is_cut_at_near() -> None:
    polygon, _ = clipped([[0, 0, 1, 2], [0, 1, 1, 2], [0, 0, -3, -2]], 16)
    assert all(z + w >= 0 and w > 0 for _, _, z, w in polygon)
    assert len(polygon) == 4


def test_planes_follow_one_another() -> None:
    polygon, _ = clipped([[0, 0, 0, 1], [4, 0, 0, 1], [0, 4, 0, 1]], 1 | 4)
    assert sorted(polygon) == [[0, 0, 0, 1], [0, 1, 0, 1], [1, 0, 0, 1], [1, 1, 0, 1]]


def test_nothing_is_left_past_a_corner_of_the_view_volume() -> None:
    assert clipped([[3, 0, 0, 1], [0, 3, 0, 1], [3, 3, 0, 1]], 1 | 4) == ([], [])


def test_a_cut_is_reckoned_from_the_nearer_end() -> None:
    inside, outside = [0.1, 0.3, 0.0, 1.0], [1.7, 0.7, 0.0, 1.0]
    polygon, _ = clipped([inside, outside, [0.1, 0.3, 0.0, 1.0]], 1)
    start, end = np.float32(outside), np.float32(inside)
    one = np.float32(1.0)
    t = (one - start[0]) / ((one - start[0]) - (one - end[0]))
    assert polygon[1] == (start + t * (end - start)).tolist()


# ---------------------------------------------------------------- samples

SQUARE = np.array([[1, 2, 0], [2, -2, 0], [1, 0, 2], [2, 0, -2]])  # 0 <= 2 column + 1 <= 3, both ways


def drawn(
    edges: ArrayLike, closed: ArrayLike, plane: ArrayLike, arithmetic: int, clear: float
) -> tuple[list[list[int]], list[list[float]]]:
    """Draw on 3 x 3 samples; the largest integer depth is 255."""
    edges = np.asarray(edges)
    box = np.tile(np.array([0, 0, 2, 2], dtype=np.int32), (len(edges), 1))
    triangle, depth = np.full((3, 3), -1, dtype=np.int32), np.full((3, 3), clear)
    float32.draw(
        edges,
        np.asarray(closed),
        box,
        np.asarray(plane, dtype=np.float64),
        arithmetic,
        np.float32(255.0),
        triangle,
        depth,
    )
    return triangle.tolist(), depth.tolist()


def test_a_sample_on_an_edge_goes_with_the_closed_side() -> None:
    left_of_1, right_of_1 = [[2, -2, 0]], [[-2, 2, 0]]
    shown, _ = drawn([left_of_1, right_of_1], [[False], [True]], [[0, 0, 0]] * 2, float32.FLOAT64, 1.0)
    assert shown == [[0, 1, 1]] * 3
    shown, _ = drawn([left_of_1, right_of_1], [[True], [False]], [[0, 0, 0]] * 2, float32.FLOAT64, 1.0)
    assert shown == [[0, 0, 1]] * 3


def test_all_edges_bound_a_triangle() -> None:
    shown, _ = drawn([SQUARE], [[True] * 4], [[0, 0, 0]], float32.FLOAT64, 1.0)
    assert shown == [[0, 0, -1], [0, 0, -1], [-1, -1, -1]]


def test_the_nearer_wins_and_the_earlier_of_equals() -> None:
    planes = [[0.5, 0.0, 0.0], [0.25, 0.25, 0.0], [0.5, 0.0, 0.0]]
    shown, depth = drawn([SQUARE[:0]] * 3, np.ones((3, 0), np.bool_), planes, float32.FLOAT64, 1.0)
    assert shown == [[1, 0, 0]] * 3
    assert depth == [[0.25, 0.5, 0.5]] * 3


def test_what_is_as_far_as_the_cleared_buffer_is_not_drawn() -> None:
    shown, _ = drawn([SQUARE[:0]], np.ones((1, 0), np.bool_), [[0.5, 0.25, 0.0]], float32.FLOAT32, 1.0)
    assert shown == [[0, 0, -1]] * 3


def test_stored_depths_are_rounded_and_clamped() -> None:
    everywhere = np.zeros((1, 0, 3)), np.ones((1, 0), np.bool_)
    _, depth = drawn(*everywhere, [[-0.25, 0.375, 0.0]], float32.UNORM, 255.0)
    assert depth == [[0.0, 32.0, 128.0]] * 3  # 0.125 * 255 = 31.875; 127.5 goes to the even neighbour


def test_float32_depth_is_two_fused_steps() -> None:
    tenth, third = float(np.float32(0.1)), float(np.float32(1 / 3))
    _, depth = drawn(
        np.zeros((1, 0, 3)), np.ones((1, 0), np.bool_), [[tenth, third, -third]], float32.FLOAT32, 9.0
    )
    along_row = nearest_float32(Fraction(tenth) + 2 * Fraction(third))
    expected = nearest_float32(Fraction(float(along_row)) - Fraction(third))
    assert depth[1][2] == expected
