"""Whether a mesh bounds a solid; self-contact is held against a separating-axis test in integers."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest

from hsr.base.arrays import Array, Floats
from hsr.scene import solids
from hsr.scene.shapes import Polygons, generic, tessellated
from hsr.scene.solids import surface_problem, winding_number
from hsr.scene.values import exact_determinant

CUBE = generic("cube").polygons
assert CUBE is not None
CORNERS, TRIANGLES = CUBE.vertices, CUBE.triangle_vertex


def mesh(vertices: Floats, triangles: Array) -> Polygons:
    return Polygons.of_rows(vertices, triangles)


def two_cubes(offset: list[float], size: float = 1.0) -> Polygons:
    vertices = np.concatenate([CORNERS, CORNERS * size + offset])
    return mesh(vertices, np.concatenate([TRIANGLES, TRIANGLES + 8]))


@pytest.mark.parametrize(
    ("polygons", "problem"),
    [
        (CUBE, ""),
        (tessellated(generic("sphere"), 16).polygons, ""),
        (tessellated(generic("cylinder"), 16).polygons, ""),
        (two_cubes([3, 0, 0]), ""),
        (two_cubes([2 + 2**-51, 0.3, 0.1]), ""),
        (two_cubes([0, 0, 0], 0.5), ""),
        (mesh(CORNERS[TRIANGLES].reshape(-1, 3), np.arange(36).reshape(-1, 3)), ""),
        (mesh(CORNERS, np.concatenate([TRIANGLES, [[0, 0, 1]]])), ""),
        (mesh(CORNERS, TRIANGLES[1:]), "not closed: 3 edges belong to one face only"),
        (
            mesh(CORNERS, np.concatenate([TRIANGLES[:1, ::-1], TRIANGLES[1:]])),
            "not closed: 3 edges are not run through equally often both ways",
        ),
        (mesh(CORNERS, TRIANGLES[:, ::-1]), "inside out: 1 of its 1 parts enclose no positive volume"),
        (mesh(CORNERS, np.concatenate([TRIANGLES[:1], TRIANGLES[:1, ::-1]])), "inside out: 1 of its 1 parts"),
        (two_cubes([5, 0, 0], -1.0), "inside out: 1 of its 2 parts enclose no positive volume"),
        (two_cubes([2, 0.3, 0.1]), "touches or crosses itself: faces "),
        (two_cubes([2 - 2**-52, 0.3, 0.1]), "touches or crosses itself: faces "),
        (two_cubes([0.5, 0.3, 0.2]), "touches or crosses itself: faces "),
        (two_cubes([0, 0, 0]), "touches or crosses itself: faces "),
        (mesh(CORNERS, TRIANGLES[:0]), "not closed: it has no area"),
    ],
)
def test_solids_and_others(polygons: Polygons, problem: str) -> None:
    found = surface_problem(polygons)
    assert found.startswith(problem) if problem else found == ""


def test_negative_zero_is_zero() -> None:
    vertices = CORNERS - 1.0
    split = vertices[TRIANGLES].reshape(-1, 3)
    split[::2][split[::2] == 0.0] = -0.0
    assert surface_problem(mesh(split, np.arange(36).reshape(-1, 3))) == ""


def test_large_meshes_are_not_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solids, "MAX_CHECKED", 23)
    assert surface_problem(two_cubes([0.5, 0.3, 0.2])).startswith("not checked: more than 23 triangles")


def test_the_search_finds_every_pair_whose_extents_overlap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solids, "CHUNK", 50)
    corners = np.random.default_rng(5).integers(0, 9, size=(60, 3, 3)).astype(np.float64)
    low, high = corners.min(axis=1), corners.max(axis=1)
    expected = {
        (i, j)
        for i, j in itertools.combinations(range(60), 2)
        if (low[i] <= high[j]).all() and (low[j] <= high[i]).all()
    }
    found = [
        (min(i, j), max(i, j))
        for first, second in solids._overlapping_pairs(corners)
        for i, j in zip(first.tolist(), second.tolist(), strict=True)
    ]
    assert len(found) == len(set(found)) and set(found) == expected


# ---------------------------------------------------------------- two triangles


def separated(one: Array, other: Array) -> bool:
    """Whether convex polygons (n, 3) of integers in space are apart: the separating-axis theorem."""
    edges_one = np.roll(one, -1, axis=0) - one
    edges_other = np.roll(other, -1, axis=0) - other
    normals = [np.cross(edges[0], edges[1]) for edges in (edges_one, edges_other)]
    axes = [*normals, *(np.cross(a, b) for a in edges_one for b in edges_other)]
    axes += [np.cross(normals[0], edge) for edge in (*edges_one, *edges_other)]
    for axis in axes:
        p, q = one @ axis, other @ axis
        if p.max() < q.min() or q.max() < p.min():
            return True
    return False


def meet_by_definition(points: Array, one: Array, other: Array) -> bool:
    """Whether triangles meet outside their common corners and edges.

    A shared corner is cut off, so near it that nothing else on this lattice can be lost.
    """
    shared = set(one.tolist()) & set(other.tolist())
    if len(shared) == 3:
        return True
    if len(shared) == 2:
        a, b = (points[k] for k in sorted(shared))
        p, q = (points[(set(triangle.tolist()) - shared).pop()] for triangle in (one, other))
        coplanar = np.cross(b - a, p - a) @ (q - a) == 0
        return bool(coplanar and np.cross(b - a, p - a) @ np.cross(b - a, q - a) > 0)
    near = 10**6
    corners, rest = points[one] * near, points[other] * near
    if shared:
        (corner,) = shared
        a, b, c = (points[k] for k in np.roll(one, -one.tolist().index(corner)))
        corners = np.array([a * near + (b - a), b * near, c * near, a * near + (c - a)])
    return not separated(corners, rest)


@pytest.mark.parametrize("flat", [False, True])
@pytest.mark.parametrize("shared", [0, 1, 2, 3])
def test_two_triangles_meet_when_the_definition_says_so(shared: int, flat: bool) -> None:
    random = np.random.default_rng(10 * shared + flat)
    seen = set()
    for _ in range(400):
        points = random.integers(0, 4, size=(6, 3)).astype(object)
        if flat:
            points[:, 2] = points[:, 0] + points[:, 1]
        one, other = np.array([0, 1, 2]), np.array([*random.permutation(3)[:shared], 3, 4, 5])[:3]
        other = random.permutation(other)
        normals = [np.cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]) for t in (one, other)]
        different = len({tuple(point) for point in points[sorted({*one, *other})]}) == 6 - shared
        if not (normals[0].any() and normals[1].any() and different):
            continue
        space = solids._Space(points.astype(np.float64) / 8.0, points)
        found = bool(solids._meet(space, one[None], other[None])[0])
        assert found == meet_by_definition(points, one, other), (points, one, other)
        seen.add(found)
    assert seen == ({True} if shared == 3 else {False, True})


def test_sides_are_exact_where_floats_are_in_doubt() -> None:
    """Points a few ulps around the line through (12, 12) and (24, 24), all divided by 32."""
    line = [[12.0, 12.0, 0.0], [24.0, 24.0, 0.0], [1.0, 2.0, 16.0]]
    near = [[0.5 + i * 2.0**-53, 0.5 + j * 2.0**-53, 0.0] for i in range(16) for j in range(16)]
    points = np.array(line + near) / 32.0
    d = np.arange(3, len(points))
    a, b, c = (np.full(len(d), k) for k in range(3))
    found = solids._Space(points, solids._integers(points)).side(a, b, c, d)
    exact = [
        exact_determinant(
            [[Fraction(p) - Fraction(q) for p, q in zip(row, point, strict=True)] for row in points[:3]]
        )
        for point in points[3:]
    ]
    assert found.tolist() == [(value > 0) - (value < 0) for value in exact]
    assert set(found.tolist()) == {-1, 0, 1}


# ---------------------------------------------------------------- inside


def test_the_winding_number_is_one_inside_and_zero_outside() -> None:
    corners = CORNERS[TRIANGLES]
    assert winding_number(np.array([0.9, -0.9, 0.5]), corners) == pytest.approx(1.0)
    assert winding_number(np.array([1.1, 0.0, 0.0]), corners) == pytest.approx(0.0, abs=1e-12)
    assert winding_number(np.zeros(3), corners[:, ::-1]) == pytest.approx(-1.0)
