"""Signs beside a sample."""

from __future__ import annotations

from math import isqrt

from hypothesis import given
from hypothesis import strategies as st

from hsr.exact.infinitesimals import (
    INFINITESIMALS,
    D,
    E,
    I,
    J,
    Surd,
    T,
    affine,
    at,
    beside,
    coefficients,
    constant,
    sign,
    sign_with_root,
    sign_with_roots,
)

small = st.integers(-20, 20)
square_free = st.integers(0, 30)


def test_powers_of_t_outweigh_e_and_those_of_e_outweigh_d() -> None:
    assert sign(T**3 - 100 * E) == 1
    assert sign(E**3 - 100 * D) == 1
    assert sign(D - 100 * D * E) == 1
    assert sign(-1 + T) == -1
    assert sign(E - E) == 0


def test_the_limit_is_from_the_right_and_below() -> None:
    right, above = affine((1, 0, 0)), affine((0, 1, 0))
    assert sign(at(right, beside(0, 0))) == 1
    assert sign(at(above, beside(0, 0))) == -1
    # Along a line that falls to the right by any slope the first step decides.
    assert sign(at(affine((1, 1000, 0)), beside(0, 0))) == 1
    assert sign(at(right, beside(0, 0, (-1, 5)))) == -1
    assert coefficients(I * I - 3 * J + 4).tolist() == [1, 0, 0, 0, -3, 4]


def number(value: int):
    return INFINITESIMALS.constant(value)


def exact_sign(u: int, v: int, r: int, w: int = 0, s: int = 0) -> int:
    """The sign of u + v sqrt(r) + w sqrt(s), with 200 bits after the point; 0 if nothing is left."""
    bits = 200
    roots = [(factor, isqrt(square << 2 * bits)) for factor, square in ((v, r), (w, s))]
    total = (u << bits) + sum(factor * root for factor, root in roots)
    return 0 if abs(total) < 1 << bits - 150 else 1 if total > 0 else -1


@given(small, small, square_free)
def test_sign_with_one_root(u: int, v: int, r: int) -> None:
    assert sign_with_root(number(u), number(v), number(r)) == exact_sign(u, v, r)


@given(small, small, square_free, small, square_free)
def test_sign_with_two_roots(u: int, v: int, r: int, w: int, s: int) -> None:
    assert sign_with_roots(*map(number, (u, v, r, w, s))) == exact_sign(u, v, r, w, s)


def test_roots_that_differ_by_an_infinitesimal() -> None:
    # sqrt(1 + e) < 1 + e / 2, though the two agree to first order.
    half = Surd(number(2) + E, number(0), number(0), number(2))
    root = Surd(number(0), number(1), 1 + E, number(1))
    assert root.compared(half) == -1
    assert root.compared(root) == 0
    assert Surd(number(0), number(-1), 1 + E, number(-1)).compared(root) == 0


def test_norms_vanish_where_surds_do() -> None:
    # (i + sqrt(j)) / 3 is 0 at (-2, 4); equal to 2 at (4, 4).
    surd = Surd(I, constant(1), J, constant(3))
    assert surd.norm()(-2, 4) == 0
    two = Surd(constant(2), constant(0), constant(0), constant(1))
    assert surd.norm_of_difference(two)(4, 4) == 0
    assert surd.norm_of_difference(two)(5, 4) != 0
    assert surd.affine(constant(3), constant(0)).at(beside(-2, 4)).sign() == 1
