"""Polygons cut into triangles, judged by areas in whole numbers and by which points they hold."""

from __future__ import annotations

import math
import time
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hsr.base.errors import SceneError
from hsr.scene import triangulation
from hsr.scene.shapes import Polygons
from hsr.scene.triangulation import triangulated

Loop = list[tuple[int, int]]


def star(seed: int, size: int) -> Loop:
    """A simple polygon, as its corners are sorted by their angles about the origin; seldom convex."""
    random = np.random.default_rng(seed)
    points = [(int(x), int(y)) for x, y in random.integers(-1000, 1000, (size, 2)) if x or y]
    by_angle = {math.atan2(y, x): (x, y) for x, y in [(999, 1), (-1, 999), (-999, -3), *points]}
    loop = [by_angle[angle] for angle in sorted(by_angle)]
    first = int(random.integers(len(loop)))
    return loop[first:] + loop[:first]


def comb(teeth: int) -> Loop:
    return [(0, -1), (2 * teeth, -1), *((x, 9 * (x % 2)) for x in range(2 * teeth, -1, -1))]


def spiral(turns: int) -> Loop:
    angles = np.arange(12 * turns) * math.tau / 12
    out, back = (
        [
            (round(r * math.cos(t)), round(r * math.sin(t)))
            for t, r in zip(angles, far + 100 * angles, strict=True)
        ]
        for far in (1000, 900)
    )
    return out + back[::-1]


KEYHOLE = [(0, 0), (9, 0), (9, 9), (0, 9), (0, 0), (3, 3), (3, 6), (6, 6), (6, 3), (3, 3)]
LOOPS = {
    "arrow": [(0, 1), (-4, 4), (0, 0), (4, 4)],
    "comb": comb(9),
    "spiral": spiral(4),
    "keyhole": KEYHOLE,
    "straight corners": [(0, 0), (2, 0), (4, 0), (4, 4), (2, 4), (2, 2), (0, 2), (0, 1)],
    "corner twice": [(0, 0), (4, 0), (4, 0), (1, 1), (1, 1), (0, 4)],
    "spike": [(0, 0), (4, 0), (9, 0), (4, 0), (1, 1), (0, 4)],
    **{f"star {seed}": star(seed, 4 + seed) for seed in range(30)},
}


def cut(*loops: Loop) -> tuple[list[list[int]], int]:
    corners = [(x, y, 0) for loop in loops for x, y in loop]
    ends = np.cumsum([0, *map(len, loops)])
    polygons = Polygons.of(
        np.array(corners, np.float64), [range(ends[k], ends[k + 1]) for k in range(len(loops))]
    )
    triangles, concave = triangulated(polygons)
    return triangles.tolist(), concave


def area(*points: tuple[int, int]) -> int:
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(points, points[1:] + points[:1], strict=True))


def winding(point: tuple[Fraction, Fraction], loop: Loop) -> int:
    """How often a polygon runs around a point of which no corner has the height."""
    x, y = point
    total = 0
    for (ax, ay), (bx, by) in zip(loop, loop[1:] + loop[:1], strict=True):
        if (ay < y) != (by < y):
            left = (bx - ax) * (y - ay) - (x - ax) * (by - ay)
            total += 1 if by > ay and left > 0 else -1 if by < ay and left < 0 else 0
    return total


@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.parametrize("turned", [1, -1])
def test_a_simple_polygon_is_covered_once(name: str, turned: int) -> None:
    loop = LOOPS[name][::turned]
    triangles, _ = cut(loop)
    corners = [[loop[k] for k in triangle] for triangle in triangles]
    sign = 1 if area(*loop) > 0 else -1
    assert len(triangles) == len(loop) - 2
    assert all(sign * area(*three) >= 0 for three in corners)
    assert sum(area(*three) for three in corners) == area(*loop)
    random = np.random.default_rng(len(loop))
    (low_x, low_y), (high_x, high_y) = np.min(loop, axis=0), np.max(loop, axis=0)
    for _ in range(100):
        x, y = int(random.integers(7 * low_x, 7 * high_x)), int(random.integers(7 * low_y, 7 * high_y))
        point = Fraction(2 * x + 1, 14), Fraction(2 * y + 1, 14) + Fraction(1, 1001)
        assert sum(winding(point, three) for three in corners) == winding(point, loop)


@pytest.mark.parametrize("first", range(4))
def test_an_arrow_is_cut_at_its_inner_corner(first: int) -> None:
    loop = LOOPS["arrow"][first:] + LOOPS["arrow"][:first]
    triangles, concave = cut(loop)
    reflex = loop.index((0, 0))
    # From the inner corner and from the one across, the fan is right.
    assert concave == reflex % 2
    assert triangles == ([[0, 1, 2], [0, 2, 3]] if reflex % 2 == 0 else [[1, 2, 3], [1, 3, 0]])


@given(st.integers(0, 2**32), st.integers(3, 12), st.floats(-150, 150))
def test_convex_polygons_keep_their_fan(seed: int, size: int, power: float) -> None:
    random = np.random.default_rng(seed)
    angles = np.sort(random.uniform(0, math.tau, size))
    flat = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(size)])
    axes = random.normal(size=(3, 3)) * 2.0**power
    polygons = Polygons.of(flat @ axes + random.normal(size=3) * 2.0**power, [range(size)])
    triangles, concave = triangulated(polygons)
    assert concave == 0 and triangles.tolist() == [[0, k, k + 1] for k in range(1, size - 1)]


@given(st.lists(st.tuples(st.integers(-3, 3), st.integers(-3, 3)), min_size=4, max_size=10))
def test_no_polygon_is_too_degenerate(loop: Loop) -> None:
    triangles, _ = cut(loop)
    assert len(triangles) == len(loop) - 2
    corners = [[loop[k] for k in triangle] for triangle in triangles]
    assert sum(area(*three) for three in corners) == area(*loop)


def test_a_polygon_is_cut_as_seen_along_its_normal() -> None:
    # Along z, the arrow would be convex.
    points = np.array([[0, 1, 0], [-4, 4, 1e-3], [0, 0, 0], [4, 4, -1e-3]])
    for axes in ([0, 1, 2], [2, 0, 1], [1, 2, 0]):
        assert triangulated(Polygons.of(points[:, axes], [range(4)]))[1] == 0
        assert triangulated(Polygons.of(points[:, axes], [(1, 2, 3, 0)]))[1] == 1


def test_signs_are_exact_far_from_the_origin() -> None:
    far, step = 2.0**40, 2.0**-12
    corners = [(0, 0), (2, 1), (4, 2), (6, 3 + step), (0, 9)]
    points = np.array([(far + x, far + y, far) for x, y in corners])
    assert triangulated(Polygons.of(points, [range(5)]))[1] == 0
    bent = points.copy()
    bent[2, 1] += step
    triangles, concave = triangulated(Polygons.of(bent, [(1, 2, 3, 4, 0)]))
    assert concave == 1 and [1, 2, 3] not in triangles.tolist()


def test_many_polygons_keep_their_places(monkeypatch: pytest.MonkeyPatch) -> None:
    loops = [LOOPS["arrow"], [(0, 0), (1, 0), (0, 1)], comb(3), [(0, 0), (1, 0), (1, 1), (0, 1)], KEYHOLE]
    monkeypatch.setattr(triangulation, "CHUNK", 3)
    triangles, concave = cut(*loops)
    assert concave == 2
    start = 0
    for loop in loops:
        alone, _ = cut(loop)
        shifted = [[k + start for k in triangle] for triangle in alone]
        assert triangles[start - 2 * loops.index(loop) :][: len(alone)] == shifted
        start += len(loop)


def test_work_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    start = time.perf_counter()
    triangles, _ = cut(star(1, 1000))
    assert len(triangles) > 900 and time.perf_counter() - start < 10.0
    monkeypatch.setattr(triangulation, "MAX_WORK", 10)
    with pytest.raises(SceneError, match="cut them into triangles"):
        cut(spiral(9), spiral(9))
