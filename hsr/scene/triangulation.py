"""Cutting polygons into triangles: as a fan where that is right, else ear by ear. Every sign is exact.

A polygon is seen along the axis in which its normal, by Newell, is longest. There the fan of triangles
about its first corner is right if none of them is turned around: together, the signed triangles wind
around every point as often as the polygon does, and nothing is covered twice without one of the other
sign. So it is for every convex polygon, and for those that see all of themselves from that corner.

Where it is not, ears are cut off: a corner b between a and c, if the triangle a b c is not turned around
and no other corner lies in it. Every triangle cut off winds around what the polygon loses, so even of a
polygon that crosses itself the signed triangles are all of it. Sources: Tampieri, Newell's Method for
Computing the Plane Equation of a Polygon, Graphics Gems III (1992); Meisters, Polygons Have Ears, The
American Mathematical Monthly 82 (1975).
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from hsr.base.arrays import Floats, Ints
from hsr.base.errors import SceneError
from hsr.scene.shapes import Polygons

CHUNK = 1 << 16
"""Triangles looked at together, to bound the memory."""

# Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates, Discrete
# & Computational Geometry 18 (1997), bound A of orient2d; and more than its products lose by underflow.
ERROR, UNDERFLOW = (3.0 + 16.0 * 2.0**-53) * 2.0**-53, 2.0**-1000

MAX_WORK = 30_000_000
"""Corners that may be looked at, of all polygons: a spiral takes the square of its corners."""


def triangulated(polygons: Polygons) -> tuple[Ints, int]:
    """Cut polygons into triangles that cover them.

    Parameters
    ----------
    polygons : Polygons
        They need be neither convex nor planar.

    Returns
    -------
    triangles : (n, 3) int32
        Vertex indices, polygon after polygon; of each, two less than its corners.
    concave : int
        How many polygons are not cut into the fan about their first corner, which would not cover them.

    Raises
    ------
    SceneError
        If that takes too long.
    """
    triangles = polygons.triangle_vertex.copy()
    concave, work = 0, 0
    for k in _doubtful(polygons):
        loop = polygons.corner[polygons.start[k] : polygons.start[k + 1]]
        ring = _Ring(*_seen(polygons.vertices[loop]))
        if not ring.is_fan:
            first = polygons.start[k] - 2 * k
            triangles[first : first + len(loop) - 2] = loop[[*ring.ears(MAX_WORK - work)]]
            concave, work = concave + 1, work + ring.work
    return triangles, concave


def _doubtful(polygons: Polygons) -> Iterator[int]:
    """Yield the polygons of which float64 does not show that all triangles of the fan have one sign."""
    sides = np.diff(polygons.start)
    first = polygons.start - 2 * np.arange(len(sides) + 1)
    cuts = np.unique(np.searchsorted(first, [*range(0, first[-1], CHUNK), first[-1]]))
    for low, high in pairwise(cuts) if (sides > 3).any() else ():
        start = first[low:high] - first[low]
        a, b, c = np.moveaxis(polygons.vertices[polygons.triangle_vertex[first[low] : first[high]]], 1, 0)
        p, q = b - a, c - a
        plus, minus = (np.roll(p, -i, axis=1) * np.roll(q, i - 3, axis=1) for i in (1, 2))
        area = plus - minus
        axis = np.abs(np.add.reduceat(area, start)).argmax(axis=1)
        each = np.arange(len(area)), np.repeat(axis, sides[low:high] - 2)
        error = ERROR * (np.abs(plus) + np.abs(minus)) + UNDERFLOW
        one_sign = np.logical_and.reduceat((area > error)[each], start)
        one_sign |= np.logical_and.reduceat((area < -error)[each], start)
        yield from (low + np.flatnonzero(~one_sign & (sides[low:high] > 3))).tolist()


def _seen(corners: Floats) -> tuple[list[int], list[int]]:
    """Return whole coordinates along two axes, in whose plane the polygon runs counter-clockwise."""
    ratios = [number.as_integer_ratio() for number in corners.ravel().tolist()]
    scale = max(denominator for _, denominator in ratios)
    whole = [numerator * (scale // denominator) for numerator, denominator in ratios]
    x, y, z = whole[::3], whole[1::3], whole[2::3]
    views = [(_area(*view), view) for view in ((y, z), (z, x), (x, y))]
    area, (u, v) = max(views, key=lambda found: abs(found[0]))
    return (u, v) if area > 0 else (v, u)


def _area(u: list[int], v: list[int]) -> int:
    """Return twice the signed area."""
    return sum(u[k - 1] * v[k] - u[k] * v[k - 1] for k in range(len(u)))


class _Ring:
    """The corners of a polygon that are left, in whole numbers; it runs counter-clockwise.

    Attributes
    ----------
    work : int
        How many corners were looked at.
    """

    def __init__(self, u: list[int], v: list[int]) -> None:
        size = len(u)
        self._u, self._v, self.work = u, v, 0
        self._before, self._after = [size - 1, *range(size - 1)], [*range(1, size), 0]

    @property
    def is_fan(self) -> bool:
        """Whether the fan about the first corner is right; there is none better if it has no area."""
        signs = [self._turn(0, k, k + 1) >= 0 for k in range(1, len(self._u) - 1)]
        return all(signs) or not _area(self._u, self._v)

    def ears(self, most: int) -> Iterator[tuple[int, int, int]]:
        """Yield the triangles that are cut off."""
        before, after = self._before, self._after
        # In a triangle that is no ear lies a corner where the polygon is not convex, and they stay few.
        inward = sorted((self._u[b], b) for b in after if self._turn(before[b], b, after[b]) <= 0)
        b, left, idle = 1, len(after), 0
        while left > 2:
            a, c = before[b], after[b]
            turn = self._turn(a, b, c)
            # Where a polygon crosses itself, there may be no ear.
            if turn == 0 or idle > left or (turn > 0 and not self._holds(a, b, c, inward)):
                yield a, b, c
                before[c], after[a], after[b] = a, c, -1
                left, idle = left - 1, -1
            b, idle, self.work = c, idle + 1, self.work + 1
            if self.work > most:
                raise SceneError("its concave polygons wind too much; cut them into triangles")

    def _holds(self, a: int, b: int, c: int, inward: list[tuple[int, int]]) -> bool:
        """Whether a corner lies in the triangle, its sides included, and not where one of its corners is."""
        u, v = self._u, self._v
        places = [(u[k], v[k]) for k in (a, b, c)]
        low, high = min(places)[0], max(places)[0]
        for place in range(bisect_left(inward, (low, -1)), bisect_right(inward, (high, len(u)))):
            p = inward[place][1]
            self.work += 1
            if (
                self._after[p] >= 0
                and (u[p], v[p]) not in places
                and all(self._turn(i, j, p) >= 0 for i, j in ((a, b), (b, c), (c, a)))
            ):
                return True
        return False

    def _turn(self, a: int, b: int, c: int) -> int:
        """Return twice the signed area of a triangle: positive if it turns to the left."""
        u, v = self._u, self._v
        return (u[b] - u[a]) * (v[c] - v[a]) - (u[c] - u[a]) * (v[b] - v[a])
