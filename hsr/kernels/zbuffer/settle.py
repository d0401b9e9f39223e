"""What a depth buffer of keys leaves in doubt, written down, and settled when all is drawn.

Only certain coverage enters the keys (:mod:`hsr.kernels.zbuffer.fill`). A sample on an edge, within the error
of the edge functions, or two depths within their error, is a *doubt*: every triangle that might own the
sample is noted, unless something certain is certainly nearer. So at a sample without doubts the key is
right, and at one with doubts the owner is among what was noted. The order in which triangles come leaves no
trace.
"""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array, Floats
from hsr.base.jit import jit
from hsr.kernels.zbuffer.fill import EMPTY, Limits, Window, at, columns_of, key_of, row_of
from hsr.kernels.zbuffer.setup import BOTTOM, BOUND, LEFT, NEAREST, NUMBER, TOP

DOUBT = np.dtype([("sample", np.int64), ("key", np.int64), ("sure", np.bool_)])
"""A triangle that may own a sample, by its key; whether it certainly covers it."""

USED = 0
"""Column of the counts: doubts noted, whether or not there was room."""


@jit
def note(
    table: Floats, i: int, keys: Array, window: Window, limits: Limits | None, doubts: Array, counts: Array
) -> None:
    """Note the doubts of a triangle that has just been taken into the keys.

    What it ties with need not be written down: either the keys still show it in the end, see :func:`settle`,
    or it is certainly hidden.
    """
    left, top, bound = int(table[LEFT + i]), int(table[TOP + i]), table[BOUND + i]
    begin, end = columns_of(table, i, keys, window)
    gap, number = window.gap, int(table[NUMBER + i])
    for line in range(max(top, window.line), min(int(table[BOTTOM + i]), window.line + len(keys))):
        row = row_of(table, i, float(line - top))
        for column in range(begin, end):
            inner, z = at(row, float(column - left), limits)
            key, old = key_of(z, window.mask, number), keys[line - window.line, column - window.column]
            sample = line * window.width + column

            # Note an edge that rounding decides, and a depth that may be equal to what is shown.
            if abs(inner) < bound:
                if not is_farther(key, old, gap):
                    write(doubts, counts, sample, key, False)
            elif inner >= bound and key != old and abs(old - key) <= gap:
                write(doubts, counts, sample, key, True)


@jit
def suspect(table: Floats, i: int, keys: Array, window: Window, doubts: Array, counts: Array) -> None:
    """Note a triangle of which little is certain wherever it may be.

    It may be turned either way, and is taken to be as near as its nearest corner.
    """
    left, top, bound = int(table[LEFT + i]), int(table[TOP + i]), table[BOUND + i]
    begin, end = columns_of(table, i, keys, window)
    key = key_of(max(table[NEAREST + i], 1.0), window.mask, int(table[NUMBER + i]))
    for line in range(max(top, window.line), min(int(table[BOTTOM + i]), window.line + len(keys))):
        row = row_of(table, i, float(line - top))
        for column in range(begin, end):
            right = float(column - left)
            e0, e1, e2 = row[0] + right * row[1], row[2] + right * row[3], row[4] + right * row[5]
            may_cover = min(min(e0, e1), e2) > -bound or max(max(e0, e1), e2) < bound
            if may_cover and not is_farther(
                key, keys[line - window.line, column - window.column], window.gap
            ):
                write(doubts, counts, line * window.width + column, key, False)


@jit
def is_farther(key: int, old: int, gap: int) -> bool:
    """Whether a key is certainly farther than what is there."""
    return bool(key - old > gap)


@jit
def write(doubts: Array, counts: Array, sample: int, key: int, sure: bool) -> None:
    """Note one doubt, if there is room."""
    if counts[USED] < len(doubts):
        doubt = doubts[counts[USED]]
        doubt["sample"], doubt["key"], doubt["sure"] = sample, key, sure
    counts[USED] += 1


@jit
def settle(keys: Array, window: Window, doubts: Array, counts: Array) -> None:
    """Forget doubts about what is certainly hidden; where some are left, add what the keys show."""
    if counts[USED] > len(doubts):
        return
    # Forget what is certainly hidden.
    kept = 0
    for k in range(counts[USED]):
        doubt = doubts[k]
        line, column = divmod(doubt["sample"], window.width)
        if not is_farther(doubt["key"], keys[line - window.line, column - window.column], window.gap):
            left = doubts[kept]
            left["sample"], left["key"], left["sure"] = doubt["sample"], doubt["key"], doubt["sure"]
            kept += 1
    counts[USED] = kept

    # Add what is shown wherever a doubt is left: it is a candidate, too.
    for k in range(kept):
        sample = doubts[k]["sample"]
        line, column = divmod(sample, window.width)
        key = keys[line - window.line, column - window.column]
        if key != EMPTY:
            write(doubts, counts, sample, key, True)
