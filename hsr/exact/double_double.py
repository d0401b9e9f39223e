"""Numbers of twice the precision of float64: the sum of two, the lesser a correction of the greater.

Dekker, "A floating-point technique for extending the available precision" (1971); Knuth, "The Art
of Computer Programming", volume 2, section 4.2.2, theorem B. Each operation is off by at most
``PRECISION`` = 2^-98 of its result; a sum, of the sum of its absolute values. (Joldes, Muller and
Popescu, "Tight and rigorous error bounds for basic building blocks of double-word arithmetic",
2017, prove 2^-102 or less for each; the rest is for the roundings of bounds.)

Every number here is a triple: greater part, lesser part, and a bound of the error of both together.
"""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array, Floats
from hsr.base.jit import jit

PRECISION = 2.0**-98
SPLIT = 2.0**27 + 1.0
GOOD = 2.0**-60
"""Relative error up to which a result may be rounded to float64."""

BITS = 120
"""Bits of a coefficient."""

TINY = 2.0**-1000
"""Outweighs what underflow can take away."""

Number = tuple[float, float, float]


@jit
def two_sum(a: float, b: float) -> tuple[float, float]:
    """Return the sum of two floats and what its rounding took away."""
    total = a + b
    of_b = total - a
    return total, (a - (total - of_b)) + (b - of_b)


@jit
def two_product(a: float, b: float) -> tuple[float, float]:
    """Return the product of two floats and what its rounding took away."""
    product = a * b
    a_high, b_high = SPLIT * a, SPLIT * b
    a_high, b_high = a_high - (a_high - a), b_high - (b_high - b)
    a_low, b_low = a - a_high, b - b_high
    return product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


@jit
def add(a: Number, b: Number) -> Number:
    """Return a + b."""
    high, low = two_sum(a[0], b[0])
    high, low = two_sum(high, low + (a[1] + b[1]))
    return high, low, a[2] + b[2] + PRECISION * (abs(a[0]) + abs(b[0]))


@jit
def times(a: Number, b: Number) -> Number:
    """Return a b."""
    high, low = two_product(a[0], b[0])
    high, low = two_sum(high, low + (a[0] * b[1] + a[1] * b[0]))
    # The product of the errors is far below the 2^-98 kept for rounding.
    return high, low, abs(a[0]) * b[2] + abs(b[0]) * a[2] + a[2] * b[2] + PRECISION * abs(high)


@jit
def root(a: Number) -> Number:
    """Return the square root of a number that is greater than twice its error."""
    first = np.sqrt(a[0])
    square, rest = two_product(first, first)
    high, low = two_sum(first, (a[0] - square - rest + a[1]) / (2.0 * first))
    # sqrt(a + error) - sqrt(a) <= error / sqrt(a), halved if it were not for the bound itself.
    return high, low, a[2] / first + PRECISION * first


@jit
def quotient(a: Number, b: Number) -> float:
    """Return a / b rounded to float64, NaN if its relative error may exceed ``GOOD``."""
    if a[2] > 0.25 * GOOD * abs(a[0]) or b[2] > 0.25 * GOOD * abs(b[0]):
        return np.nan
    first = a[0] / b[0]
    product, rest = two_product(first, b[0])
    return first + (a[0] - product - rest + a[1] - first * b[1]) / b[0]


@jit
def at(coefficients: Floats, i: int, j: int) -> Number:
    """Evaluate a polynomial in (i, j); coefficients (3, 6) as :func:`split` makes them."""
    powers = (float(i * i), float(i * j), float(j * j), float(i), float(j), 1.0)
    total = (0.0, 0.0, 0.0)
    for k in range(6):
        number = (coefficients[0, k], coefficients[1, k], coefficients[2, k])
        total = add(total, times(number, (powers[k], 0.0, 0.0)))
    return total


@jit
def depths(parts: Floats, signs: Floats, which: Array, i: Array, j: Array) -> Floats:
    """Evaluate the depths of many samples.

    Parameters
    ----------
    parts : (n, 2, 2, 3, 6) float64
        p and r of each numerator and denominator p + s sqrt(r), polynomials as :func:`split` makes them.
    signs : (n, 2) float64
        Their s, -1, 0 or 1.
    which, i, j : (m,) int64
        Quotient and coordinates of each sample.

    Returns
    -------
    (m,) float64
        NaN where the depth could not be had to within 2^-60 of itself before it is rounded.
    """
    depth = np.empty(len(which))
    for n in range(len(which)):
        part, sign = parts[which[n]], signs[which[n]]
        depth[n] = quotient(surd(part[0], sign[0], i[n], j[n]), surd(part[1], sign[1], i[n], j[n]))
    return depth


@jit
def surd(part: Floats, sign: float, i: int, j: int) -> Number:
    """Return p + sign sqrt(r), of infinite error where r may vanish."""
    p = at(part[0], i, j)
    if sign == 0.0:
        return p
    r = at(part[1], i, j)
    if r[0] <= 2.0 * r[2]:
        return p[0], p[1], np.inf
    high, low, error = root(r)
    return add(p, (sign * high, sign * low, error))


def bits(numbers: Array) -> Array:
    """Return the bits of the greatest of each row of integers (..., k), as (...) int64."""
    return np.asarray(np.max(np.frompyfunc(int.bit_length, 1, 1)(numbers), axis=-1), dtype=np.int64)


def split(numbers: Array, scale: Array, lengths: Array) -> Floats:
    """Cut the integers of each row to :data:`BITS` bits, and those to two floats.

    Parameters
    ----------
    numbers : (n, ..., k) object
    scale : (n,) int64
    lengths : (n, ...) int64
        Their :func:`bits`.

    Returns
    -------
    (n, ..., 3, k) float64
        Greater parts, lesser parts and errors of ``numbers / 2**scale``.
    """
    excess = (lengths - BITS)[..., None]
    cut = (numbers << np.maximum(-excess, 0).astype(object)) >> np.maximum(excess, 0).astype(object)
    high = cut.astype(np.float64)
    low = (cut - np.frompyfunc(int, 1, 1)(high)).astype(np.float64)
    error = 1.0 + PRECISION * np.abs(high)
    with np.errstate(over="ignore"):  # what is computed from infinity ends as NaN
        parts = np.ldexp(np.stack([high, low, error], axis=-2), (excess.T - scale).T[..., None])
    parts[..., 2, :] += TINY
    return np.asarray(parts)
