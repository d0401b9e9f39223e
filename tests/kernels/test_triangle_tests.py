"""The literature's tests of a ray with a triangle."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from hsr.kernels.triangle_tests import EDGE_PLANES, MISS, MOLLER_TRUMBORE, WOOP, misses, triangle_at

TESTS = {"moller-trumbore": MOLLER_TRUMBORE, "edge-planes": EDGE_PLANES, "woop": WOOP}
REALS = [np.float64, np.float32]

pytestmark = [pytest.mark.parametrize("test", TESTS.values(), ids=TESTS)]


def at(test, o, d, corners, real=np.float64):
    o, d, *corners = (tuple(np.array(p, real)) for p in (o, d, *corners))
    return triangle_at(test, o, d, *corners)


A, B, C = (0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (0.0, 4.0, 0.0)
DOWN = (0.0, 0.0, -1.0)


@pytest.mark.parametrize("real", REALS)
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("toward", [1.0, -1.0])
def test_t_and_the_side_that_is_hit_along_every_axis(test, axis, toward, real):
    o, d = np.roll([1.0, 1.0, 3.0 * toward], axis + 1), np.roll([0.0, 0.0, -2.0 * toward], axis + 1)
    corners = [np.roll(p, axis + 1) for p in (A, B, C)]
    t, facing = at(test, o, d, corners, real)
    assert t == 1.5
    assert (facing > 0.0) == (toward > 0.0)
    t, facing = at(test, o, d, corners[::-1], real)
    assert t == 1.5
    assert (facing > 0.0) == (toward < 0.0)


@pytest.mark.parametrize("real", REALS)
@pytest.mark.parametrize("place", [(2.0, 0.0), (0.0, 1.0), (2.0, 2.0), (0.0, 0.0), (4.0, 0.0), (0.0, 4.0)])
def test_edges_and_corners_belong_to_the_triangle(test, place, real):
    assert at(test, (*place, 1.0), DOWN, (A, B, C), real)[0] == 1.0


def test_just_outside_is_missed(test):
    assert at(test, (2.0, -(2.0**-40), 1.0), DOWN, (A, B, C))[0] == MISS
    assert at(test, (-(2.0**-40), 2.0, 1.0), DOWN, (A, B, C))[0] == MISS
    assert at(test, (2.0, 2.0 + 2.0**-40, 1.0), DOWN, (A, B, C))[0] == MISS


def test_a_triangle_behind_the_origin_is_at_a_negative_t(test):
    assert at(test, (1.0, 1.0, -2.0), DOWN, (A, B, C))[0] == -2.0
    assert at(test, (1.0, 1.0, 0.0), DOWN, (A, B, C))[0] == 0.0


def test_a_triangle_seen_edge_on_or_without_area_is_missed(test):
    assert at(test, (-1.0, 1.0, 0.0), (1.0, 0.0, 0.0), (A, B, C))[0] == MISS
    assert at(test, (1.0, 0.0, 1.0), DOWN, (A, B, B))[0] == MISS


def exact(o, d, a, b, c):
    """Return the exact weights u, v, w of a, b and c, their sum, and t, in rational arithmetic."""
    o, d, a, b, c = ([Fraction(float(x)) for x in p] for p in (o, d, a, b, c))
    a, b, c = ([x - y for x, y in zip(p, o, strict=True)] for p in (a, b, c))

    def volume(p, q, r):
        return sum(r[k] * (p[k - 2] * q[k - 1] - p[k - 1] * q[k - 2]) for k in range(3))

    weights = volume(c, b, d), volume(a, c, d), volume(b, a, d)
    return weights, sum(weights), volume(c, b, a)


@pytest.mark.parametrize("real", REALS)
def test_clear_cases_are_those_of_exact_arithmetic(test, real):
    random, seen = np.random.default_rng(1), set()
    for _ in range(300):
        o, d, *corners = random.normal(size=(5, 3)).astype(real)
        weights, total, depth = exact(o, d, *corners)
        if min(abs(weight) for weight in weights) < 1e-4 or abs(total) < 1e-2:
            continue
        t, facing = at(test, o, d, corners, real)
        hit = min(weights) > 0 or max(weights) < 0
        assert (t < MISS) == hit
        seen.add(hit)
        if hit:
            assert t == pytest.approx(float(depth / total), rel=2e4 * float(np.finfo(real).eps))
            assert (facing > 0.0) == (total > 0)
    assert seen == {True, False}


def test_float32_is_computed_in_float32(test):
    t, _ = at(test, (1.0, 1.0, 1.0), (0.0, 0.0, -3.0), (A, B, C), np.float32)
    assert t == float(np.float32(1.0) / np.float32(3.0)) != 1.0 / 3.0


def test_misses_are_counted(test):
    origins = np.array([[1.0, 1.0, 1.0], [5.0, 5.0, 1.0], [1.0, 1.0, -1.0]])
    directions = np.array([DOWN] * 3)
    assert misses(test, origins, directions, np.array([[A, B, C]])) == 2
    assert misses(test, origins, directions, np.array([[C, B, (9.0, 9.0, 0.0)], [A, B, C]])) == 1
