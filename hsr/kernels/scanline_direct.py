"""Scan conversion by direct evaluation: nothing is carried on from sample to sample, or from line to line.

Sides are found anew on every scan line, and ``z = (-A x - B y - D) / C`` at every sample, counted from the
topmost corner. So each depth is rounded a few times, however long the span, where increments round once a
step. The rules are those of :mod:`hsr.kernels.scanline`.
"""

from __future__ import annotations

import math

import numpy as np

from hsr.base.arrays import Array, Ints
from hsr.base.jit import inline_jit
from hsr.kernels.depth_buffer import Form, span
from hsr.kernels.polygon_table import FACE, TOP, TURN, PolygonTable
from hsr.kernels.scanline import draw, edge_below


@inline_jit
def scan_polygon_directly(
    table: PolygonTable,
    i: int,
    lines: tuple[int, int],
    buffers: tuple[Array, Ints],
    form: Form | None,
    counts: Array | None,
) -> None:
    """Scan convert one polygon within some scan lines; see :func:`hsr.kernels.scanline.scan_polygon`."""
    screen, corner = table.screen, table.corner
    real = screen.dtype.type
    half = real(0.5)
    A, B, C = table.plane[i, 0], table.plane[i, 1], table.plane[i, 2]
    # Of one type each, so that their callee is compiled once.
    face = table.row[i, FACE]
    top, turn = int(np.int64(table.row[i, TOP])), int(np.int64(table.row[i, TURN]))
    x_top, y_top, z_top = screen[corner[top], 0], screen[corner[top], 1], screen[corner[top], 2]
    z_x, z_y = -A / C, -B / C
    _, owner = buffers
    row, end = lines
    left, right, left_end, right_end = top, top, row, row
    while row < end:
        # Where the edge of a side ends, take the next.
        if left_end <= row:
            left, left_line, left_end, left_x, left_one_over_m = edge_below(table, i, left, turn, row)
        if right_end <= row:
            right, right_line, right_end, right_x, right_one_over_m = edge_below(table, i, right, -turn, row)

        # Find the span between the sides, and the depth of each of its samples.
        x_left = left_x + real(row - left_line) * left_one_over_m
        x_right = right_x + real(row - right_line) * right_one_over_m
        first = max(math.ceil(x_left - half), 0)
        last = max(min(math.ceil(x_right - half), owner.shape[1]), first)
        z_row = z_top + (real(row) + half - y_top) * z_y
        for column in span(first, last, counts):
            z = z_row + (real(column) + half - x_top) * z_x
            draw(z, face, np.uintp(row), column, buffers, form, counts)
        row += 1
