"""Hits of the generic shapes, against exact arithmetic on rational lines."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hsr.kernels.quadrics import (
    BACK,
    BASE,
    CAP,
    FRONT,
    NO_FACE,
    SIDE,
    Span,
    cylinder_span,
    first_hit,
    polyhedron_span,
    sphere_span,
    square_hit,
)

TOP, BOTTOM, RIGHT, LEFT, NEAR, FAR = range(6)
CUBE = np.array(
    [[0, 1, 0, 1], [0, -1, 0, 1], [1, 0, 0, 1], [-1, 0, 0, 1], [0, 0, 1, 1], [0, 0, -1, 1]], float
)

eighths = st.integers(-32, 32).map(lambda k: k / 8.0)
points = st.tuples(eighths, eighths, eighths)
directions = points.filter(any)


def cube_span(o, d):
    return polyhedron_span(o, d, CUBE, 0, 6)


def exact_sphere(o, d):
    """Return whether the line touches the sphere, and its two parameters, correctly rounded enough."""
    o, d = [Fraction(x) for x in o], [Fraction(x) for x in d]
    a = sum(x * x for x in d)
    b = sum(x * y for x, y in zip(o, d, strict=True))
    disc = b * b - a * (sum(x * x for x in o) - 1)
    if disc < 0:
        return None
    root = Fraction(math.isqrt(disc.numerator * 4**400 // disc.denominator), 2**400)
    return float((-b - root) / a), float((-b + root) / a)


@settings(deadline=None)
@given(points, directions)
def test_sphere_is_that_of_exact_arithmetic(o, d):
    exact, span = exact_sphere(o, d), sphere_span(o, d)
    a = sum(x * x for x in d)
    b = sum(x * y for x, y in zip(o, d, strict=True))
    gap = sum(x * x for x in o) - 1 - b * b / a
    if abs(gap) < 1e-13:  # Tangent up to rounding, which may go either way.
        return
    assert (exact is None) == (span.t_in > span.t_out)
    if exact is not None:
        # A root moves by the rounding of 1 - v^2, magnified where the line is nearly a tangent.
        slack = 1e-13 * (1 + max(map(abs, exact))) / math.sqrt(abs(gap))
        assert span.t_in == pytest.approx(exact[0], abs=slack)
        assert span.t_out == pytest.approx(exact[1], abs=slack)


def test_a_tangent_touches_the_sphere_in_one_point():
    assert sphere_span((1.0, -4.0, 0.0), (0.0, 1.0, 0.0)) == Span(4.0, 0, 4.0, 0)
    beyond = math.nextafter(1.0, 2.0)
    assert sphere_span((beyond, -4.0, 0.0), (0.0, 1.0, 0.0)).face_in == NO_FACE
    assert sphere_span((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)) == Span(0.0, 0, 0.0, 0)


def test_sphere_seen_from_its_centre_and_its_surface():
    assert sphere_span((0.0, 0.0, 0.0), (0.0, 0.0, -2.0)) == Span(-0.5, 0, 0.5, 0)
    assert sphere_span((0.0, 0.0, 1.0), (0.0, 0.0, -1.0)) == Span(0.0, 0, 2.0, 0)


@pytest.mark.parametrize("distance", [1e3, 1e5, 1e7])
def test_distant_sphere_is_wrong_only_in_a_thin_band(distance):
    """The textbook's b^2 - 4 a c loses the sphere here; the band of doubt is one of rounding."""
    random = np.random.default_rng(int(distance))
    for offset in random.uniform(0.0, 1.2, 300):
        angle = random.uniform(0.0, 2.0 * np.pi)
        aim = (offset * math.cos(angle), offset * math.sin(angle), 0.0)
        o = (0.0, 0.0, distance)
        d = (aim[0], aim[1], -distance)
        hit = sphere_span(o, d).face_in != NO_FACE
        x, y, z = (Fraction(c) for c in d)
        exact = (x * x + y * y) * Fraction(distance) ** 2 <= x * x + y * y + z * z
        assert hit == exact or abs(offset - 1.0) < 2.0**-52 * distance


def test_cube_hits_are_exact_on_rational_lines():
    assert cube_span((0.0, 0.0, 4.0), (0.0, 0.0, -1.0)) == Span(3.0, NEAR, 5.0, FAR)
    assert cube_span((0.25, 4.0, 0.5), (0.125, -1.0, 0.0)) == Span(3.0, TOP, 5.0, BOTTOM)
    assert cube_span((0.0, 0.0, 0.0), (1.0, 0.5, 0.25)) == Span(-1.0, LEFT, 1.0, RIGHT)


def test_lines_within_a_plane_of_the_cube_are_inside_it():
    assert cube_span((1.0, 0.0, 4.0), (0.0, 0.0, -1.0)) == Span(3.0, NEAR, 5.0, FAR)
    assert cube_span((1.0, 1.0, 4.0), (0.0, 0.0, -1.0)) == Span(3.0, NEAR, 5.0, FAR)
    beyond = cube_span((math.nextafter(1.0, 2.0), 0.0, 4.0), (0.0, 0.0, -1.0))
    assert beyond.t_in > beyond.t_out


def test_the_lower_face_owns_an_edge_and_a_corner():
    corner = cube_span((3.0, 3.0, 3.0), (-1.0, -1.0, -1.0))
    assert corner == Span(2.0, TOP, 4.0, BOTTOM)
    edge = cube_span((3.0, 0.0, 3.0), (-1.0, 0.0, -1.0))
    assert edge == Span(2.0, RIGHT, 4.0, LEFT)
    touch = cube_span((2.0, 0.0, 0.0), (-1.0, 1.0, 0.0))
    assert (touch.t_in, touch.face_in, touch.t_out, touch.face_out) == (1.0, RIGHT, 1.0, TOP)


@settings(deadline=None)
@given(points, directions)
def test_cube_is_that_of_exact_arithmetic(o, d):
    t_in, t_out, hit = Fraction(-(10**9)), Fraction(10**9), True
    for x, c in zip(o, d, strict=True):
        x, c = Fraction(x), Fraction(c)
        if c == 0:
            hit = hit and abs(x) <= 1
        else:
            one, two = sorted([(-1 - x) / c, (1 - x) / c])
            t_in, t_out = max(t_in, one), min(t_out, two)
    span = cube_span(o, d)
    assert (hit and t_in <= t_out) == (span.t_in <= span.t_out)
    if hit and t_in <= t_out:
        assert (span.t_in, span.t_out) == (float(t_in), float(t_out))


def test_square_border_counts_and_edge_on_does_not():
    assert square_hit((1.0, -1.0, 2.0), (0.0, 0.0, -1.0), 0.0, 9.0, 0) == (2.0, 0)
    beyond = math.nextafter(1.0, 2.0)
    assert square_hit((beyond, 0.0, 2.0), (0.0, 0.0, -1.0), 0.0, 9.0, 0)[1] == NO_FACE
    assert square_hit((-3.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.0, 9.0, 0)[1] == NO_FACE
    assert square_hit((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.0, 9.0, 0) == (0.0, 0)
    assert square_hit((0.0, 0.0, -1.0), (0.0, 0.0, -1.0), 0.0, 9.0, 0)[1] == NO_FACE


@pytest.mark.parametrize(("cull", "from_front", "from_back"), [(0, 0, 0), (BACK, 0, -1), (FRONT, -1, 0)])
def test_square_shows_its_front_toward_plus_z(cull, from_front, from_back):
    assert square_hit((0.0, 0.0, 2.0), (0.0, 0.0, -1.0), 0.0, 9.0, cull)[1] == from_front
    assert square_hit((0.0, 0.0, -2.0), (0.0, 0.0, 1.0), 0.0, 9.0, cull)[1] == from_back


def test_cylinder_side_base_and_cap():
    assert cylinder_span((3.0, 0.0, 0.5), (-1.0, 0.0, 0.0)) == Span(2.0, SIDE, 4.0, SIDE)
    assert cylinder_span((0.0, 0.0, 3.0), (0.0, 0.0, -1.0)) == Span(2.0, CAP, 3.0, BASE)
    assert cylinder_span((0.5, 0.5, -1.0), (0.0, 0.0, 0.5)) == Span(2.0, BASE, 4.0, CAP)
    slanted = cylinder_span((0.0, 0.0, 2.0), (0.5, 0.0, -1.0))
    assert slanted == Span(1.0, CAP, 2.0, SIDE)


def test_the_side_owns_the_rim_of_the_cylinder():
    through_rim = cylinder_span((2.0, 0.0, 2.0), (-1.0, 0.0, -1.0))
    assert (through_rim.t_in, through_rim.face_in) == (1.0, SIDE)


def test_lines_parallel_to_the_axis_within_the_side_and_edge_on_to_the_cap():
    assert cylinder_span((1.0, 0.0, 3.0), (0.0, 0.0, -1.0)) == Span(2.0, CAP, 3.0, BASE)
    assert cylinder_span((math.nextafter(1.0, 2.0), 0.0, 3.0), (0.0, 0.0, -1.0)).face_in == NO_FACE
    assert cylinder_span((3.0, 0.0, 1.0), (-1.0, 0.0, 0.0)) == Span(2.0, SIDE, 4.0, SIDE)
    beyond = cylinder_span((3.0, 0.0, math.nextafter(1.0, 2.0)), (-1.0, 0.0, 0.0))
    assert beyond.t_in > beyond.t_out


@pytest.mark.parametrize("k", [4, 20, 40, 60, 100, 200])
def test_a_line_ever_so_little_off_the_axis_still_meets_base_and_cap(k):
    span = cylinder_span((0.25, 0.0, 3.0), (2.0**-k, 0.0, -1.0))
    assert (span.t_in, span.face_in, span.t_out, span.face_out) == (2.0, CAP, 3.0, BASE)


SPAN = Span(2.0, 7, 5.0, 8)


@pytest.mark.parametrize(
    ("near", "far", "cull", "expected"),
    [
        (0.0, 9.0, 0, (2.0, 7)),
        (2.0, 9.0, 0, (2.0, 7)),
        (math.nextafter(2.0, 3.0), 9.0, 0, (5.0, 8)),
        (5.0, 5.0, 0, (5.0, 8)),
        (0.0, 2.0, 0, (2.0, 7)),
        (0.0, 1.0, 0, (math.inf, NO_FACE)),
        (3.0, 4.0, 0, (math.inf, NO_FACE)),
        (0.0, 9.0, BACK, (2.0, 7)),
        (3.0, 9.0, BACK, (math.inf, NO_FACE)),
        (0.0, 9.0, FRONT, (5.0, 8)),
        (0.0, 4.0, FRONT, (math.inf, NO_FACE)),
    ],
)
def test_the_nearest_hit_that_counts(near, far, cull, expected):
    assert first_hit(SPAN, near, far, cull) == expected
