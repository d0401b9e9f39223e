"""Hits of the generic shapes, against exact arithmetic on rational lines."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hsr.kernels.culling import CULL_BACK, CULL_FRONT
from hsr.kernels.hits import (
    BASE,
    CAP,
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


@pytest.mark.parametrize(
    ("cull", "from_front", "from_back"), [(0, 0, 0), (CULL_BACK, 0, -1), (CULL_FRONT, -1, 0)]
)
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
        (0.0, 9.0, CULL_BACK, (2.0, 7)),
        (3.0, 9.0, CULL_BACK, (math.inf, NO_FACE)),
        (0.0, 9.0, CULL_FRONT, (5.0, 8)),
        (0.0, 4.0, CULL_FRONT, (math.inf, NO_FACE)),
    ],
)
def test_the_nearest_hit_that_counts(near, far, cull, expected):
    assert first_hit(SPAN, near, far, cull) == expected


# ---------------------------------------------------------------- hard cases


def pyramid(sides):
    """Planes of a pyramid with its apex at (0, 0, 1) and its base at z = 0."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    flanks = np.column_stack([np.cos(angle), np.sin(angle), np.ones(sides), np.ones(sides)])
    return np.vstack([flanks, [0.0, 0.0, -1.0, 0.0]])


def exact_span(planes, o, d):
    """Return the exact entry and exit of a line, and all faces through which it enters."""
    t_in, t_out, faces = Fraction(-(10**9)), Fraction(10**9), set()
    for k, (*n, m) in enumerate(planes.tolist()):
        along = sum(Fraction(x) * Fraction(y) for x, y in zip(n, d, strict=True))
        inside = Fraction(m) - sum(Fraction(x) * Fraction(y) for x, y in zip(n, o, strict=True))
        if along == 0:
            if inside < 0:
                return None
            continue
        t = inside / along
        if along > 0:
            t_out = min(t_out, t)
        elif t > t_in:
            t_in, faces = t, {k}
        elif t == t_in:
            faces.add(k)
    return (t_in, t_out, faces) if t_in <= t_out else None


@pytest.mark.parametrize("sides", [4, 100, 1000])
def test_a_line_through_the_apex_of_many_half_spaces_enters_by_the_lowest_of_them(sides):
    planes = pyramid(sides)
    for slope in (0.0, 0.25, -0.125):
        span = polyhedron_span((-2.0 * slope, 0.0, 3.0), (slope, 0.0, -1.0), planes, 0, sides + 1)
        exact = exact_span(planes, (-2.0 * slope, 0.0, 3.0), (slope, 0.0, -1.0))
        assert exact is not None and span.face_in in exact[2]
        assert span.t_in == pytest.approx(2.0, rel=2.0**-50)
        assert span.t_out == 3.0 and span.face_out == sides
    straight = polyhedron_span((0.0, 0.0, 3.0), (0.0, 0.0, -1.0), planes, 0, sides + 1)
    assert (straight.t_in, straight.face_in) == (2.0, 0)


def test_near_the_apex_the_face_is_that_of_exact_arithmetic_but_for_rounding():
    planes, random = pyramid(100), np.random.default_rng(3)
    for _ in range(200):
        o = (*(random.normal(size=2) * 2.0**-20).tolist(), 3.0)
        span = polyhedron_span(o, (0.0, 0.0, -1.0), planes, 0, 101)
        exact = exact_span(planes, o, (0.0, 0.0, -1.0))
        assert exact is not None
        assert abs(span.t_in - exact[0]) < 2.0**-50
        along = exact_span(planes[[span.face_in, 100]], o, (0.0, 0.0, -1.0))
        assert along is not None and abs(along[0] - exact[0]) < 2.0**-50


@pytest.mark.parametrize(("x", "inside"), [(1.0, True), (0.5, True), (math.nextafter(1.0, 2.0), False)])
def test_a_line_parallel_to_a_face_is_inside_on_it_and_outside_beyond_it(x, inside):
    span = cube_span((x, 3.0, 0.25), (0.0, -1.0, 0.0))
    assert (span.t_in <= span.t_out) == inside


def test_an_origin_on_a_face_or_inside_is_within_its_span():
    on_face = cube_span((1.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    assert on_face == Span(-2.0, LEFT, 0.0, RIGHT)
    assert first_hit(on_face, 0.0, 9.0, 0) == (0.0, RIGHT)
    assert first_hit(cube_span((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)), 0.0, 9.0, 0) == (0.0, RIGHT)
    assert first_hit(cube_span((0.5, 0.0, 0.0), (1.0, 0.0, 0.0)), 0.0, 9.0, 0) == (0.5, RIGHT)
    assert first_hit(cylinder_span((0.0, 0.0, 1.0), (0.0, 0.0, -1.0)), 0.0, 9.0, 0) == (0.0, CAP)
    assert first_hit(cylinder_span((1.0, 0.0, 0.5), (1.0, 0.0, 0.0)), 0.0, 9.0, 0) == (0.0, SIDE)


def test_a_line_along_a_line_of_the_cylinders_side_meets_base_and_cap():
    assert cylinder_span((0.0, 1.0, -1.0), (0.0, 0.0, 1.0)) == Span(1.0, BASE, 2.0, CAP)
    tangent = cylinder_span((1.0, -2.0, 0.5), (0.0, 1.0, 0.0))
    assert (tangent.face_in, tangent.face_out) == (SIDE, SIDE)
    assert 2.0 == tangent.t_in <= tangent.t_out <= 2.0 + 2.0**-51


def exact_ball(transform, o, d):
    """Return by how much, relative, the line misses the unit ball carried by an integer transform."""
    m = [[Fraction(x) for x in row] for row in transform]
    det = sum(m[0][i] * (m[1][i - 2] * m[2][i - 1] - m[1][i - 1] * m[2][i - 2]) for i in range(3))
    adjugate = [
        [m[j - 2][i - 2] * m[j - 1][i - 1] - m[j - 2][i - 1] * m[j - 1][i - 2] for j in range(3)]
        for i in range(3)
    ]
    p, q = ([sum(x * Fraction(c) for x, c in zip(row, v, strict=True)) for row in adjugate] for v in (o, d))
    a, b, c = (sum(x * y for x, y in zip(u, v, strict=True)) for u, v in ((q, q), (p, q), (p, p)))
    # |p x q|^2 against |q|^2, both in units of the determinant.
    return float((a * c - b * b) / (a * det * det) - 1)


@pytest.mark.parametrize("exponent", [10, 20, 30])
def test_ill_conditioned_ellipsoids_are_wrong_only_in_a_thin_band(exponent):
    """Rounding a ray into the frame moves it by about 2 u times the condition number."""
    turn = np.array([[3.0, 4.0, 0.0], [-4.0, 3.0, 0.0], [0.0, 0.0, 5.0]])
    transform = turn @ np.diag([1.0, 2.0**-exponent, 1.0])
    inverse, random = np.linalg.inv(transform), np.random.default_rng(exponent)
    for _ in range(300):
        o = np.array([0.0, 0.0, 25.0])
        d = transform @ random.normal(size=3) - o
        hit = sphere_span(tuple((inverse @ o).tolist()), tuple((inverse @ d).tolist())).face_in != NO_FACE
        gap = exact_ball(transform.tolist(), o.tolist(), d.tolist())
        assert hit == (gap <= 0.0) or abs(gap) < 2.0**-48 * 2.0**exponent


def float32s(vector):
    return tuple(np.array(vector, np.float32))


@pytest.mark.parametrize("distance", [100.0, 1000.0, 10000.0])
def test_in_float32_a_distant_sphere_is_wrong_in_a_band_of_its_rounding(distance):
    """Beyond 4096 radii the textbook's discriminant loses the sphere altogether in this arithmetic."""
    random, hits = np.random.default_rng(7), 0
    for offset in random.uniform(0.0, 1.2, 200):
        angle = random.uniform(0.0, 2.0 * np.pi)
        o = float32s((0.0, 0.0, distance))
        d = float32s((offset * math.cos(angle), offset * math.sin(angle), -distance))
        hit = sphere_span(o, d).face_in != NO_FACE
        x, y, z = (Fraction(float(c)) for c in d)
        exact = (x * x + y * y) * Fraction(distance) ** 2 <= x * x + y * y + z * z
        assert hit == exact or abs(offset - 1.0) < 2.0**-22 * distance
        hits += hit
    assert 120 < hits < 200


def test_float32_lines_are_hit_in_float32():
    third = np.float32(1.0) / np.float32(3.0)
    t, _ = square_hit(float32s((0.0, 0.0, 1.0)), float32s((0.0, 0.0, -3.0)), 0.0, 9.0, 0)
    assert t == float(third) != 1.0 / 3.0
    span = cylinder_span(float32s((0.0, 0.0, 2.0)), float32s((0.0, 0.0, -3.0)))
    assert (span.t_in, span.t_out) == (float(third), float(np.float32(2.0) / np.float32(3.0)))
    planes = CUBE.astype(np.float32)
    cut = polyhedron_span(float32s((0.0, 0.0, 2.0)), float32s((0.0, 0.0, -3.0)), planes, 0, 6)
    assert (cut.t_in, cut.t_out) == (float(third), 1.0)
    ball = sphere_span(float32s((0.0, 0.0, 2.0)), float32s((0.0, 0.0, -3.0)))
    assert ball.t_in == float(np.float32(ball.t_in)) == pytest.approx(1.0 / 3.0, rel=1e-6)
