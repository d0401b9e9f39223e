"""Depths of owners, from integers: rounded once, at the very end."""

from __future__ import annotations

from math import isqrt

import numpy as np

from hsr.arrays import Array, Floats, Ints
from hsr.exact.decide import Piece
from hsr.exact.germs import Polynomial
from hsr.exact.numbers import Frame
from hsr.exact.planes import on_planes, ratio
from hsr.exact.ties import CHUNK, Problem

GUARD = 70
"""Bits beyond those that the subtraction in p + q sqrt(r) can cancel."""


def depths_of(frame: Frame, problem: Problem, owner: Ints) -> Floats:
    """Return the depth (H W,) of the piece ``owner`` of every sample, infinite for the background.

    On planes depths are the float64 nearest to the true ones; on curved surfaces they are rounded
    from numbers within 2^-69 of the true ones.
    """
    depth = np.full(len(owner), np.inf)
    flat = np.flatnonzero((owner >= 0) & (owner < len(problem.triangles)))
    for first in range(0, len(flat), CHUNK):
        some = flat[first : first + CHUNK]
        depth[some] = _on_planes(frame, problem, some, owner[some])
    for this in problem.rounds:
        some = np.flatnonzero(owner == this.piece.number)
        depth[some] = _on_round(frame, this.piece, *problem.at(some))
    return depth


def _on_planes(frame: Frame, problem: Problem, sample: Array, owner: Ints) -> Floats:
    owners, which = np.unique(owner, return_inverse=True)
    zeta, det = problem.triangles.zeta[owners], problem.triangles.det[owners]
    i, j = problem.at(sample)

    def value(form: Array) -> Array:
        a, b, c = on_planes(form, zeta, det).T
        return np.asarray(a[which] * i + b[which] * j + c[which])

    return ratio(value(frame.depth), value(frame.unit))


def _on_round(frame: Frame, piece: Piece, i: Array, j: Array) -> Floats:
    """Approximate zeta = (p + q sqrt(r)) / s as a quotient of integers, then as above.

    Unless p + q sqrt(r) is 0, its product with p - q sqrt(r) is an integer other than 0; so it
    is at least 1 / (|p| + sqrt(r)). A root with as many bits after the point as that has before it,
    and ``GUARD`` more, leaves a relative error of 2^-GUARD at most.
    """
    p, q, r, s = (_values(polynomial, i, j) for polynomial in (piece.zeta.p, piece.zeta.q, piece.zeta.r, piece.zeta.s))
    bits = GUARD + max((int(x).bit_length() for x in (*p, *(r + 1))), default=0)
    root = np.frompyfunc(isqrt, 1, 1)(r << 2 * bits)
    numerator, denominator = (p << bits) + q * root, s << bits

    def value(form: Array) -> Array:
        a, b, c, k = form
        return (a * i + b * j + c) * denominator + k * numerator

    return ratio(value(frame.depth), value(frame.unit))


def _values(polynomial: Polynomial, i: Array, j: Array) -> Array:
    """Values of a polynomial of degree two at most."""
    terms = polynomial.to_dict()
    return sum((int(value) * i ** int(m) * j ** int(n) for (m, n), value in terms.items()), np.zeros(len(i), dtype=object))
