"""Numbers of doubled precision against fractions: never farther off than they say."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from hsr.exact.double_double import Number, add, at, bits, quotient, root, split, times

parts = st.floats(1e-30, 1e30) | st.floats(-1e30, -1e30 / 3) | st.just(0.0)
numbers = st.tuples(parts, st.floats(-1.0, 1.0), st.floats(0.0, 1e-3)).map(
    lambda parts: (parts[0], parts[0] * parts[1] * 2.0**-53, abs(parts[0]) * parts[2] * 2.0**-70)
)


def exact(number: Number) -> Fraction:
    return Fraction(float(number[0])) + Fraction(float(number[1]))


def within(result: Number, truth: Fraction, inherited: Fraction) -> bool:
    """Whether the result is off by no more than its bound, less what it inherits."""
    return abs(exact(result) - truth) <= Fraction(float(result[2])) - inherited * Fraction(99, 100)


@settings(deadline=None)
@given(numbers, numbers)
def test_sums(a: Number, b: Number) -> None:
    assert within(add(a, b), exact(a) + exact(b), Fraction(a[2]) + Fraction(b[2]))


@settings(deadline=None)
@given(numbers, numbers)
def test_products(a: Number, b: Number) -> None:
    inherited = abs(Fraction(a[0])) * Fraction(b[2]) + abs(Fraction(b[0])) * Fraction(a[2])
    assert within(times(a, b), exact(a) * exact(b), inherited)


@settings(deadline=None)
@given(st.floats(1e-30, 1e30), st.floats(-1.0, 1.0))
def test_roots(high: float, low: float) -> None:
    a = (high, high * low * 2.0**-53, 0.0)
    result = root(a)
    # x is within d of sqrt(a) if (x - d)^2 <= a <= (x + d)^2.
    middle, bound = exact(result), Fraction(float(result[2]))
    assert (middle - bound) ** 2 <= exact(a) <= (middle + bound) ** 2


@settings(deadline=None)
@given(numbers, numbers.filter(lambda number: number[0] != 0.0))
def test_quotients_are_rounded_once(a: Number, b: Number) -> None:
    result = float(quotient(a, b))
    truth = exact(a) / exact(b)
    assert abs(Fraction(result) - truth) <= Fraction(0.51) * Fraction(float(np.spacing(abs(result))))


def test_a_quotient_that_is_not_known_well_is_refused() -> None:
    assert np.isnan(quotient((1.0, 0.0, 2.0**-60), (1.0, 0.0, 0.0)))
    assert np.isnan(quotient((1.0, 0.0, 0.0), (1.0, 0.0, 2.0**-60)))
    assert np.isnan(quotient((0.0, 0.0, 2.0**-900), (1.0, 0.0, 0.0)))


@settings(deadline=None)
@given(st.lists(st.integers(-(10**60), 10**60), min_size=6, max_size=6), st.integers(0, 220))
def test_polynomials_of_split_integers(coefficients: list[int], scale: int) -> None:
    whole = np.array([coefficients], dtype=object)
    i, j = 1023, -77
    value = at(split(whole, np.array([scale]), bits(whole))[0], i, j)
    powers = (i * i, i * j, j * j, i, j, 1)
    truth = Fraction(sum(c * p for c, p in zip(coefficients, powers, strict=True)), 2**scale)
    assert abs(exact(value) - truth) <= Fraction(float(value[2]))


def test_bits() -> None:
    assert bits(np.array([[1, -8], [0, 3]], dtype=object)).tolist() == [4, 2]
