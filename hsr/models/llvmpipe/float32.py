"""The float32 arithmetic of Mesa's llvmpipe: window coordinates, clipping, and the depth test.

Numbers are those of OpenGL: clip coordinates (x, y, z, w), then window coordinates with x in
pixels to the right and **y upward**, so that row 0 is the bottom row, and z from 0 (near) to 1
(far). Every product and sum is rounded where the driver rounds it, in its order.
"""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.base.jit import jit
from hsr.kernels.vectors import copy

Real = float | np.float32

FLOAT64, FLOAT32, UNORM = 0, 1, 2
"""Arithmetic of the depth test: float64, float32, or float32 stored as an integer."""

PLANES = 6
"""Clip planes, in the order in which they clip: x = w, x = -w, y = w, y = -w, near, far."""

BELOW = (0, 2, 5)
"""Planes whose inside is below them in x, y or z."""

MOST_CORNERS = 28
"""A plane adds a corner to a convex polygon; where rounding has bent one, at most half as many again
as it has: 3, 4, 6, 9, 13, 19, 28."""


@jit
def multiply_add(a: Real, b: Real, c: Real) -> np.float32:
    """Return ``a b + c`` of three float32 numbers, rounded once to float32.

    The product has at most 48 bits, so float64 holds it exactly; only the sum is rounded. Rounding
    it *to odd* (an inexact sum takes the neighbour whose last bit is 1) keeps the second rounding,
    to float32, from meeting a false tie (Boldo & Melquiond, "Emulation of a FMA and correctly
    rounded sums: proved algorithms using rounding to odd", IEEE Transactions on Computers, 2008).
    """
    product, addend = np.float64(a) * np.float64(b), np.float64(c)
    total = product + addend
    # The error of a sum (Knuth, The Art of Computer Programming, volume 2, 4.2.2).
    virtual = total - product
    error = (product - (total - virtual)) + (addend - virtual)
    if error != 0.0:
        bits = np.float64(total).view(np.int64)
        if bits & 1 == 0:
            grows = (error > 0.0) == (total > 0.0)
            total = np.int64(bits + 1 if grows else bits - 1).view(np.float64)
    return np.float32(total)


@jit
def project(clip: Array, scale: Array, translate: Array, window: Array) -> None:
    """Carry vertices to the window: multiply by 1 / w, then scale and move in one rounding.

    Parameters
    ----------
    clip : (n, 4) float32
        Where w is 0 or negative the result means nothing; clipping replaces it.
    scale, translate : (3,) float32
    window : (n, 3) float32
        Filled.
    """
    for i in range(len(clip)):
        reciprocal = np.float32(1.0) / clip[i, 3]
        for k in range(3):
            window[i, k] = multiply_add(clip[i, k] * reciprocal, scale[k], translate[k])


# ---------------------------------------------------------------- clipping


@jit
def outcodes(clip: Array, reach: Array, codes: Ints) -> None:
    """Find the clip planes outside of which each vertex lies, as bits in clipping order.

    Parameters
    ----------
    clip : (n, 4) float32
    reach : (6,) float32
        How far from 0 each plane is, in w: the planes in x and y are ``x = reach w`` and ``x = -reach w``.
        A vertex on a plane is inside.
    codes : (n,) int32
        Filled.
    """
    for i in range(len(clip)):
        x, y, z, w = clip[i]
        sides = (x > reach[0] * w) | (x + reach[1] * w < 0) << 1
        sides |= (y > reach[2] * w) << 2 | (y + reach[3] * w < 0) << 3
        codes[i] = sides | (z + reach[4] * w < 0) << 4 | (z > reach[5] * w) << 5


@jit
def clip_triangles(clip: Array, made: Bools, codes: Ints, reach: Array, corners: Ints) -> None:
    """Clip triangles to the view volume, one plane after the other.

    The algorithm of Sutherland & Hodgman ("Reentrant polygon clipping", Communications of the ACM,
    1974). A corner on a plane is inside.

    Parameters
    ----------
    clip : (n, 28, 4) float32
        The corners, three of each triangle given; replaced by those of the polygon that is left.
    made : (n, 28) bool
        Which corners clipping made; given as False.
    codes : (n,) int32
        The planes to clip against, as bits.
    reach : (6,) float32
        See :func:`outcodes`.
    corners : (n,) int32
        Filled with the number of corners; below 3 nothing is left.
    """
    old_clip = np.empty((MOST_CORNERS, 4), dtype=np.float32)
    old_made = np.empty(MOST_CORNERS, dtype=np.bool_)
    for i in range(len(clip)):
        count = 3
        for plane in range(PLANES):
            if codes[i] >> plane & 1 and count >= 3:
                for k in range(count):
                    copy(clip[i, k], old_clip[k])
                    old_made[k] = made[i, k]
                count = _clip_polygon(old_clip, old_made, count, plane, reach[plane], clip[i], made[i])
        corners[i] = count


@jit
def _clip_polygon(
    clip: Array, made: Bools, corners: int, plane: int, reach: np.float32, left: Array, left_made: Bools
) -> int:
    """Clip a polygon against one plane; return the number of corners left."""
    count = 0
    distance = _distance(clip[0], plane, reach)
    for i in range(corners):
        j = (i + 1) % corners
        distance_next = _distance(clip[j], plane, reach)

        # Keep a corner inside the plane.
        if distance >= 0:
            copy(clip[i], left[count])
            left_made[count] = made[i]
            count += 1

        # Cut an edge that crosses the plane, from its nearer end, or that inside.
        if (distance >= 0) != (distance_next >= 0):
            equal = abs(distance) == abs(distance_next)
            if abs(distance) < abs(distance_next) or (equal and distance >= 0):
                _cut(clip[i], distance, clip[j], distance_next, left[count])
            else:
                _cut(clip[j], distance_next, clip[i], distance, left[count])
            left_made[count] = True
            count += 1
        distance = distance_next
    return count


@jit
def _cut(start: Array, distance: np.float32, end: Array, end_distance: np.float32, corner: Array) -> None:
    """Fill in where an edge meets the plane, reckoned from its start."""
    t = distance / (distance - end_distance)
    for k in range(4):
        corner[k] = start[k] + t * (end[k] - start[k])


@jit
def _distance(corner: Array, plane: int, reach: np.float32) -> np.float32:
    """Signed distance of a corner from a clip plane, positive inside."""
    along, far = corner[plane // 2], reach * corner[3]
    distance: np.float32 = far - along if plane in BELOW else far + along
    return distance


# ---------------------------------------------------------------- samples


@jit
def draw(
    edges: Array,
    closed: Bools,
    box: Ints,
    plane: Floats,
    arithmetic: int,
    levels: np.float32,
    triangle: Ints,
    depth: Floats,
) -> None:
    """Draw triangles into a depth buffer, in order; at equal depth the earlier one stays.

    Parameters
    ----------
    edges : (n, k, 3) int64 or float64
        Half-planes of each triangle: ``e0 + e1 column + e2 row`` is positive inside.
    closed : (n, k) bool
        Whether a sample where the expression is 0 belongs to the half-plane.
    box : (n, 4) int32
        First column, first row, last column and last row that can be covered, within the image.
    plane : (n, 3) float64
        Depth is ``p0 + p1 column + p2 row``.
    arithmetic : int
        ``FLOAT64``, ``FLOAT32`` or ``UNORM``.
    levels : float32
        Largest integer depth, for ``UNORM``.
    triangle : (H, W) int32
        Number of the triangle shown; changed where one is nearer.
    depth : (H, W) float64
        Holds what the buffer is cleared to; changed likewise.
    """
    for i in range(len(edges)):
        for row in range(box[i, 1], box[i, 3] + 1):
            for column in range(box[i, 0], box[i, 2] + 1):
                if _covers(edges[i], closed[i], column, row):
                    z = depth_at(plane[i], column, row, arithmetic, levels)
                    if z < depth[row, column]:
                        depth[row, column] = z
                        triangle[row, column] = i


@jit
def _covers(edges: Array, closed: Bools, column: int, row: int) -> bool:
    for k in range(len(edges)):
        value = edges[k, 0] + edges[k, 1] * column + edges[k, 2] * row
        if value < 0 or (value == 0 and not closed[k]):
            return False
    return True


@jit
def depth_at(plane: Floats, column: int, row: int, arithmetic: int, levels: np.float32) -> np.float64:
    """Return the depth of a plane at a sample, as the arithmetic has it; see :func:`draw`."""
    depth: np.float64 = plane[0] + plane[1] * column + plane[2] * row
    if arithmetic == FLOAT64:
        return depth
    z = multiply_add(plane[2], row, multiply_add(plane[1], column, plane[0]))
    if arithmetic == FLOAT32:
        return np.float64(z)
    clamped = np.minimum(np.maximum(z, np.float32(0.0)), np.float32(1.0))
    return np.float64(np.rint(clamped * levels))
