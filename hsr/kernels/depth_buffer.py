"""What a depth buffer holds of a depth z, by which test a fragment gets into it, and counts of that work.

Without a :class:`Form` it is the textbook's: z itself, rounded to the type of the buffer, and ``z < buffer``.
A form is an argument that may be None, so that no code is compiled for it where there is none.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hsr.base.arrays import Array
from hsr.base.jit import jit

LESS, LESS_EQUAL, ALWAYS = range(3)
"""When a fragment passes the depth test: nearer than what the buffer holds; nearer or equal; in any case."""

SCAN_LINES, SPANS, FRAGMENTS, PASSED = range(4)
"""Counts: polygons' scan lines, those of them that cross a sample, samples tested, depth tests passed."""


class Form(NamedTuple):
    """What a depth buffer holds, how it is tested, and in which numbers depth is stepped.

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
    whole : bool
        Whether depth is stepped in whole numbers. They are held in floats: below ``2**53`` their sums are
        exact, as those of integers.
    """

    test: int = LESS
    levels: int = 0
    scale: float = 1.0
    offset: float = 0.0
    last: float = 0.0
    whole: bool = False


@jit
def span(first: int, last: int, counts: Array | None) -> range:
    """Return the columns of a span, unsigned: no code is compiled for negative indices. Count them."""
    if counts is not None:
        counts[SCAN_LINES] += 1
        counts[SPANS] += first < last
        counts[FRAGMENTS] += last - first
    return range(np.uintp(first), np.uintp(last))


@jit
def stepped(z: float, form: Form | None) -> float:
    """Return a depth, or an increment of it, in the numbers in which depth is stepped."""
    if form is None or not form.whole:
        return z
    return float(np.rint(z))


@jit
def stored_of(z: float, z_buffer: Array, form: Form | None) -> Any:
    """Return what the buffer holds of a depth."""
    real = z_buffer.dtype.type
    if form is None or form.levels == 0:
        return real(z)
    # Linear depth is not affine on the screen: it costs a division a fragment.
    value = -1.0 / min(z, form.last) if form.last < 0.0 else z
    return real(min(max(np.floor(form.scale * value + form.offset), 0.0), form.levels))


@jit
def passes(stored: Any, kept: Any, form: Form | None, counts: Array | None) -> bool:
    """Tell whether what a fragment would store passes the depth test against what is kept, and count it."""
    passed = stored < kept
    if form is not None:
        passed |= (form.test == LESS_EQUAL and stored == kept) or form.test == ALWAYS
    if counts is not None:
        counts[PASSED] += passed
    return bool(passed)


@jit
def farthest(form: Form | None) -> float:
    """Return what the depth buffer starts with.

    It is ``+inf`` and not the textbook's 1, for a point on the far plane belongs to the view and must pass
    the strict test. A buffer of integers has nothing beyond its greatest level, and starts there: what is
    stored as that level does not pass.
    """
    if form is None or form.levels == 0:
        return np.inf
    return float(form.levels)
