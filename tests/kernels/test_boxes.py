"""Extents must hold what is in them, touched edges and corners included."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hsr.kernels.boxes import Beam, box_entry, naive_entry, reciprocal
from hsr.kernels.hierarchy import NODE
from hsr.kernels.projection import nearness_of


def box(low, high):
    node = np.zeros(1, NODE)
    node["low"], node["high"] = low, high
    return node[0]


def enter(cube, o, d, near=0.0, far=math.inf, margin=0.0):
    inverse = tuple(reciprocal(float(x)) for x in d)
    return box_entry(cube, Beam(tuple(map(float, o)), inverse, (margin,) * 3, near, far))


CUBE = box([-1.0] * 3, [1.0] * 3)


def test_entry_of_a_ray():
    assert enter(CUBE, (0, 0, 4), (0, 0, -2)) == 1.5
    assert enter(CUBE, (0, 0, 0), (0, 0, -1), near=0.25) == 0.25
    assert enter(CUBE, (0, 0, 4), (0, 0, 1)) == math.inf
    assert enter(CUBE, (0, 0, 4), (0, 0, -1), far=2.0) == math.inf
    assert enter(CUBE, (0, 0, 4), (0, 0, -1), near=6.0) == math.inf


@pytest.mark.parametrize("zero", [0.0, -0.0, 5e-324])
@pytest.mark.parametrize("edge", [(1.0, 1.0), (1.0, -1.0), (-1.0, 0.5), (0.0, 1.0)])
def test_rays_within_a_face_or_along_an_edge_meet_the_closed_box(zero, edge):
    assert enter(CUBE, (*edge, 4), (zero, zero, -1)) == 3.0
    beyond = (math.nextafter(1.0, 2.0), edge[1])
    assert enter(CUBE, (*beyond, 4), (zero, zero, -1)) == math.inf


def test_flat_boxes():
    flat = box([-1.0, -1.0, 0.0], [1.0, 1.0, 0.0])
    assert enter(flat, (0, 0, 2), (0, 0, -1)) == 2.0
    assert enter(flat, (-3, 0, 0), (1, 0, 0)) == 2.0


def test_no_ray_that_exactly_grazes_a_corner_is_lost():
    random = np.random.default_rng(2)
    for _ in range(4000):
        high = random.integers(1, 2**20, 3).astype(float)
        corner = random.choice([-1, 1], 3) * high
        d = random.integers(-(2**10), 2**10, 3).astype(float)
        k = float(random.integers(1, 2**10))
        assert enter(box(-high, high), corner - k * d, d, far=2.0**30) < math.inf


def grazing(entry):
    """Return the share of rays that exactly graze a corner of a box and are lost."""
    random = np.random.default_rng(2)
    lost = 0
    for _ in range(4000):
        high = random.integers(1, 2**20, 3).astype(float)
        corner = random.choice([-1, 1], 3) * high
        d = random.integers(1, 2**10, 3).astype(float) * random.choice([-1, 1], 3)
        o = corner - float(random.integers(1, 2**10)) * d
        beam = Beam(tuple(o.tolist()), tuple((1.0 / d).tolist()), (0.0,) * 3, 0.0, 2.0**30)
        lost += entry(box(-high, high), beam) == math.inf
    return lost / 4000


def test_without_padding_rays_that_graze_a_box_are_lost():
    assert grazing(box_entry) == 0.0
    assert 0.05 < grazing(naive_entry) < 0.15


@pytest.mark.jit
def test_without_care_the_sign_of_zero_decides_whether_a_ray_within_a_face_meets_the_box():
    def naive(x, zero):
        inverse = tuple(reciprocal(c) for c in (zero, 0.0, -1.0))
        return naive_entry(CUBE, Beam((x, 0.0, 4.0), inverse, (0.0,) * 3, 0.0, math.inf))

    assert naive(-1.0, 0.0) == naive(1.0, 0.0) == 3.0
    assert naive(-1.0, -0.0) == math.inf
    assert enter(CUBE, (-1, 0, 4), (-0.0, 0, -1)) == 3.0


def test_naive_slabs_are_right_where_rounding_decides_nothing():
    random = np.random.default_rng(6)
    for _ in range(500):
        o, d = random.normal(size=(2, 3)) * 2.0
        inverse = tuple((1.0 / d).tolist())
        beam = Beam(tuple(o.tolist()), inverse, (0.0,) * 3, 0.0, math.inf)
        assert naive_entry(CUBE, beam) == box_entry(CUBE, beam)


@pytest.mark.parametrize("inward", [0.0, 1.0, -1.0])
def test_a_ray_from_a_face_of_the_box_meets_it_there(inward):
    assert enter(CUBE, (1, 0.5, 0), (-inward, 0.25, 1)) == 0.0
    assert enter(CUBE, (1, 1, 1), (-inward, 0, 0.0 if inward else 1.0)) == 0.0


def test_a_beam_is_as_thick_as_its_margin():
    assert enter(CUBE, (1.25, 0, 4), (0, 0, -1), margin=0.25) == 2.75
    assert enter(CUBE, (1.3, 0, 4), (0, 0, -1), margin=0.25) == math.inf


def test_nearness_grows_as_depth_shrinks():
    assert [nearness_of(d, True) for d in (4.0, 0.5, 0.0, -1.0)] == [0.25, 2.0, math.inf, math.inf]
    assert nearness_of(-3.0, False) == 3.0
