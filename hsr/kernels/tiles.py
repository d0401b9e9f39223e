"""Half-space rasterisation of triangles into one buffer of keys.

A sample is inside a triangle if it is on the inner side of all three edges (Pineda, "A Parallel
Algorithm for Polygon Rasterization", SIGGRAPH 1988). Each side is the sign of an edge function, affine
on the screen, so sixteen samples of a scan line are tested at once. Depth and owner share one 64-bit
integer, depth in the upper bits: the nearest face has the least key, and one minimum does the depth
test and both writes. Of equal depths the lower face stays, as with ``z < buffer`` in order of faces.

Who owns a sample. Screen coordinates have y down. An edge function is ``>= 0`` for a left edge and for a
top one, ``> 0`` for the others: a sample exactly on a left or top edge is inside (the top-left rule).
Edge functions are float64 and anchored at the upper corner of their edge, whichever way it runs. So two
triangles that share an edge compute the same numbers with opposite signs, and every sample between them
has exactly one owner. Rounding may move a sample within some ulp of an edge to the other side.
"""

from __future__ import annotations

import math

import numpy as np

from hsr.arrays import Array, Floats, Ints
from hsr.jit import jit, parallel_jit, prange
from hsr.kernels.strips import END_LINE, FIRST_LINE, STRIP, deal_to_strips

LANES = 16
"""Samples tested at once; the loop over them compiles to vector instructions."""

FIRST_COLUMN, END_COLUMN, FACE, CORNER = 2, 3, 4, 5
"""Columns of the triangle table after FIRST_LINE and END_LINE; the three corners come last."""

EMPTY = np.uint64(2**64 - 1)
"""The key of a sample that no face owns."""

ABOVE_ZERO = 5e-324
"""The least positive float64: ``e >= ABOVE_ZERO`` says ``e > 0``."""

MANTISSA = 52
"""Bits of a float64 after the binary point; those of 1 + z, shifted to the top, order like z."""

ONE = np.float64(1.0).view(np.uint64)
"""Sign and exponent of 1 + z: the same for all depths."""

CULL_BACK, CULL_FRONT = 1, 2


def rasterise(
    screen: Floats, triangle: Ints, face: Ints, cull: Array, size: tuple[int, int]
) -> tuple[Ints, Floats, float]:
    """Find the nearest triangle of every sample.

    Parameters
    ----------
    screen : (V, 3) float64
        x right and y down in pixels, window depth z in [0, 1].
    triangle : (n, 3) int32
        Vertex indices, counter-clockwise to the eye if seen from the front.
    face : (n,) int32
        Face each triangle belongs to, ascending.
    cull : (n,) int8
        What not to draw: 0 nothing, 1 back faces, 2 front faces.
    size : (width, height)

    Returns
    -------
    owner : (H, W) int32
        Face of each sample, -1 where there is none.
    z : (H, W) float64
        Its window depth there, ``+inf`` where there is none.
    step : float
        Distance of neighbouring window depths: what the face leaves of 64 bits, 52 at most.
    """
    width, height = size
    # One bit pattern more than there are faces: no key of a face is EMPTY.
    bits = max((int(face.max(initial=0)) + 1).bit_length(), 64 - MANTISSA)
    table = np.zeros((len(triangle), CORNER + 3), np.int32)
    table[:, FACE] = face
    _set_up(screen, triangle, cull, width, height, table)
    listed, strips = deal_to_strips(table, height)
    # Lanes beyond the last column fall into the padding.
    keys = np.empty((height, width + LANES), np.uint64)
    owner, z = np.empty((height, width), np.int32), np.empty((height, width))
    _rasterise(screen, table, listed, strips, bits, keys, owner, z)
    return owner, z, 2.0 ** (bits - 64)


@parallel_jit
def _set_up(screen: Floats, triangle: Ints, cull: Array, width: int, height: int, table: Ints) -> None:
    """Write the bounding box and the corners of every triangle that is drawn, in clockwise order."""
    for i in prange(len(table)):
        a, b, c = triangle[i, 0], triangle[i, 1], triangle[i, 2]
        ax, ay = screen[a, 0], screen[a, 1]
        bx, by = screen[b, 0], screen[b, 1]
        cx, cy = screen[c, 0], screen[c, 1]

        # Drop what is seen edge-on or culled: with y down, the front has a negative area.
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if not abs(area) > 0.0 or cull[i] & (CULL_FRONT if area < 0.0 else CULL_BACK):
            continue

        # Drop what crosses no sample; leave no scan lines to it.
        first_column = max(math.ceil(min(ax, bx, cx) - 0.5), 0)
        end_column = min(math.floor(max(ax, bx, cx) - 0.5) + 1, width)
        first_line = max(math.ceil(min(ay, by, cy) - 0.5), 0)
        end_line = min(math.floor(max(ay, by, cy) - 0.5) + 1, height)
        if first_column >= end_column or first_line >= end_line:
            continue
        table[i, FIRST_LINE], table[i, END_LINE] = first_line, end_line
        table[i, FIRST_COLUMN], table[i, END_COLUMN] = first_column, end_column
        table[i, CORNER] = a
        table[i, CORNER + 1], table[i, CORNER + 2] = (b, c) if area > 0.0 else (c, b)


@parallel_jit
def _rasterise(
    screen: Floats,
    table: Ints,
    listed: Ints,
    strips: Array,
    bits: int,
    keys: Array,
    owner: Ints,
    z: Floats,
) -> None:
    for k in prange(len(strips)):
        strip, begin, end = strips[k]
        first, last = strip * STRIP, min((strip + 1) * STRIP, len(keys))
        keys[first:last] = EMPTY
        for i in listed[begin:end]:
            _fill(screen, table, i, first, last, bits, keys)
        _read_out(keys, first, last, bits, owner, z)


@jit
def _edge(screen: Floats, p: int, q: int) -> tuple[float, float, float, float, float]:
    """Return the edge function of p -> q: its dx and dy, its anchor (x, y), its bound.

    It is ``dx (y - anchor y) - dy (x - anchor x)``, positive inside a clockwise triangle (y down). A
    left edge runs up, a top edge to the right. The anchor is the upper corner, of equally high ones the
    left one: for q -> p every product is the same but for its sign. At both corners it is exactly 0.
    """
    dx, dy = screen[q, 0] - screen[p, 0], screen[q, 1] - screen[p, 1]
    anchor = p if dy > 0.0 or (dy == 0.0 and dx > 0.0) else q
    bound = 0.0 if dy < 0.0 or (dy == 0.0 and dx > 0.0) else ABOVE_ZERO
    return dx, dy, screen[anchor, 0], screen[anchor, 1], bound


@jit
def _plane(screen: Floats, a: int, b: int, c: int) -> tuple[float, float]:
    """Return dz/dx and dz/dy of the plane through three corners."""
    ux, uy, uz = screen[b, 0] - screen[a, 0], screen[b, 1] - screen[a, 1], screen[b, 2] - screen[a, 2]
    vx, vy, vz = screen[c, 0] - screen[a, 0], screen[c, 1] - screen[a, 1], screen[c, 2] - screen[a, 2]
    area = ux * vy - uy * vx
    return (uz * vy - vz * uy) / area, (vz * ux - uz * vx) / area


@jit
def _fill(screen: Floats, table: Ints, i: int, first: int, last: int, bits: int, keys: Array) -> None:
    """Take one triangle into the keys of the scan lines from first to last."""
    top, left, end_column = table[i, FIRST_LINE], table[i, FIRST_COLUMN], table[i, END_COLUMN]
    a, b, c = table[i, CORNER], table[i, CORNER + 1], table[i, CORNER + 2]
    dx0, dy0, x0, y0, bound0 = _edge(screen, a, b)
    dx1, dy1, x1, y1, bound1 = _edge(screen, b, c)
    dx2, dy2, x2, y2, bound2 = _edge(screen, c, a)
    # Anchor the depth at the first sample of the bounding box, whatever the strip.
    first_x, first_y = left + 0.5, top + 0.5
    z_x, z_y = _plane(screen, a, b, c)
    # One more than z: all depths then have the same exponent.
    z = 1.0 + (screen[a, 2] + (first_x - screen[a, 0]) * z_x + (first_y - screen[a, 1]) * z_y)

    face = np.uint64(table[i, FACE])
    keep = EMPTY << np.uint64(bits)
    farthest = 2.0 - 2.0**-MANTISSA
    for row in range(max(top, first), min(table[i, END_LINE], last)):
        y, row_z = row + 0.5, z + float(row - top) * z_y
        row0, row1, row2 = dx0 * (y - y0), dx1 * (y - y1), dx2 * (y - y2)
        line = keys[row]
        for start in range(left, end_column, LANES):
            for lane in range(LANES):
                right = float(start - left + lane)
                x = first_x + right
                inside = (
                    (row0 - dy0 * (x - x0) >= bound0)
                    & (row1 - dy1 * (x - x1) >= bound1)
                    & (row2 - dy2 * (x - x2) >= bound2)
                )
                depth = np.float64(min(max(row_z + right * z_x, 1.0), farthest))
                key = ((depth.view(np.uint64) << np.uint64(64 - MANTISSA)) & keep) | face
                at = np.uintp(start + lane)
                line[at] = min(line[at], key if inside else EMPTY)


@jit
def _read_out(keys: Array, first: int, last: int, bits: int, owner: Ints, z: Floats) -> None:
    """Split the keys of the scan lines from first to last into faces and depths."""
    keep = EMPTY << np.uint64(bits)
    for row in range(first, last):
        for column in range(owner.shape[1]):
            key = keys[row, column]
            above_one = np.uint64(((key & keep) >> np.uint64(64 - MANTISSA)) | ONE)
            owner[row, column] = np.int32(key & ~keep) if key != EMPTY else np.int32(-1)
            z[row, column] = above_one.view(np.float64) - 1.0 if key != EMPTY else np.inf
