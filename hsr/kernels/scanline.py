"""The depth buffer: polygons scan converted one after the other, the nearest kept at each sample.

As the textbooks have it (Hearn & Baker, *Computer Graphics*, the depth-buffer method; Foley, van Dam, Feiner
& Hughes, *Computer Graphics: Principles and Practice*, section 15.4). A polygon lies in the plane
``A x + B y + C z + D = 0``, so that its depth at a sample is ``z = (-A x - B y - D) / C``. From there on,

    across a scan line        to  x + 1             z - A / C
    down a side of slope m    to  x + 1/m, y + 1    z - (A / m + B) / C
    down a vertical side      to  x, y + 1          z - B / C

The textbook has y *up* and goes down to y - 1 and x - 1/m, where the depth is ``z + (A / m + B) / C``; the
rows of an image run down (:mod:`hsr.kernels.projection`), which turns both signs. The sides of a polygon do
not pass through pixel centres: each edge starts with a step down to its first scan line, and each span with
one right to its first sample.

Who owns a sample. Row r is on an edge from y0 down to y1 if ``y0 <= r + 0.5 < y1``; column c is in a
span from x0 to x1 if ``x0 <= c + 0.5 < x1``. A sample exactly on a left or a top edge is inside, on a
right or a bottom edge outside. An edge is always walked downward from its upper end by itself, so two
polygons that share it meet at the same bits of x on every scan line, and every sample between them has
exactly one owner. Rounding of x can move a sample within some ulp of an edge to the other side.

Who wins. The depth test is ``z < buffer``, and polygons come in order of face id: of equal z the lower
id stays. The z of two planes that meet at a sample may differ by rounding, and then that decides.

Beside it stand :mod:`hsr.kernels.scanline_direct`, which evaluates the plane anew at every sample,
:mod:`hsr.kernels.depth_buffer`, which knows other depth formats and tests, and :mod:`hsr.kernels.strips`,
which shares the scan lines out to threads.
"""

from __future__ import annotations

import math

import numpy as np

from hsr.base.arrays import Array, Ints
from hsr.base.jit import inline_jit, jit
from hsr.kernels.depth_buffer import Form, passes, span, stepped, stored_of
from hsr.kernels.polygon_table import END, FACE, FIRST, TOP, TURN, PolygonTable


@inline_jit
def scan_polygon(
    table: PolygonTable,
    i: int,
    lines: tuple[int, int],
    buffers: tuple[Array, Ints],
    form: Form | None,
    counts: Array | None,
) -> None:
    """Scan convert polygon i of a table within some scan lines.

    Parameters
    ----------
    table, i
    lines : (row, end)
    buffers : (z, owner)
        Depths and faces (H, W).
    form, counts
        See :func:`hsr.kernels.strips.scan_convert`.
    """
    screen, corner = table.screen, table.corner
    real = screen.dtype.type
    half = real(0.5)
    A, B, C = table.plane[i, 0], table.plane[i, 1], table.plane[i, 2]
    # Of one type each, so that their callee is compiled once.
    face = table.row[i, FACE]
    top, turn = int(np.int64(table.row[i, TOP])), int(np.int64(table.row[i, TURN]))
    x_top, y_top, z_top = screen[corner[top], 0], screen[corner[top], 1], screen[corner[top], 2]
    z_across = stepped(A / C, form)
    _, owner = buffers
    row, end = lines
    left, right, left_end, right_end = top, top, row, row
    while row < end:
        # Where the edge of a side ends, take the next, and step down it to this scan line.
        if left_end <= row:
            left, line, left_end, x_left, left_one_over_m = edge_below(table, i, left, turn, row)
            y = real(line) + half
            z_left = stepped(z_top - (x_left - x_top) * (A / C) - (y - y_top) * (B / C), form)
            # (A / m + B) / C, which is B / C down a vertical side: its 1/m is 0.
            z_down = stepped(A / C * left_one_over_m + B / C, form)
            for _ in range(line, row):
                x_left += left_one_over_m
                z_left -= z_down
        if right_end <= row:
            right, line, right_end, x_right, right_one_over_m = edge_below(table, i, right, -turn, row)
            for _ in range(line, row):
                x_right += right_one_over_m

        # Go across the samples whose centres are in x_left <= x < x_right.
        first = max(math.ceil(x_left - half), 0)
        last = max(min(math.ceil(x_right - half), owner.shape[1]), first)
        z = stepped(z_left - (real(first) + half - x_left) * (A / C), form)
        for column in span(first, last, counts):
            draw(z, face, np.uintp(row), column, buffers, form, counts)
            z -= z_across

        # Go down both sides to the next scan line.
        row += 1
        x_left += left_one_over_m
        x_right += right_one_over_m
        z_left -= z_down


@jit
def draw(
    z: float,
    face: int,
    row: np.uintp,
    column: int,
    buffers: tuple[Array, Ints],
    form: Form | None,
    counts: Array | None,
) -> None:
    """Keep a fragment if it is nearer than what the buffer holds.

    Indices are unsigned, so that no code is compiled for negative ones.
    """
    z_buffer, owner = buffers
    stored = stored_of(z, z_buffer, form)
    if passes(stored, z_buffer[row, column], form, counts):
        z_buffer[row, column] = stored
        owner[row, column] = face


@jit
def edge_below(
    table: PolygonTable, i: int, k: int, turn: int, row: int
) -> tuple[int, int, int, float, float]:
    """Follow a side of polygon i down from corner k to the edge that crosses a scan line.

    Returns its lower corner, its first scan line and the one after its last, x on the first, and 1/m.
    Horizontal edges cross none. The edge exists: a side ends at the lowest corner, which is below all
    scan lines of the polygon.
    """
    screen, corner, polygon = table.screen, table.corner, table.row[i]
    half = screen.dtype.type(0.5)
    upper = k
    edge_end = row
    while edge_end <= row:
        upper = k
        k += turn
        if k == polygon[END]:
            k = polygon[FIRST]
        elif k < polygon[FIRST]:
            k = polygon[END] - 1
        edge_end = math.ceil(screen[corner[k], 1] - half)
    x, y = screen[corner[upper], 0], screen[corner[upper], 1]
    one_over_m = (screen[corner[k], 0] - x) / (screen[corner[k], 1] - y)
    line = max(math.ceil(y - half), 0)
    return k, line, edge_end, x + (screen.dtype.type(line) + half - y) * one_over_m, one_over_m
