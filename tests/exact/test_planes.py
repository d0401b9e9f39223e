"""Triangles in the frame of a view."""

from __future__ import annotations

import numpy as np
import pytest

from hsr.exact.numbers import frame_of
from hsr.exact.planes import Triangles, plane_name, ratio, triangles_of
from hsr.problem.view import View, view
from tests.exact.hard import scene

DOWN = {"type": "orthographic", "eye": [0.0, 0.0, 3.0], "height": 4.0, "far": 9.0}


def triangle(corners: list[list[float]], **more: object) -> dict[str, object]:
    return {"shape": "mesh", "vertices": corners, "faces": [[0, 1, 2]], **more}


def triangles(*objects: dict[str, object], **camera: object) -> tuple[View, Triangles]:
    seen = view(scene(list(objects), {**DOWN, **camera}), (4, 4))
    return seen, triangles_of(seen, frame_of(seen), np.arange(seen.width * seen.height))


def test_half_planes_are_against_the_corners_in_turn() -> None:
    _, one = triangles(triangle([[0, 0, 0], [1, 0, 0], [0, 1, 0]]))
    # A world unit is two units of (i, j).
    expected = [(-1, -1, 2), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 1)]
    assert [tuple(np.array(half) // max(np.gcd.reduce(half), 1)) for half in one.half[0]] == expected
    assert one.det[0] > 0
    assert one.box.tolist() == [[1, 2, 1, 2]]
    assert (one.zeta[0] > 0).tolist() == [False, False, True]


def test_clockwise_triangles_are_turned_round_or_culled() -> None:
    back = [[0, 0, 0], [0, 1, 0], [1, 0, 0]]
    assert triangles(triangle(back))[1].det[0] > 0
    assert len(triangles(triangle(back, cull="back"))[1]) == 0
    assert len(triangles(triangle(back, cull="front"))[1]) == 1


@pytest.mark.parametrize(
    "corners",
    [
        [[0, 0, 0], [1, 0, 0], [2, 0, 0]],
        [[0, 0, 0], [0, 1, 0], [0, 1, 1]],
        [[5, 0, 0], [6, 0, 0], [5, 1, 0]],
        [[0.1, 0.1, 0], [0.2, 0.1, 0], [0.1, 0.2, 0]],
        [[0, 0, 4], [1, 0, 4], [0, 1, 4]],
        [[0, 0, -7], [1, 0, -7], [0, 1, -7]],
    ],
    ids=["collinear", "edge-on", "beside the image", "between samples", "nearer than near", "beyond far"],
)
def test_what_covers_no_sample_is_left_out(corners: list[list[float]]) -> None:
    assert len(triangles(triangle(corners))[1]) == 0


def test_limits_are_told_only_where_they_cut() -> None:
    flat, cut = [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [1, 0, 4], [0, 1, 0]]
    _, kept = triangles(triangle(flat), triangle(cut))
    cuts = (kept.half[:, 3:] != np.array([0, 0, 1])).any(axis=2)
    assert cuts.tolist() == [[False, False], [True, False]]


def test_an_edge_of_two_triangles_is_the_same_line() -> None:
    faces = [[0, 1, 2], [2, 1, 3]]
    corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.3], [0.0, 1.0, 0.1], [1.0, 1.0, 0.7]]
    _, two = triangles({"shape": "mesh", "vertices": corners, "faces": faces})
    # Corner 0 of the first triangle and corner 2 of the second lie opposite their shared edge.
    assert (two.half[0, 0] == -two.half[1, 2]).all()


def test_planes_have_one_name() -> None:
    assert plane_name([2, -4, 6, -2]) == plane_name([-3, 6, -9, 3]) == (-1, 2, -3, 1)


def test_ratios_beyond_float64_are_infinite() -> None:
    big = np.array([10**400, -(10**400), 1], dtype=object)
    assert ratio(big, np.array([3, 3, 3], dtype=object)).tolist() == [np.inf, -np.inf, 1 / 3]
