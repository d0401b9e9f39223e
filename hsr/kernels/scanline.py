"""Scan conversion of convex polygons into a depth buffer.

The depth buffer as textbooks have it (Hearn & Baker, *Computer Graphics*, the depth-buffer method; Foley,
van Dam, Feiner & Hughes, *Computer Graphics: Principles and Practice*, section 15.4): polygons are
processed one after the other, along scan lines from the top, between a left and a right side. From one
scan line to the next a side moves by ``x += 1/m``. The plane ``A x + B y + C z + D = 0`` gives depth:
it changes by ``-A/C`` from sample to sample, and by ``-(A/m + B)/C`` down a side. (Screen coordinates
have y *down*, see :mod:`hsr.kernels.projection`. With y up, walking down, the textbook's signs differ:
``x -= 1/m`` and ``z += (A/m + B)/C``.) The sides of a polygon do not pass through pixel centres: each
edge starts with a prestep down to its first scan line, and each span with one right to its first sample.

Who owns a sample. Row r is on an edge from y0 down to y1 if ``y0 <= r + 0.5 < y1``; column c is in a
span from x0 to x1 if ``x0 <= c + 0.5 < x1``. A sample exactly on a left or a top edge is inside, on a
right or a bottom edge outside. An edge is always walked downward from its upper end by itself, so two
polygons that share it meet at the same bits of x on every scan line, and every sample between them has
exactly one owner. Rounding of x can move a sample within some ulp of an edge to the other side.

Who wins. The depth test is ``z < buffer``, and polygons come in order of face id: of equal z the lower
id stays (with ``z <= buffer`` the higher). The z of two planes that meet at a sample may differ by
rounding, and then that decides. A :class:`Form` says what the buffer holds of z if it is not z itself; the
test compares what is held.

The scan lines are shared out in strips of :data:`STRIP` rows. The edge of a polygon is walked from its
own top (or that of the image) in every strip it crosses, so the strips leave no trace in the result, and
neither does the number of threads.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from hsr.base.arrays import Array, Ints
from hsr.base.jit import jit, parallel_jit, prange
from hsr.kernels.culling import CULL_BACK, CULL_FRONT
from hsr.kernels.strips import END_LINE, FIRST_LINE, STRIP, deal_to_strips

DIRECT, INCREMENTAL, FIXED = range(3)
"""How depth and sides are stepped: evaluated at every sample; by increments; or by increments, depth in
whole numbers. Those are held in floats: below ``2**53`` their sums are exact, as those of integers."""

LESS, LESS_EQUAL, ALWAYS = range(3)
"""When a fragment passes the depth test: nearer than what the buffer holds; nearer or equal; in any case."""

FIRST, END, TOP, TURN, FACE, FATE = range(2, 8)
"""Columns of the polygon table, after FIRST_LINE and END_LINE: the places of its first
corner, the one after its last, and its topmost; +1 or -1, the direction in which corners run down its
left side; its face; what became of it."""

DRAWN, CULLED, EDGE_ON, MISSED, CLIPPED = range(5)
"""Fates of a polygon: drawn; culled; seen edge-on; no sample in its bounding box; outside the view
volume."""

SCAN_LINES, SPANS, FRAGMENTS, PASSED = range(4)
"""Columns of the counts: polygons' scan lines, those of them that cross a sample, samples tested, and
depth tests passed."""


class Form(NamedTuple):
    """What a depth buffer holds of a depth z, and how it is tested.

    A buffer of floats holds z rounded to its type. A buffer of integers holds the level
    ``floor(scale * z + offset)``, computed in float64 and clamped to its range, of z or of ``w = -1 / z``.

    Attributes
    ----------
    test : int
        LESS, LESS_EQUAL or ALWAYS.
    levels : int
        The greatest integer; 0 for a buffer of floats.
    scale, offset : float
    last : float
        Of a buffer for w the z of the far plane, negative; what lies beyond is stored like it. Else 0.
    """

    test: int = LESS
    levels: int = 0
    scale: float = 1.0
    offset: float = 0.0
    last: float = 0.0


# ---------------------------------------------------------------- the polygon table


def polygon_table(
    screen: Array, corner: Ints, start: Ints, face: Ints, cull: Array, size: tuple[int, int]
) -> tuple[Array, Ints]:
    """Set up every polygon once: its plane, its scan lines, its topmost corner, its facing.

    Parameters
    ----------
    screen : (V, 3) float64 or float32, screen coordinates
    corner, start : (K,), (P + 1,) int32
        The polygons, counter-clockwise to the eye if seen from the front.
    face : (P,) int32
    cull : (P,) int8
        What not to draw: 0 nothing, 1 back faces, 2 front faces, 3 both.
    size : (width, height)

    Returns
    -------
    slope : (P, 2) of screen's type
        dz/dx and dz/dy: ``-A/C`` and ``-B/C``.
    table : (P, 8) int32
        Columns FIRST_LINE to FATE; polygons not drawn have no scan lines.
    """
    slope = np.empty((len(face), 2), screen.dtype)
    table = np.zeros((len(face), 8), np.int32)
    table[:, FACE] = face
    _set_up(screen, corner, start, cull, *size, slope, table)
    return slope, table


@parallel_jit
def _set_up(
    screen: Array, corner: Ints, start: Ints, cull: Array, width: int, height: int, slope: Array, table: Ints
) -> None:
    half = screen.dtype.type(0.5)
    for i in prange(len(table)):
        first, end = start[i], start[i + 1]
        if end - first < 3:
            table[i, FATE] = CLIPPED
            continue

        # Drop what has no area, and what is not a number.
        a, b, c = _plane(screen, corner, first, end)
        if not 0.0 < abs(c) < np.inf:
            table[i, FATE] = EDGE_ON
            continue

        # Tell front from back by C: with y down, what is counter-clockwise to the eye has C < 0.
        if cull[i] & (CULL_FRONT if c < 0.0 else CULL_BACK):
            table[i, FATE] = CULLED
            continue

        # Drop what crosses no sample.
        left, right, highest, lowest, top = _bounds(screen, corner, first, end)
        first_line = max(math.ceil(highest - half), 0)
        end_line = min(math.ceil(lowest - half), height)
        first_column = max(math.ceil(left - half), 0)
        end_column = min(math.ceil(right - half), width)
        if first_line >= end_line or first_column >= end_column:
            table[i, FATE] = MISSED
            continue

        slope[i, 0], slope[i, 1] = -a / c, -b / c
        table[i, FIRST_LINE], table[i, END_LINE] = first_line, end_line
        table[i, FIRST], table[i, END], table[i, TOP] = first, end, top
        table[i, TURN] = 1 if c < 0.0 else -1


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


@jit
def _plane(screen: Array, corner: Ints, first: int, end: int) -> tuple[float, float, float]:
    """Return A, B and C by Newell's method, summed over the fan about the first corner."""
    origin = corner[first]
    x, y, z = screen[origin, 0], screen[origin, 1], screen[origin, 2]
    a = b = c = screen.dtype.type(0.0)
    for k in range(first + 1, end - 1):
        p, q = corner[k], corner[k + 1]
        px, py, pz = screen[p, 0] - x, screen[p, 1] - y, screen[p, 2] - z
        qx, qy, qz = screen[q, 0] - x, screen[q, 1] - y, screen[q, 2] - z
        a += py * qz - pz * qy
        b += pz * qx - px * qz
        c += px * qy - py * qx
    return a, b, c


# ---------------------------------------------------------------- scan conversion


def scan_convert(
    screen: Array,
    corner: Ints,
    slope: Array,
    table: Ints,
    size: tuple[int, int],
    mode: int,
    count: bool,
    held: type[Any] | None = None,
    form: Form | None = None,
) -> tuple[Array, Ints, Array | None]:
    """Scan convert the polygons of a table into a fresh depth buffer.

    Parameters
    ----------
    screen, corner, slope, table
        See :func:`polygon_table`. The type of ``screen`` is that of all arithmetic.
    size : (width, height)
    mode : int
        DIRECT, INCREMENTAL or FIXED.
    count : bool
        Whether to count the work, in a kernel compiled for that.
    held : type, optional
        Of the depth buffer; that of ``screen`` by default.
    form : Form, optional
        A strict test of what floats hold of z by default, in a kernel compiled for that.

    Returns
    -------
    z : (H, W) of the type held
        A buffer of floats starts at ``+inf`` and not at the textbook's 1, for a point on the far plane
        belongs to the view and must pass the strict test. One of integers has nothing beyond its greatest
        level, and starts there: what is stored as that level does not pass.
    owner : (H, W) int32
        Face of each sample, -1 where there is none.
    counts : (4,) int64 or None
        Columns SCAN_LINES to PASSED.
    """
    width, height = size
    z, owner = np.empty((height, width), held or screen.dtype), np.empty((height, width), np.int32)
    polygon, strips = deal_to_strips(table, height)
    counts = np.zeros((len(strips), 4), np.int64) if count else None
    _scan_convert(screen, corner, slope, table, polygon, strips, mode, form, (z, owner), counts)
    return z, owner, None if counts is None else counts.sum(axis=0)


@parallel_jit
def _scan_convert(
    screen: Array,
    corner: Ints,
    slope: Array,
    table: Ints,
    polygon: Ints,
    strips: Array,
    mode: int,
    form: Form | None,
    buffers: tuple[Array, Ints],
    counts: Array | None,
) -> None:
    for k in prange(len(strips)):
        listed = polygon[strips[k, 1] : strips[k, 2]]
        _scan_strip(screen, corner, slope, table, listed, strips[k, 0], mode, form, buffers, counts)


@jit
def _scan_strip(
    screen: Array,
    corner: Ints,
    slope: Array,
    table: Ints,
    listed: Ints,
    strip: int,
    mode: int,
    form: Form | None,
    buffers: tuple[Array, Ints],
    counts: Array | None,
) -> None:
    """Scan convert the listed polygons within one strip.

    Indices into the buffers are unsigned, so that no code is compiled for negative ones.
    """
    real = screen.dtype.type
    half = real(0.5)
    z, owner = buffers
    z[strip * STRIP : (strip + 1) * STRIP] = _farthest(form)
    owner[strip * STRIP : (strip + 1) * STRIP] = -1
    for i in listed:
        face, top, turn = table[i, FACE], table[i, TOP], table[i, TURN]
        x_top, y_top, z_top = screen[corner[top], 0], screen[corner[top], 1], screen[corner[top], 2]
        z_x, z_y = slope[i, 0], slope[i, 1]
        z_step = _fixed(z_x, mode)
        row = max(table[i, FIRST_LINE], strip * STRIP)
        end = min(table[i, END_LINE], (strip + 1) * STRIP)
        left, right, left_end, right_end = top, top, row, row
        while row < end:
            # Where the edge of a side ends, take the next, and step down it to this scan line.
            if left_end <= row:
                left, left_line, left_end, left_x, left_m = _edge_below(
                    screen, corner, table[i, FIRST], table[i, END], left, turn, row
                )
                left_z = z_top + (left_x - x_top) * z_x + (real(left_line) + half - y_top) * z_y
                z_m = _fixed(left_m * z_x + z_y, mode)
                x_left = _stepped(left_x, left_m, row - left_line, mode)
                z_left = _stepped(_fixed(left_z, mode), z_m, row - left_line, mode)
            if right_end <= row:
                right, right_line, right_end, right_x, right_m = _edge_below(
                    screen, corner, table[i, FIRST], table[i, END], right, -turn, row
                )
                x_right = _stepped(right_x, right_m, row - right_line, mode)

            # Fill the span between the sides, from its first pixel centre on.
            line = np.uintp(row)
            first = max(math.ceil(x_left - half), 0)
            last = max(min(math.ceil(x_right - half), z.shape[1]), first)
            passed = 0
            if mode == DIRECT:
                z_row = z_top + (real(row) + half - y_top) * z_y
                for column in range(np.uintp(first), np.uintp(last)):
                    depth = z_row + (real(column) + half - x_top) * z_x
                    passed += _drawn(depth, face, z, owner, line, column, form)
            else:
                depth = _fixed(z_left + (real(first) + half - x_left) * z_x, mode)
                for column in range(np.uintp(first), np.uintp(last)):
                    passed += _drawn(depth, face, z, owner, line, column, form)
                    depth += z_step
            if counts is not None:
                counts[strip, SCAN_LINES] += 1
                counts[strip, SPANS] += first < last
                counts[strip, FRAGMENTS] += last - first
                counts[strip, PASSED] += passed

            # Go down to the next scan line.
            row += 1
            if mode == DIRECT:
                x_left = _stepped(left_x, left_m, row - left_line, mode)
                x_right = _stepped(right_x, right_m, row - right_line, mode)
            else:
                x_left += left_m
                x_right += right_m
                z_left += z_m


@jit
def _drawn(
    depth: float, face: int, z: Array, owner: Ints, line: np.uintp, column: int, form: Form | None
) -> int:
    """Put a fragment into the buffers if it passes the depth test, and return whether it does, 0 or 1."""
    stored = _stored(depth, z, form)
    if _passes(stored, z[line, column], form):
        z[line, column] = stored
        owner[line, column] = face
        return 1
    return 0


@jit
def _stored(depth: float, z: Array, form: Form | None) -> Any:
    """Return what the buffer holds of a depth."""
    held = z.dtype.type
    if form is None or form.levels == 0:
        return held(depth)
    # Linear depth is not affine on the screen: it costs a division a fragment.
    value = -1.0 / min(depth, form.last) if form.last < 0.0 else depth
    return held(min(max(np.floor(form.scale * value + form.offset), 0.0), form.levels))


@jit
def _passes(stored: Any, kept: Any, form: Form | None) -> bool:
    """Tell whether what a fragment would store passes the depth test against what is kept."""
    if form is None:
        return bool(stored < kept)
    return bool(stored < kept or (form.test == LESS_EQUAL and stored == kept) or form.test == ALWAYS)


@jit
def _farthest(form: Form | None) -> float:
    """Return what the depth buffer starts with."""
    if form is None or form.levels == 0:
        return np.inf
    return float(form.levels)


@jit
def _edge_below(
    screen: Array, corner: Ints, first: int, end: int, k: int, turn: int, row: int
) -> tuple[int, int, int, float, float]:
    """Follow a side down from corner k to the edge that crosses a scan line.

    Returns its lower corner, its first scan line and the one after its last, x on the first, and 1/m.
    Horizontal edges cross none. The edge exists: a side ends at the lowest corner, which is below all
    scan lines of the polygon.
    """
    real = screen.dtype.type
    half = real(0.5)
    upper = k
    edge_end = row
    while edge_end <= row:
        upper = k
        k += turn
        if k == end:
            k = first
        elif k < first:
            k = end - 1
        edge_end = math.ceil(screen[corner[k], 1] - half)
    x, y = screen[corner[upper], 0], screen[corner[upper], 1]
    one_over_m = (screen[corner[k], 0] - x) / (screen[corner[k], 1] - y)
    line = max(math.ceil(y - half), 0)
    return k, line, edge_end, x + (real(line) + half - y) * one_over_m, one_over_m


@jit
def _stepped(value: float, step: float, lines: int, mode: int) -> float:
    """Return what a value becomes a number of scan lines further down."""
    if mode == DIRECT:
        return value + type(value)(lines) * step
    for _ in range(lines):
        value += step
    return value


@jit
def _fixed(value: float, mode: int) -> float:
    """Round a depth or its step to a whole number if depth is stepped in those."""
    return np.rint(value) if mode == FIXED else value
