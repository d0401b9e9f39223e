"""Strips of scan lines: how the polygons of an image are shared out among threads.

A strip is the piece of work of one thread. Each strip gets the list of the polygons that cross it, in
their order, so the picture does not depend on the number of threads.
"""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array, Ints
from hsr.base.jit import parallel_jit, prange

STRIP = 64
"""Scan lines in a strip, the piece of work of one thread."""

CHUNKS = 16
"""Parts in which the polygon table is dealt out to the strips, whatever the number of threads."""

GOLDEN = 0.6180339887498949
"""Its multiples, modulo 1, cut [0, 1) evenly however many there are."""

FIRST_LINE, END_LINE = 0, 1
"""Columns of a polygon table: its first scan line and the one after its last."""


def deal_to_strips(table: Ints, height: int) -> tuple[Ints, Array]:
    """List for each strip of the image the polygons that cross it, in their order.

    Parameters
    ----------
    table : (P, columns) int32
        Polygons; its first two columns are FIRST_LINE and END_LINE.
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
    _count_by_strip(table, count)
    # Within a list the chunks follow each other, so that polygons stay in order.
    place = np.concatenate([[0], np.cumsum(count.T)])
    polygon = np.empty(place[-1], np.int32)
    begin, end = place[:-1:CHUNKS], place[CHUNKS::CHUNKS]
    _list_by_strip(table, place[:-1].reshape(-1, CHUNKS).T.copy(), polygon)
    scattered = np.argsort(number * GOLDEN % 1.0)
    return polygon, np.stack([number, begin, end], axis=1)[scattered]


@parallel_jit
def _count_by_strip(table: Ints, count: Array) -> None:
    for chunk in prange(CHUNKS):
        for i in range(chunk * len(table) // CHUNKS, (chunk + 1) * len(table) // CHUNKS):
            for strip in range(table[i, FIRST_LINE] // STRIP, -(-table[i, END_LINE] // STRIP)):
                count[chunk, strip] += 1


@parallel_jit
def _list_by_strip(table: Ints, place: Array, polygon: Ints) -> None:
    for chunk in prange(CHUNKS):
        for i in range(chunk * len(table) // CHUNKS, (chunk + 1) * len(table) // CHUNKS):
            for strip in range(table[i, FIRST_LINE] // STRIP, -(-table[i, END_LINE] // STRIP)):
                polygon[place[chunk, strip]] = i
                place[chunk, strip] += 1
