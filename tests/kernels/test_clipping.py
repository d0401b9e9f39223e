"""Clipping in clip space."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hsr.kernels.clipping import GUARD, clip_polygons, outcodes, view_volume

PLANES = view_volume(1.0, 10.0, True)


def clip(points: list[list[float]], loops: list[list[int]], planes: np.ndarray = PLANES) -> list[np.ndarray]:
    """Return the corners of each polygon after clipping."""
    corner = np.array([k for loop in loops for k in loop], np.int32)
    start = np.cumsum([0, *map(len, loops)]).astype(np.int32)
    vertices, corner, start = clip_polygons(np.array(points, float), corner, start, planes)
    return [vertices[corner[a:b]] for a, b in itertools.pairwise(start)]


def test_points_on_a_plane_are_inside() -> None:
    points = np.array([[0, 0, 1], [0, 0, 10], [-GUARD, 0, 1], [GUARD, 0, 1], [0, -GUARD, 1], [0, GUARD, 1.0]])
    assert outcodes(points, PLANES).tolist() == [0] * 6
    outward = np.array([[0, 0, -1], [0, 0, 1], [-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0]])
    assert outcodes(points + 1e-9 * outward, PLANES).tolist()[:2] == [1, 2]
    assert outcodes(points + 1e-9 * outward, PLANES).tolist()[2:] == [4, 8, 16, 32]


def test_sides_of_a_parallel_view_do_not_depend_on_depth() -> None:
    points = np.array([[GUARD, 0.0, 0.0], [-GUARD, 0.0, 9.0], [0.0, 2.5, 3.0]])
    assert outcodes(points, view_volume(0.0, 9.0, False)).tolist() == [0, 0, 32]


def test_what_is_not_a_number_is_outside() -> None:
    assert outcodes(np.array([[np.nan, 0.0, 2.0], [0.0, 0.0, np.nan]]), PLANES).all()


def test_nothing_to_cut_costs_nothing() -> None:
    points = np.array([[0, 0, 2], [1, 0, 2], [0, 1, 2.0]])
    corner, start = np.array([0, 1, 2], np.int32), np.array([0, 3], np.int32)
    same = clip_polygons(points, corner, start, PLANES)
    assert same[0] is points and same[1] is corner and same[2] is start


def test_near_cuts_a_triangle_to_a_quadrilateral() -> None:
    (loop,) = clip([[0, 0, 3], [0.5, 0, 3], [0.5, 0.5, -1]], [[0, 1, 2]])
    assert loop.tolist() == [[0, 0, 3], [0.5, 0, 3], [0.5, 0.25, 1], [0.25, 0.25, 1]]


def test_cut_points_lie_exactly_on_near_however_long_the_edge() -> None:
    (loop,) = clip([[0, 0, 3], [1e-3, 0, 3], [7e17, 3e17, -1e18]], [[0, 1, 2]])
    assert len(loop) == 4 and (loop[2:, 2] == 1.0).all()


def test_far_side_of_an_infinite_view_cuts_nothing() -> None:
    (loop,) = clip([[0, 0, 3], [1, 0, 3], [1, 1, 1e300]], [[0, 1, 2]], view_volume(1.0, np.inf, True))
    assert len(loop) == 3


def test_outside_polygons_keep_their_place() -> None:
    points = [[0, 0, 2], [1, 0, 2], [0, 1, 2], [0, 0, -2], [1, 0, -2], [0, 1, 0.5]]
    whole, gone, again = clip(points, [[0, 1, 2], [3, 4, 5], [2, 0, 1]])
    assert len(gone) == 0
    assert np.array_equal(whole, np.array(points[:3])) and np.array_equal(again[1:], whole[:2])


def test_polygon_around_the_view_becomes_its_guard_band() -> None:
    big = 1e6
    (loop,) = clip([[-big, -big, 2], [big, -big, 2], [big, big, 2], [-big, big, 2]], [[0, 1, 2, 3]])
    assert {tuple(point) for point in loop} == {(x, y, 2.0) for x in (-4.0, 4.0) for y in (-4.0, 4.0)}


coordinate = st.floats(-1e3, 1e3)
points = st.lists(st.tuples(coordinate, coordinate, st.floats(-20, 20)), min_size=4, max_size=4)


@settings(max_examples=60, deadline=None)
@given(points)
def test_neighbours_cut_their_common_edge_alike(corners: list[tuple[float, float, float]]) -> None:
    """Triangles 0 1 2 and 1 0 3: every point of the edge 0 1 that one has, the other has too."""
    a, b = (set(map(tuple, loop)) for loop in clip(list(map(list, corners)), [[0, 1, 2], [1, 0, 3]]))
    alone = clip(list(map(list, corners)), [[0, 1, 0]])[0]
    edge = set(map(tuple, alone))
    if not a or not b:  # wholly outside of one plane
        return
    assert edge & a == edge & b == edge


@settings(max_examples=60, deadline=None)
@given(points)
def test_what_is_left_is_inside(corners: list[tuple[float, float, float]]) -> None:
    (loop,) = clip(list(map(list, corners)), [[0, 1, 2]])
    homogeneous = np.column_stack([loop, np.ones(len(loop))])
    # A cut point on one plane is off another by the rounding of coordinates up to 1e3.
    assert (homogeneous @ PLANES.T >= -1e-11).all()


@pytest.mark.parametrize("turn", [0, 1, 2])
def test_the_first_corner_does_not_matter(turn: int) -> None:
    triangle = [[0, 0, 3], [1, 0, 3], [1, 1, -1]]
    (loop,) = clip([triangle[(k + turn) % 3] for k in range(3)], [[0, 1, 2]])
    (plain,) = clip(triangle, [[0, 1, 2]])
    assert set(map(tuple, loop)) == set(map(tuple, plain))
