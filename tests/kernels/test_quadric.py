"""Rays and quadrics between planes, against exact arithmetic and the textbook's own formulas."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from hsr.algorithms.raycast import _rows_of
from hsr.kernels.hits import NO_FACE, Span, cylinder_span, sphere_span
from hsr.kernels.quadric import quadric_span
from hsr.scene.shapes import generic


def span(o, d, shape="cylinder", **numbers):
    made = generic(shape, **numbers)
    rows = _rows_of(made)
    return quadric_span(tuple(map(np.float64, o)), tuple(map(np.float64, d)), rows, 0, len(rows), made.faces)


def exact_span(o, d, top):
    """The t between which a line is in the solid, found among all t where it meets side, base and cap."""
    o, d, k = [Fraction(x) for x in o], [Fraction(x) for x in d], Fraction(top) - 1
    f, g = 1 + k * o[2], k * d[2]
    a, b, c = d[0] ** 2 + d[1] ** 2 - g * g, o[0] * d[0] + o[1] * d[1] - f * g, o[0] ** 2 + o[1] ** 2 - f * f
    found = []
    if a:
        r = b * b - a * c
        if r >= 0:
            root = Fraction(math.isqrt(r.numerator * 4**300 // r.denominator), 2**300)
            found += [(-b - root) / a, (-b + root) / a]
    elif b:
        found += [-c / (2 * b)]
    found += [(height - o[2]) / d[2] for height in (0, 1)] if d[2] else []
    slack = Fraction(1, 10**40)

    def inside(t):
        x, y, z = (p + t * q for p, q in zip(o, d, strict=True))
        return -slack <= z <= 1 + slack and x * x + y * y <= (1 + k * z) ** 2 + slack

    within = [t for t in found if inside(t)]
    return (float(min(within)), float(max(within))) if within else None


@pytest.mark.parametrize("top", [0.0, 0.25, 0.5, 1.0, 2.0, 3.5])
def test_spans_are_those_of_exact_arithmetic(top):
    random, hits = np.random.default_rng(int(4 * top)), 0
    for k in range(400):
        o, d = random.integers(-16, 17, (2, 3)) / 8.0
        if not d.any():
            continue
        if k % 4 == 0:
            d[:] = (top - 1.0, 0.0, 1.0)  # along a generator
        exact, found = exact_span(o.tolist(), d.tolist(), top), span(o, d, top=top)
        if exact is None:
            # A line that touches, up to rounding, may go either way.
            assert found.face_in == NO_FACE or found.t_in > found.t_out - 1e-6
        elif exact[1] - exact[0] > 1e-6:
            hits += 1
            assert (found.t_in, found.t_out) == pytest.approx(exact, rel=1e-11, abs=1e-11)
    assert hits > 40


def test_a_line_through_both_nappes_meets_the_one_that_is_there():
    assert span((0.0, 0.0, 4.0), (0.0, 0.0, -1.0), top=0.0) == Span(3.0, 0, 4.0, 1)
    assert span((0.0, 0.0, -1.0), (0.0, 0.0, 0.5), top=0.0) == Span(2.0, 1, 4.0, 0)
    slanted = span((0.25, 0.0, 2.0), (-0.125, 0.0, -1.0), top=0.0)  # through the apex's neighbourhood
    assert slanted.face_in == 0 and 1.0 < slanted.t_in < 1.2 and (slanted.t_out, slanted.face_out) == (2.0, 1)
    assert span((0.0, 0.0, -3.0), (0.0, 0.0, 1.0), top=2.0) == Span(3.0, 1, 4.0, 2)
    within_the_other = span((0.0, 0.0, 2.0), (0.1, 0.0, 1.0), top=0.0)
    assert within_the_other.t_out < 0.0


def test_an_apex_is_a_point_of_the_side():
    touched = span((-2.0, 0.0, 1.0), (1.0, 0.0, 0.0), top=0.0)
    assert touched == Span(2.0, 0, 2.0, 0)
    for k in range(20, 60):
        beside = span((2.0**-k, 0.0, 3.0), (0.0, 0.0, -1.0), top=0.0)
        assert (beside.face_in, beside.face_out) == (0, 1)
        # There b^2 - a c is the square of the distance: its rounding moves the hit by the root of that.
        assert beside.t_in == pytest.approx(2.0 + 2.0**-k, abs=2.0**-26)


def test_a_line_on_the_side_is_inside_from_end_to_end():
    assert span((2.0, 0.0, -1.0), (-1.0, 0.0, 1.0), top=0.0) == Span(1.0, 1, 2.0, 0)
    assert span((0.0, 0.0, -1.0), (1.0, 0.0, 1.0), top=2.0) == Span(1.0, 1, 2.0, 2)
    beside = span((2.0, 1.0, -1.0), (-1.0, 0.0, 1.0), top=0.0)
    assert beside.t_in > beside.t_out


@pytest.mark.parametrize(("shape", "own"), [("sphere", sphere_span), ("cylinder", cylinder_span)])
def test_the_equation_gives_what_the_formulas_of_a_shape_give(shape, own):
    random = np.random.default_rng(4)
    for _ in range(300):
        o, d = random.normal(0.0, 1.0, (2, 3))
        found, expected = span(o, d, shape), own(tuple(o), tuple(d))
        if expected.t_in > expected.t_out - 1e-3:
            continue
        assert (found.face_in, found.face_out) == (expected.face_in, expected.face_out)
        assert (found.t_in, found.t_out) == pytest.approx(
            (expected.t_in, expected.t_out), rel=1e-12, abs=1e-12
        )


@pytest.mark.parametrize("distance", [1e3, 1e5, 1e7])
def test_a_distant_cone_is_wrong_only_in_a_thin_band(distance):
    random, hits = np.random.default_rng(int(distance)), 0
    for height in random.uniform(0.0, 1.0, 200):
        offset = random.uniform(0.0, 1.2)
        hit = span((offset, -distance, height), (0.0, 1.0, 0.0), top=0.0)
        hits += hit.t_in <= hit.t_out
        gap = offset - (1.0 - height)
        assert (hit.t_in <= hit.t_out) == (gap <= 0.0) or abs(gap) < 2.0**-48
    assert 20 < hits < 180
