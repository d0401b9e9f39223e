"""The polygon table: what scan conversion wants to know of every polygon, computed once."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hsr.base.arrays import Array, Ints
from hsr.base.jit import jit, parallel_jit, prange
from hsr.kernels.culling import CULL_BACK, CULL_FRONT, newell

FIRST_LINE, END_LINE, FIRST, END, TOP, TURN, FACE, FATE = range(8)
"""Columns of a polygon's row: its first scan line and the one after its last; the places of its first
corner, the one after its last, and its topmost; +1 or -1, the direction in which corners run down its
left side; its face; what became of it."""

CLIPPED, MISSED, EDGE_ON, CULLED, DRAWN = range(5)
"""Fates: outside the view volume; no sample in its bounding box; seen edge-on; culled; drawn."""


class PolygonTable(NamedTuple):
    """The polygons to scan convert.

    Attributes
    ----------
    screen : (V, 3) float64 or float32, screen coordinates
        Their type is that of all arithmetic.
    corner : (K,) int32
        The vertices of one polygon after the other.
    plane : (P, 3) of screen's type
        A, B and C of each.
    row : (P, 8) int32
        Columns FIRST_LINE to FATE; polygons not drawn have no scan lines.
    """

    screen: Array
    corner: Ints
    plane: Array
    row: Ints


@parallel_jit
def polygon_table(
    screen: Array, corner: Ints, start: Ints, face: Ints, cull: Array, size: tuple[int, int]
) -> PolygonTable:
    """Set up every polygon once: its plane, its scan lines, its topmost corner, its facing.

    Parameters
    ----------
    screen : (V, 3) float64 or float32, screen coordinates
    corner, start : (K,), (P + 1,) int32
        The polygons, counter-clockwise to the eye if seen from the front.
    face : (P,) int32
    cull : (P,) int8
        What not to draw, see :data:`hsr.kernels.culling.CULL_BACK`.
    size : (width, height)
    """
    plane = np.empty((len(face), 3), screen.dtype)
    row = np.zeros((len(face), 8), np.int32)
    row[:, FACE] = face
    width, height = size
    half = screen.dtype.type(0.5)
    for i in prange(len(row)):
        first, end = start[i], start[i + 1]
        if end - first < 3:
            continue  # clipped away

        # Drop what has no area, and what is not a number. Window depth grows away from the eye.
        minus_A, minus_B, C = newell(screen, corner[first:end])
        if not 0.0 < abs(C) < np.inf:
            row[i, FATE] = EDGE_ON
            continue

        # Tell front from back by C: with y down, what is counter-clockwise to the eye has C < 0.
        if cull[i] & (CULL_FRONT if C < 0.0 else CULL_BACK):
            row[i, FATE] = CULLED
            continue

        # Drop what crosses no sample.
        left, right, highest, lowest, top = _bounds(screen, corner, first, end)
        first_line = max(math.ceil(highest - half), 0)
        end_line = min(math.ceil(lowest - half), height)
        if first_line >= end_line or max(math.ceil(left - half), 0) >= min(math.ceil(right - half), width):
            row[i, FATE] = MISSED
            continue

        plane[i, 0], plane[i, 1], plane[i, 2] = -minus_A, -minus_B, C
        row[i, FIRST_LINE], row[i, END_LINE] = first_line, end_line
        row[i, FIRST], row[i, END], row[i, TOP] = first, end, top
        row[i, TURN] = 1 if C < 0.0 else -1
        row[i, FATE] = DRAWN
    return PolygonTable(screen, corner, plane, row)


@jit
def _bounds(screen: Array, corner: Ints, first: int, end: int) -> tuple[float, float, float, float, int]:
    """Return least and greatest x, least and greatest y, and the place of the topmost corner."""
    x, y = screen[corner[first], 0], screen[corner[first], 1]
    left, right, highest, lowest, top = x, x, y, y, first
    for k in range(first + 1, end):
        x, y = screen[corner[k], 0], screen[corner[k], 1]
        left, right = min(left, x), max(right, x)
        lowest = max(lowest, y)
        if y < highest:
            highest, top = y, k
    return left, right, highest, lowest, top
