"""Extents: the box a ray must meet, and the samples a projected box or triangle can reach.

Extents only save work. Whatever lies in an extent must be found through it, so every test here errs
on the side of "may meet": boxes are closed, and rounding is covered by paddings derived beside them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hsr.arrays import Floats
from hsr.jit import jit

Vector = tuple[float, float, float]
Corner = tuple[float, float, float, float]
"""A projected point: column and row in pixels from the image centre times its weight, depth, nearness."""

TWO_ULP = 2.0**-51
"""Two units in the last place of 1: the padding of Ize, "Robust BVH Ray Traversal" (JCGT 2013)."""

SAMPLE_PAD = 2.0**-30
"""Padding of a rectangle on the screen, in pixels.

A side is one quotient and two sums of numbers below 2^15 in magnitude (images are at most 2^14 wide),
and covering a sample rounds three more such numbers: fewer than ten roundings of at most 2^-38 each.
"""


class Beam(NamedTuple):
    """A ray as the box test wants it: within ``margin`` of a line, from depth ``near`` to ``far``.

    Attributes
    ----------
    origin, inverse, margin : 3 floats
        Start, reciprocal of the direction (infinite, of its sign, where that is 0), and half its thickness.
    near, far : float
        The parameters between which it runs, closed.
    """

    origin: Vector
    inverse: Vector
    margin: Vector
    near: float
    far: float


@jit
def box_entry(box: Any, beam: Beam) -> float:
    """Return the parameter at which a beam enters a closed box, ``+inf`` if it misses.

    The slab test of Kay and Kajiya (1986). An entry before ``beam.near`` counts as ``beam.near``.

    Parameters
    ----------
    box : record with ``low`` and ``high``, (3,) float64
        Opposite corners, finite.
    beam : Beam
    """
    t_in, t_out = beam.near, beam.far
    for axis in range(3):
        inverse, start = beam.inverse[axis], beam.origin[axis]
        least = box["low"][axis] - beam.margin[axis]
        most = box["high"][axis] + beam.margin[axis]
        if np.isinf(inverse):
            # Parallel to the slab, or as good as: no quotient here, since 0 times infinity is NaN.
            if start < least or start > most:
                return np.inf
            continue
        first, last = (least, most) if inverse > 0.0 else (most, least)
        t_first, t_last = (first - start) * inverse, (last - start) * inverse
        t_in = max(t_in, t_first)
        t_out = min(t_out, t_last + abs(t_last) * TWO_ULP)
    return t_in if t_in <= t_out else np.inf


@jit
def naive_entry(box: Any, beam: Beam) -> float:
    """Return what :func:`box_entry` does, but without any care, as a thing to study.

    The beam is taken as infinitely thin, and quotients as they come. A ray within the plane of a side
    computes 0 times infinity there; comparisons with that NaN are false, so that it depends on the sign
    of the 0 whether the ray meets the box. A ray that grazes an edge is lost to rounding about one time
    in ten (Ize 2013).
    """
    t_in, t_out = beam.near, beam.far
    for axis in range(3):
        inverse, start = beam.inverse[axis], beam.origin[axis]
        t_first, t_last = (box["low"][axis] - start) * inverse, (box["high"][axis] - start) * inverse
        if t_first > t_last:
            t_first, t_last = t_last, t_first
        if t_first > t_in:
            t_in = t_first
        if t_last < t_out:
            t_out = t_last
    return t_in if t_in <= t_out else np.inf


@jit
def corner_of(matrix: Floats, x: float, y: float, z: float, perspective: bool) -> Corner:
    """Project a point by the rows column, row and depth of a (3, 4) matrix.

    Returns
    -------
    X, Y, depth, nearness : float
        Under perspective the point appears X / depth pixels right of and Y / depth below the image
        centre, in a parallel view X and Y; ``nearness`` is 1 / depth or -depth.
    """
    depth = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z + matrix[2, 3]
    return (
        matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z + matrix[0, 3],
        matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z + matrix[1, 3],
        depth,
        nearness_of(depth, perspective),
    )


@jit
def nearness_of(depth: float, perspective: bool) -> float:
    """Return what grows as depth shrinks and is affine on the screen for the points of a plane.

    It is 1 / depth under perspective, infinite for what is not in front of the eye; -depth in a
    parallel view.
    """
    if not perspective:
        return -depth
    return 1.0 / depth if depth > 0.0 else np.inf


class Reach(NamedTuple):
    """What a projected figure can reach: pixels from the image centre, and its greatest nearness."""

    left: float
    right: float
    top: float
    bottom: float
    nearest: float


NOWHERE = Reach(np.inf, -np.inf, np.inf, -np.inf, -np.inf)


@jit
def reach_point(reach: Reach, corner: Corner, perspective: bool) -> Reach:
    """Grow a reach by a projected point in front of the eye."""
    x, y, _, nearest = corner
    if perspective:
        x, y = x * nearest, y * nearest
    return Reach(
        min(reach.left, x),
        max(reach.right, x),
        min(reach.top, y),
        max(reach.bottom, y),
        max(reach.nearest, nearest),
    )


@jit
def reach_crossing(reach: Reach, p: Corner, q: Corner, near: float) -> Reach:
    """Grow a reach by the point where the segment p q, seen in perspective, crosses depth ``near``."""
    if (p[2] >= near) == (q[2] >= near):
        return reach
    part = (near - p[2]) / (q[2] - p[2])
    x = (p[0] + part * (q[0] - p[0])) / near
    y = (p[1] + part * (q[1] - p[1])) / near
    # Six roundings, each relative to at most |p| + |q|; part is a quotient of rounded differences.
    pad_x = (abs(p[0]) + abs(q[0])) / near * 2.0**-49
    pad_y = (abs(p[1]) + abs(q[1])) / near * 2.0**-49
    return Reach(
        min(reach.left, x - pad_x),
        max(reach.right, x + pad_x),
        min(reach.top, y - pad_y),
        max(reach.bottom, y + pad_y),
        max(reach.nearest, 1.0 / near),
    )


@jit
def reach_triangle(a: Corner, b: Corner, c: Corner, perspective: bool, near: float) -> Reach:
    """Return the reach of the part of a triangle with ``depth >= near``.

    In a parallel view, where every depth projects, near is left to the coverage test.
    """
    reach = NOWHERE
    for corner in (a, b, c):
        if not perspective or corner[2] >= near:
            reach = reach_point(reach, corner, perspective)
    if perspective:
        reach = reach_crossing(reach, a, b, near)
        reach = reach_crossing(reach, b, c, near)
        reach = reach_crossing(reach, c, a, near)
    return reach


@jit
def reach_box(matrix: Floats, low: Vector, high: Vector, perspective: bool, near: float) -> Reach:
    """Return the reach of the part with ``depth >= near`` of a box, projected by a matrix."""
    reach = NOWHERE
    for bits in range(8):
        p = _box_corner(matrix, low, high, bits, perspective)
        if not perspective or p[2] >= near:
            reach = reach_point(reach, p, perspective)
        # Each of the twelve edges once: from the corner with a coordinate low to the one with it high.
        for axis in range(3):
            if perspective and not bits & (1 << axis):
                q = _box_corner(matrix, low, high, bits | (1 << axis), perspective)
                reach = reach_crossing(reach, p, q, near)
    return reach


@jit
def _box_corner(matrix: Floats, low: Vector, high: Vector, bits: int, perspective: bool) -> Corner:
    """Project a corner of a box; bit i of ``bits`` says whether coordinate i is high."""
    x = high[0] if bits & 1 else low[0]
    y = high[1] if bits & 2 else low[1]
    z = high[2] if bits & 4 else low[2]
    return corner_of(matrix, x, y, z, perspective)


@jit
def samples_of(least: float, most: float, count: int) -> tuple[int, int]:
    """Return the first and last of ``count`` samples in a row that lie from least to most, closed.

    Parameters
    ----------
    least, most : float
        Pixels from the image centre; sample k lies at ``k + 1/2 - count/2``.

    Returns
    -------
    first, last : int
        Clamped to the image; first > last if there are none.
    """
    start = 0.5 - 0.5 * count
    first = np.ceil(min(max(least - start - SAMPLE_PAD, 0.0), float(count)))
    last = np.floor(max(min(most - start + SAMPLE_PAD, count - 1.0), -1.0))
    return int(first), int(last)
