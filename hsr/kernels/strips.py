"""Scan conversion on all threads: the scan lines are shared out in strips.

A strip is the piece of work of one thread. Each strip gets the list of the polygons that cross it, in
their order, and walks the edge of a polygon from its own top (or that of the image): so the strips leave no
trace in the picture, and neither does the number of threads.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hsr.base.arrays import Array, Ints
from hsr.base.jit import parallel_jit, prange
from hsr.kernels.depth_buffer import Form, farthest
from hsr.kernels.polygon_table import END_LINE, FIRST_LINE, PolygonTable
from hsr.kernels.scanline import scan_polygon
from hsr.kernels.scanline_direct import scan_polygon_directly

STRIP = 64
"""Scan lines in a strip."""

CHUNKS = 16
"""Parts in which the polygon table is dealt out to the strips, whatever the number of threads."""

GOLDEN = 0.6180339887498949
"""Its multiples, modulo 1, cut [0, 1) evenly however many there are."""


def scan_convert(
    table: PolygonTable,
    size: tuple[int, int],
    directly: bool,
    count: bool = False,
    held: type[Any] | None = None,
    form: Form | None = None,
) -> tuple[Array, Ints, Array | None]:
    """Scan convert the polygons of a table into a fresh depth buffer.

    Parameters
    ----------
    table : PolygonTable
    size : (width, height)
    directly : bool
        Whether sides and depths are evaluated anew, or carried on by increments.
    count : bool
        Whether to count the work, in a kernel compiled for that.
    held : type, optional
        Of the depth buffer; that of the screen coordinates by default.
    form : Form, optional
        A strict test of what floats hold of z by default, in a kernel compiled for that.

    Returns
    -------
    z : (H, W) of the type held
    owner : (H, W) int32
        Face of each sample, -1 where there is none.
    counts : (4,) int64 or None
        Columns SCAN_LINES to PASSED.
    """
    width, height = size
    buffers = np.empty((height, width), held or table.screen.dtype), np.empty((height, width), np.int32)
    polygon, strips = deal_to_strips(table.row, height)
    counts = np.zeros((len(strips), 4), np.int64) if count else None
    straight = True if directly else None
    _scan_convert(table, polygon, strips, straight, buffers, form, counts)
    return *buffers, None if counts is None else counts.sum(axis=0)


@parallel_jit
def _scan_convert(
    table: PolygonTable,
    polygon: Ints,
    strips: Array,
    directly: bool | None,
    buffers: tuple[Array, Ints],
    form: Form | None,
    counts: Array | None,
) -> None:
    z, owner = buffers
    for k in prange(len(strips)):
        start, end = strips[k, 0] * STRIP, (strips[k, 0] + 1) * STRIP
        z[start:end] = farthest(form)
        owner[start:end] = -1
        own = None if counts is None else counts[k]
        for i in polygon[strips[k, 1] : strips[k, 2]]:
            lines = max(table.row[i, FIRST_LINE], start), min(table.row[i, END_LINE], end)
            # Only one of the ways is compiled.
            if directly is None:
                scan_polygon(table, i, lines, buffers, form, own)
            else:
                scan_polygon_directly(table, i, lines, buffers, form, own)


def deal_to_strips(rows: Ints, height: int) -> tuple[Ints, Array]:
    """List for each strip of the image the polygons that cross it, in their order.

    Parameters
    ----------
    rows : (P, columns) int32
        Of polygons; the first two columns are FIRST_LINE and END_LINE.
    height : int

    Returns
    -------
    polygon : (n,) int32
        Polygon indices, list after list.
    strips : (S, 3) int64
        A strip, where its list begins in ``polygon`` and where it ends. Strips come scattered over the
        image, so that threads that take equal parts of this array have about equal work.
    """
    number = np.arange(-(-height // STRIP))
    count = np.zeros((CHUNKS, len(number)), np.int64)
    _count_by_strip(rows, count)
    # Within a list the chunks follow each other, so that polygons stay in order.
    place = np.concatenate([[0], np.cumsum(count.T)])
    polygon = np.empty(place[-1], np.int32)
    begin, end = place[:-1:CHUNKS], place[CHUNKS::CHUNKS]
    _list_by_strip(rows, place[:-1].reshape(-1, CHUNKS).T.copy(), polygon)
    scattered = np.argsort(number * GOLDEN % 1.0)
    return polygon, np.stack([number, begin, end], axis=1)[scattered]


@parallel_jit
def _count_by_strip(rows: Ints, count: Array) -> None:
    for chunk in prange(CHUNKS):
        for i in range(chunk * len(rows) // CHUNKS, (chunk + 1) * len(rows) // CHUNKS):
            for strip in range(rows[i, FIRST_LINE] // STRIP, -(-rows[i, END_LINE] // STRIP)):
                count[chunk, strip] += 1


@parallel_jit
def _list_by_strip(rows: Ints, place: Array, polygon: Ints) -> None:
    for chunk in prange(CHUNKS):
        for i in range(chunk * len(rows) // CHUNKS, (chunk + 1) * len(rows) // CHUNKS):
            for strip in range(rows[i, FIRST_LINE] // STRIP, -(-rows[i, END_LINE] // STRIP)):
                polygon[place[chunk, strip]] = i
                place[chunk, strip] += 1
