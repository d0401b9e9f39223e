"""Embree's test of a ray with a triangle."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from hsr.models.embree.float32 import MISS, distances

DOWN = np.array([0.0, 0.0, -1.0], dtype=np.float32)
FAR = np.float32(np.inf)
SQUARE = np.array([[[0, 0, 0], [4, 0, 0], [4, 4, 0]], [[0, 0, 0], [4, 4, 0], [0, 4, 0]]], dtype=np.float32)


def nearest_triangle(
    origin: np.ndarray, direction: np.ndarray, corners: np.ndarray, reach: np.float32
) -> int:
    """Return the number of the nearest triangle, the first of equally near ones; -1 for a miss."""
    t = distances(origin, direction, corners, reach)
    return int(t.argmin()) if t.min() < MISS else -1


def hit(x: float, y: float, corners: np.ndarray = SQUARE, reach: np.float32 = FAR) -> int:
    return nearest_triangle(np.array([x, y, 2.0], dtype=np.float32), DOWN, corners, reach)


@pytest.mark.parametrize(("x", "y", "expected"), [(3, 1, 0), (1, 3, 1), (5, 1, -1), (-1, 1, -1)])
def test_a_ray_hits_the_triangle_it_passes_through(x: float, y: float, expected: int) -> None:
    assert hit(x, y) == expected
    assert hit(x, y, SQUARE[:, ::-1].copy()) == expected


def test_edges_and_corners_are_hit_the_first_triangle_counts() -> None:
    assert hit(1, 1) == 0
    assert hit(1, 1, SQUARE[::-1].copy()) == 0
    assert hit(2, 0) == 0
    assert hit(0, 0) == 0


def test_the_nearest_counts() -> None:
    raised = SQUARE[:1] + np.array([0, 0, 1], dtype=np.float32)
    assert hit(3, 1, np.concatenate([SQUARE, raised])) == 2


def test_the_ends_of_a_ray_belong_to_it() -> None:
    assert hit(3, 1, reach=np.float32(2.0)) == 0
    assert hit(3, 1, reach=np.nextafter(np.float32(2.0), np.float32(0.0))) == -1
    assert hit(3, 1, SQUARE + np.array([0, 0, 2], dtype=np.float32)) == 0
    assert hit(3, 1, SQUARE + np.array([0, 0, 3], dtype=np.float32)) == -1


def test_a_triangle_seen_edge_on_is_missed() -> None:
    assert hit(1, 0, np.array([[[0, 0, 0], [4, 0, 0], [4, 0, 1]]], dtype=np.float32)) == -1


def test_no_ray_slips_between_two_triangles() -> None:
    """Rays through the middle of the shared edge, or as near to it as float32 can be."""
    random = np.random.default_rng(1)
    for _ in range(300):
        a, b, c, d = random.normal(size=(4, 3)).astype(np.float32)
        c[0] += 4.0
        d[0] -= 4.0
        origin = np.array([0.0, 0.0, 30.0], dtype=np.float32)
        weight = np.float32(random.uniform(0.1, 0.9))
        direction = (a + weight * (b - a) - origin).astype(np.float32)
        assert nearest_triangle(origin, direction, np.stack([[a, b, c], [b, a, d]]), FAR) >= 0


def side(p: list[Fraction], q: list[Fraction], d: list[Fraction]) -> Fraction:
    x, y, z = (p[k - 2] * q[k - 1] - p[k - 1] * q[k - 2] for k in range(3))
    return x * d[0] + y * d[1] + z * d[2]


def test_clear_cases_are_those_of_exact_arithmetic() -> None:
    random = np.random.default_rng(2)
    seen = set()
    for _ in range(300):
        corners = random.normal(size=(1, 3, 3)).astype(np.float32)
        origin = np.array([0.0, 0.0, 4.0], dtype=np.float32)
        direction = (random.normal(scale=0.3, size=3) - origin).astype(np.float32)
        v = [
            [Fraction(float(x)) - Fraction(float(o)) for x, o in zip(p, origin, strict=True)]
            for p in corners[0]
        ]
        d = [Fraction(float(x)) for x in direction]
        sides = [side(v[k - 2], v[k - 1], d) for k in range(3)]
        if min(map(abs, sides)) > 1e-4:
            expected = min(sides) > 0 or max(sides) < 0
            seen.add(expected)
            assert (nearest_triangle(origin, direction, corners, FAR) == 0) == expected
    assert seen == {True, False}


def test_embree_finds_the_same() -> None:
    """Bit for bit what the library decides, for rays aimed at edges."""
    construction = pytest.importorskip("embreex.mesh_construction")
    scenes = pytest.importorskip("embreex.rtcore_scene")
    random = np.random.default_rng(3)
    vertices = random.normal(size=(60, 3)).astype(np.float32)
    corner = np.array([random.permutation(60)[:3] for _ in range(40)], dtype=np.int32)
    origins = np.tile(np.array([0.1, 0.2, 6.0], dtype=np.float32), (400, 1))
    ends = vertices[corner[random.integers(0, 40, 400)]]
    aims = ends[:, 0] + random.uniform(0, 1, (400, 1)).astype(np.float32) * (ends[:, 1] - ends[:, 0])
    directions = (aims - origins).astype(np.float32)
    scene = scenes.EmbreeScene(robust=True)
    construction.TriangleMesh(scene, vertices, corner)
    theirs = scene.run(origins, directions, output=True)["primID"]
    ours = [nearest_triangle(o, d, vertices[corner], FAR) for o, d in zip(origins, directions, strict=True)]
    assert np.array_equal(theirs, ours)
