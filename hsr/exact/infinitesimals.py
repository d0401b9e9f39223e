"""Signs just beside a sample: polynomials in infinitesimals, and square roots of them.

The answer at a sample is the limit of the answer at (x + e, y + d), to the right and down in the
image, with d positive and smaller than every power of e. So the value of a polynomial there is a
polynomial in d and e, and its sign is that of its greatest term: the one with the least power of d
and, among those, the least power of e. That is the last term in lexicographic order. A third
infinitesimal t, greater than every power of both, leads to the limits from other directions.

With this order the polynomials are an ordered field's, in which every positive element has a root;
so comparing by squaring is as valid as it is for numbers.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import Ordering, fmpz_mpoly_ctx

from hsr.base.arrays import Array

Polynomial = Any
"""An ``fmpz_mpoly``: a polynomial with integer coefficients."""

INFINITESIMALS = fmpz_mpoly_ctx.get(("d", "e", "t"), Ordering.lex)
"""Polynomials in the infinitesimals, 0 < d << e << t << 1."""

IMAGE = fmpz_mpoly_ctx.get(("i", "j"), Ordering.lex)
"""Polynomials in the coordinates of a sample."""

I, J = IMAGE.gens()  # noqa: E741
D, E, T = INFINITESIMALS.gens()
NOTHING = IMAGE.constant(0)

Spot = tuple[Polynomial, Polynomial]
"""Where polynomials in i and j are evaluated: each a number and infinitesimals."""


def beside(i: int, j: int, toward: tuple[int, int] = (0, 0)) -> Spot:
    """Return the sample (i, j) moved by t along ``toward``, then by e to the right and d down."""
    return toward[0] * T + E + i, toward[1] * T - D + j


def constant(value: int) -> Polynomial:
    """Return a polynomial in i and j that is the same everywhere."""
    return IMAGE.constant(int(value))


def affine(form: Iterable[int]) -> Polynomial:
    """Return a i + b j + c."""
    a, b, c = (int(coefficient) for coefficient in form)
    return IMAGE.from_dict({(1, 0): a, (0, 1): b, (0, 0): c})


def coefficients(polynomial: Polynomial) -> Array:
    """Return the coefficients (6,) of i^2, i j, j^2, i, j and 1, as Python integers."""
    terms = polynomial.to_dict()
    powers = ((2, 0), (1, 1), (0, 2), (1, 0), (0, 1), (0, 0))
    return np.array([int(terms.get(power, 0)) for power in powers], dtype=object)


def at(polynomial: Polynomial, spot: Spot) -> Polynomial:
    """Evaluate a polynomial in i and j."""
    return polynomial.compose(*spot, ctx=INFINITESIMALS)


def sign(value: Polynomial) -> int:
    """Return -1, 0 or 1; 0 only if the value vanishes in a whole neighbourhood."""
    if value.is_zero():
        return 0
    return 1 if value.coeffs()[-1] > 0 else -1


@dataclass(frozen=True)
class Surd:
    """The number (p + q sqrt(r)) / s; p, q, r, s polynomials of one ring."""

    p: Polynomial
    q: Polynomial
    r: Polynomial
    s: Polynomial

    def at(self, spot: Spot) -> Surd:
        """Evaluate polynomials in i and j."""
        return Surd(at(self.p, spot), at(self.q, spot), at(self.r, spot), at(self.s, spot))

    def affine(self, slope: Polynomial, offset: Polynomial) -> Surd:
        """Return slope * self + offset."""
        return Surd(slope * self.p + offset * self.s, slope * self.q, self.r, self.s)

    def sign(self) -> int:
        """Return the sign; the denominator must not vanish."""
        return sign(self.s) * sign_with_root(self.p, self.q, self.r)

    def compared(self, other: Surd) -> int:
        """Return the sign of self - other."""
        u = self.p * other.s - other.p * self.s
        v, w = self.q * other.s, -other.q * self.s
        return sign(self.s) * sign(other.s) * sign_with_roots(u, v, self.r, w, other.r)

    def norm(self) -> Polynomial:
        """Return p^2 - q^2 r, which vanishes wherever the number does."""
        return self.p * self.p - self.q * self.q * self.r

    def norm_of_difference(self, other: Surd) -> Polynomial:
        """Return a polynomial that vanishes wherever self and other are equal."""
        u = self.p * other.s - other.p * self.s
        v, w = self.q * other.s, other.q * self.s
        if v.is_zero() and w.is_zero():
            return u
        rest = u * u + v * v * self.r - w * w * other.r
        return rest * rest - 4 * u * u * v * v * self.r


def sign_with_root(u: Polynomial, v: Polynomial, r: Polynomial) -> int:
    """Return the sign of u + v sqrt(r), r not negative."""
    first, second = sign(u), sign(v) and sign(v) * sign(r)
    if first * second >= 0:
        return first or second
    return first * sign(u * u - v * v * r)


def sign_with_roots(u: Polynomial, v: Polynomial, r: Polynomial, w: Polynomial, s: Polynomial) -> int:
    """Return the sign of u + v sqrt(r) + w sqrt(s), r and s not negative."""
    first, second = sign_with_root(u, v, r), sign(w) and sign(w) * sign(s)
    if first * second >= 0:
        return first or second
    return first * sign_with_root(u * u + v * v * r - w * w * s, 2 * u * v, r)
