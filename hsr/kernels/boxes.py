"""Extents: the box a ray must meet.

Extents only save work. Whatever lies in an extent must be found through it, so every test here errs
on the side of "may meet": boxes are closed, and rounding is covered by paddings derived beside them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hsr.base.jit import jit
from hsr.kernels.vectors import Vector

TWO_ULP = 2.0**-51
"""Two units in the last place of 1: the padding of Ize, "Robust BVH Ray Traversal" (JCGT 2013)."""


class Beam(NamedTuple):
    """A ray as the box test wants it: within ``margin`` of a line, from depth ``near`` to ``far``.

    Attributes
    ----------
    origin, inverse, margin : 3 floats
        Start, reciprocal of the direction (infinite, of its sign, where that is 0), and half its thickness.
    near, far : float
        The parameters between which it runs, closed.
    """

    origin: Vector
    inverse: Vector
    margin: Vector
    near: float
    far: float


@jit
def box_entry(box: Any, beam: Beam) -> float:
    """Return the parameter at which a beam enters a closed box, ``+inf`` if it misses.

    The slab test of Kay and Kajiya (1986). An entry before ``beam.near`` counts as ``beam.near``.

    Parameters
    ----------
    box : record with ``low`` and ``high``, (3,) float64
        Opposite corners, finite.
    beam : Beam
    """
    t_in, t_out = beam.near, beam.far
    for axis in range(3):
        inverse, start = beam.inverse[axis], beam.origin[axis]
        least = box["low"][axis] - beam.margin[axis]
        most = box["high"][axis] + beam.margin[axis]
        if np.isinf(inverse):
            # Parallel to the slab, or as good as: no quotient here, since 0 times infinity is NaN.
            if start < least or start > most:
                return np.inf
            continue
        first, last = (least, most) if inverse > 0.0 else (most, least)
        t_first, t_last = (first - start) * inverse, (last - start) * inverse
        t_in = max(t_in, t_first)
        t_out = min(t_out, t_last + abs(t_last) * TWO_ULP)
    return t_in if t_in <= t_out else np.inf


@jit
def naive_entry(box: Any, beam: Beam) -> float:
    """Return what :func:`box_entry` does, but without any care, as a thing to study.

    The beam is taken as infinitely thin, and quotients as they come. A ray within the plane of a side
    computes 0 times infinity there; comparisons with that NaN are false, so that it depends on the sign
    of the 0 whether the ray meets the box. A ray that grazes an edge is lost to rounding about one time
    in ten (Ize 2013).
    """
    t_in, t_out = beam.near, beam.far
    for axis in range(3):
        inverse, start = beam.inverse[axis], beam.origin[axis]
        t_first, t_last = (box["low"][axis] - start) * inverse, (box["high"][axis] - start) * inverse
        if t_first > t_last:
            t_first, t_last = t_last, t_first
        if t_first > t_in:
            t_in = t_first
        if t_last < t_out:
            t_out = t_last
    return t_in if t_in <= t_out else np.inf


@jit
def reciprocal(number: float) -> float:
    """Return 1 / number, for 0 infinity of its sign."""
    return 1.0 / number if number != 0.0 else np.copysign(np.inf, number)
