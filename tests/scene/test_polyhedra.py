"""Convex polyhedra: what is accepted, and which face is blamed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from hsr.base.arrays import Floats
from hsr.scene.polyhedra import convexity_problems

CUBE = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=np.float64)
LOOPS = [(6, 7, 3, 2), (0, 1, 5, 4), (5, 1, 3, 7), (0, 4, 6, 2), (4, 5, 7, 6), (1, 0, 2, 3)]


def dodecahedron() -> tuple[Floats, list[tuple[int, ...]]]:
    """Corners with golden-section coordinates, and its faces from the planes of its convex hull."""
    g = (1.0 + np.sqrt(5.0)) / 2.0
    corners = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    for s in (-1, 1):
        for t in (-1, 1):
            corners += [[0, s / g, t * g], [s / g, t * g, 0], [s * g, 0, t / g]]
    points = np.array(corners, dtype=np.float64)
    normals = np.unique(ConvexHull(points).equations[:, :3].round(9), axis=0)
    return points, [loop_of(points, normal) for normal in normals]


def loop_of(points: Floats, normal: Floats) -> tuple[int, ...]:
    height = points @ normal
    members = np.flatnonzero(height > height.max() - 1e-6)
    centre = points[members].mean(axis=0)
    x = points[members[0]] - centre
    y = np.cross(normal, x)
    angle = np.arctan2((points[members] - centre) @ y, (points[members] - centre) @ x)
    return tuple(int(member) for member in members[np.argsort(angle)])


def turned(points: Floats, seed: int, size: float) -> Floats:
    """Turn, scale and move, with the rounding that comes with it."""
    random = np.random.default_rng(seed)
    rotation, _ = np.linalg.qr(random.normal(size=(3, 3)))
    if np.linalg.det(rotation) < 0:
        rotation[0] *= -1.0
    return size * (points @ rotation.T + random.uniform(-3, 3, 3))


def test_a_cube_is_convex() -> None:
    assert convexity_problems(CUBE, LOOPS) == []


@given(st.integers(0, 10_000), st.sampled_from([1e-30, 1e-3, 1.0, 1e6, 1e60]))
@settings(deadline=None, max_examples=40)
def test_rounded_corners_are_planar_enough(seed: int, size: float) -> None:
    points, loops = dodecahedron()
    assert len(loops) == 12
    assert convexity_problems(turned(points, seed, size), loops) == []
    assert convexity_problems(turned(CUBE, seed, size), LOOPS) == []


@given(st.integers(0, 10_000), st.sampled_from([1e-30, 1.0, 1e60]))
@settings(deadline=None, max_examples=40)
def test_what_is_not_rounding_is_noticed(seed: int, size: float) -> None:
    points, loops = dodecahedron()
    points[seed % 20] *= 1.0 + 1e-11
    problems = convexity_problems(turned(points, seed, size), loops)
    assert len(problems) == 3 and all("its corners are not in one plane" in problem for problem in problems)


def test_coplanar_neighbours_are_allowed() -> None:
    loops = [(6, 7, 3), (6, 3, 2), *LOOPS[1:]]
    assert convexity_problems(CUBE, loops) == []


def test_a_corner_within_an_edge_is_allowed() -> None:
    points = np.concatenate([CUBE, [[0.0, 1.0, 1.0]]])
    loops = [(6, 8, 7, 3, 2), *LOOPS[1:4], (4, 5, 7, 8, 6), LOOPS[5]]
    assert convexity_problems(points, loops) == []


PYRAMID = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, 0, 1]], dtype=np.float64)
SIDES = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]


@pytest.mark.parametrize(
    ("points", "loops", "problems"),
    [
        (
            CUBE,
            [LOOPS[0][::-1], *LOOPS[1:]],
            ["faces[0]: its corners run clockwise as seen from outside; reverse them"],
        ),
        (
            CUBE,
            [loop[::-1] for loop in LOOPS],
            [f"faces[{k}]: its corners run clockwise as seen from outside; reverse them" for k in range(6)],
        ),
        (CUBE, LOOPS[1:], ["faces: the solid is not closed: no face runs along the edge from vertex 7 to 3"]),
        (CUBE, [*LOOPS, LOOPS[0]], ["faces: 2 faces run along the edge from vertex 6 to 7; one may"]),
        (CUBE, [(6, 7, 3, 3), *LOOPS[1:]], ["faces[0]: it names a vertex twice"]),
        (
            CUBE,
            [(6, 3, 7, 2), *LOOPS[1:]],
            ["faces[0]: it has no area: its corners lie on one line, or it crosses itself"],
        ),
        (
            np.concatenate([CUBE, [[0.0, 1.5, 0.0]]]),
            LOOPS,
            ["faces[0]: vertex 8 is in front of it: the solid is not convex"],
        ),
        (np.concatenate([CUBE, [[0.0, 0.0, 0.0]]]), LOOPS, ["vertices: no face uses vertex 8; leave it out"]),
        (
            np.concatenate([CUBE, CUBE[:1]]),
            [*LOOPS, (0, 8, 1)],
            ["faces[6]: two neighbouring corners are in one place"],
        ),
        (
            PYRAMID * [1, 1, -1],
            [(0, 1, 2, 3), *SIDES],
            [
                f"faces[{k}]: its corners run clockwise as seen from outside; reverse them"
                for k in range(1, 5)
            ],
        ),
        (
            np.concatenate([CUBE, [[0.0, 1.0, 1.0]]]),
            [*LOOPS, (6, 8, 7)],
            ["faces[6]: it has no area: its corners lie on one line, or it crosses itself"],
        ),
    ],
)
def test_the_face_to_blame(points: Floats, loops: list[tuple[int, ...]], problems: list[str]) -> None:
    assert convexity_problems(points, loops) == problems


def test_a_star_is_no_convex_face() -> None:
    angle = 2.0 * np.pi * np.arange(5) / 5
    base = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(5)])
    points = np.concatenate([base, [[0.0, 0.0, 1.0]]])
    star = (0, 3, 1, 4, 2)
    sides = [(k, (k + 1) % 5, 5) for k in range(5)]
    assert convexity_problems(points, [star, *sides]) == [
        "faces[0]: its corners do not run once around a convex polygon"
    ]


def test_two_solids_are_not_one_convex_solid() -> None:
    points = np.concatenate([CUBE, CUBE + np.array([5.0, 0.0, 0.0])])
    loops = [*LOOPS, *(tuple(k + 8 for k in loop) for loop in LOOPS)]
    assert any("the solid is not convex" in problem for problem in convexity_problems(points, loops))
