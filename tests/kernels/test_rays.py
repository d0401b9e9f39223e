"""Coverage of one triangle, and which of two hits counts."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest

from hsr.kernels.culling import CULL_BACK, CULL_FRONT
from hsr.kernels.rays import NO_OWNER, Best, answer_of, better
from hsr.kernels.triangle_on_screen import covered_nearness, facet_of

FAR_AWAY = -math.inf


def seen(x, y, depth, perspective=True):
    """Return the corner that appears at (x, y), rows running down, at a depth."""
    if perspective:
        return (x * depth, y * depth, depth, 1.0 / depth if depth > 0.0 else math.inf)
    return (x, y, depth, -depth)


def nearness(corners, x, y, perspective=True, cull=0, mirrored=False, closest=math.inf):
    facet = facet_of(*corners, perspective, cull, mirrored)
    if facet.turn == 0.0:
        return FAR_AWAY
    return covered_nearness(facet, x, y, closest)


def covered(corners, size=5, **kind):
    """Return the map of covered samples, sample (0, 0) in the upper left."""
    grid = range(size)
    return [[int(nearness(corners, float(x), float(y), **kind) > FAR_AWAY) for x in grid] for y in grid]


def at_depth(points, depth=1.0, perspective=True):
    return [seen(float(x), float(y), depth, perspective) for x, y in points]


@pytest.mark.parametrize("perspective", [True, False])
@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
def test_samples_on_left_and_top_edges_are_covered_those_on_right_and_bottom_edges_not(order, perspective):
    points = [(0, 0), (4, 0), (0, 4)]
    corners = at_depth([points[k] for k in order], perspective=perspective)
    assert covered(corners, perspective=perspective) == [
        [1, 1, 1, 1, 0],
        [1, 1, 1, 0, 0],
        [1, 1, 0, 0, 0],
        [1, 0, 0, 0, 0],
        [0, 0, 0, 0, 0],
    ]


def test_two_triangles_of_a_square_own_its_samples_once():
    square = at_depth([(0, 0), (4, 0), (4, 4), (0, 4)])
    for a, b, c, d in (range(4), (1, 2, 3, 0)):
        one = np.array(covered([square[a], square[b], square[c]]))
        two = np.array(covered([square[a], square[c], square[d]]))
        assert (one + two)[:4, :4].tolist() == [[1] * 4] * 4
        assert (one + two)[4].sum() == (one + two)[:, 4].sum() == 0


def test_a_fan_owns_the_sample_at_its_hub_once():
    random = np.random.default_rng(4)
    for _ in range(50):
        angles = np.sort(random.uniform(0.0, 2.0 * np.pi, 9))
        angles[:3] = [0.0, np.pi / 2, np.pi]
        angles = np.sort(angles)
        rim = [(3.0 + 2.0 * math.cos(a), 3.0 + 2.0 * math.sin(a)) for a in angles]
        fan = zip(rim, [*rim[1:], rim[0]], strict=True)
        owners = sum(nearness(at_depth([(3.0, 3.0), p, q]), 3.0, 3.0) > FAR_AWAY for p, q in fan)
        assert owners == 1


def test_coverage_of_random_triangles_is_that_of_exact_arithmetic():
    random = np.random.default_rng(5)
    for _ in range(300):
        points = random.integers(-64, 64, (3, 2)) / 8.0
        depths = 2.0 ** random.integers(-2, 3, 3)
        corners = [seen(x, y, d) for (x, y), d in zip(points, depths, strict=True)]
        for x, y in random.integers(-64, 64, (20, 2)) / 8.0:
            assert (nearness(corners, x, y) > FAR_AWAY) == exactly_inside(points, x, y)


def exactly_inside(points, x, y):
    """Decide coverage of (x + e, y + d), d smaller than every power of e, in rational arithmetic."""
    p = [
        (Fraction(float(a)) - Fraction(float(x)), Fraction(float(b)) - Fraction(float(y))) for a, b in points
    ]
    sides = []
    for (ax, ay), (bx, by) in itertools.pairwise([*p, p[0]]):
        growth = (ax * by - ay * bx, ay - by, bx - ax)
        sides.append(next((1 if term > 0 else -1 for term in growth if term), 0))
    return abs(sum(sides)) == 3


def test_a_corner_behind_the_eye_is_no_corner_on_the_screen():
    """The triangle runs from two corners in front to one behind: it never ends on the screen."""
    corners = [seen(0.0, 0.0, 1.0), seen(4.0, 0.0, 1.0), (1.0, 8.0, -1.0, math.inf)]
    assert nearness(corners, 2.0, 1.0) == pytest.approx(1.25)
    assert nearness(corners, 20.0, 50.0) == pytest.approx(13.5)
    assert nearness(corners, 20.0, 50.0, closest=10.0) == FAR_AWAY
    assert nearness(corners, 2.0, -1.0) == FAR_AWAY
    assert nearness(corners, -1.0, -8.0) == FAR_AWAY


def test_corners_on_the_eye_plane_and_triangles_behind_the_eye():
    on_plane = [seen(0.0, 0.0, 1.0), seen(4.0, 0.0, 1.0), (0.0, 1.0, 0.0, math.inf)]
    assert nearness(on_plane, 1.0, 1.0) == pytest.approx(2.0)
    assert nearness(on_plane, 1.0, 1000.0) == pytest.approx(1001.0)
    assert nearness(on_plane, 5.0, 1000.0) == FAR_AWAY
    behind = [seen(0.0, 0.0, -1.0), seen(4.0, 0.0, -1.0), seen(0.0, 4.0, -2.0)]
    assert nearness(behind, 1.0, 1.0, closest=1e300) == FAR_AWAY


def test_triangles_seen_edge_on_or_without_area_cover_nothing():
    assert facet_of(*at_depth([(0, 0), (2, 2), (4, 4)]), True, 0, False).turn == 0.0
    assert facet_of(*at_depth([(1, 1), (1, 1), (3, 0)]), True, 0, False).turn == 0.0
    through_eye = [(0.0, 0.0, 1.0, 1.0), (0.0, 0.0, 2.0, 0.5), (1.0, 1.0, 3.0, 1 / 3)]
    assert facet_of(*through_eye, True, 0, False).turn == 0.0


COUNTER_CLOCKWISE = [(0, 4), (4, 4), (0, 0)]


@pytest.mark.parametrize("perspective", [True, False])
@pytest.mark.parametrize("mirrored", [True, False])
def test_culling_goes_by_the_winding_on_the_screen(mirrored, perspective):
    front = at_depth(COUNTER_CLOCKWISE, perspective=perspective)
    back = front[::-1]
    if mirrored:
        front, back = back, front
    kind = {"perspective": perspective, "mirrored": mirrored}
    assert nearness(front, 1.0, 2.0, cull=CULL_BACK, **kind) > FAR_AWAY
    assert nearness(back, 1.0, 2.0, cull=CULL_BACK, **kind) == FAR_AWAY
    assert nearness(front, 1.0, 2.0, cull=CULL_FRONT, **kind) == FAR_AWAY
    assert nearness(back, 1.0, 2.0, cull=CULL_FRONT, **kind) > FAR_AWAY


def test_nearness_is_that_of_the_plane():
    perspective = [seen(0.0, 0.0, 1.0), seen(8.0, 0.0, 2.0), seen(0.0, 8.0, 4.0)]
    assert nearness(perspective, 2.0, 2.0) == pytest.approx(0.5 * 1.0 + 0.25 * 0.5 + 0.25 * 0.25, rel=1e-15)
    parallel = [seen(0.0, 0.0, 1.0, False), seen(8.0, 0.0, 2.0, False), seen(0.0, 8.0, -4.0, False)]
    assert nearness(parallel, 2.0, 2.0, False) == -(0.5 * 1.0 + 0.25 * 2.0 - 0.25 * 4.0)


def test_a_triangle_parallel_to_the_image_has_exactly_its_depth_and_near_is_closed():
    for depth in (3.0, 7.0, 0.1):
        corners = at_depth([(0, 0), (301, 7), (11, 295)], depth)
        assert nearness(corners, 100.0, 100.0, closest=1.0 / depth) == 1.0 / depth
        beyond = math.nextafter(1.0 / depth, 0.0)
        assert nearness(corners, 100.0, 100.0, closest=beyond) == FAR_AWAY


def test_the_nearer_hit_counts_then_the_lower_face():
    assert better((2.0, 9), Best(1.0, 3)) == Best(2.0, 9)
    assert better((1.0, 2), Best(1.0, 3)) == Best(1.0, 2)
    assert better((1.0, 4), Best(1.0, 3)) == Best(1.0, 3)
    assert better((-math.inf, -1), Best(0.0, NO_OWNER)) == Best(0.0, NO_OWNER)
    assert better((0.25, 5), Best(0.25, NO_OWNER)) == Best(0.25, 5)


def test_answers():
    assert answer_of(Best(0.25, 7), True) == (7, 4.0)
    assert answer_of(Best(-4.0, 7), False) == (7, 4.0)
    assert answer_of(Best(0.25, NO_OWNER), True) == (-1, math.inf)
