"""Keys, and what is written down instead of decided."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hsr.kernels.zbuffer import fill as d
from hsr.kernels.zbuffer import setup

DEPTHS = st.floats(1.0, 2.0, exclude_max=True)


@settings(deadline=None)  # the first example compiles
@given(a=DEPTHS, b=DEPTHS, triangles=st.integers(1, 2**31 - 1))
def test_keys_order_like_depths_and_give_them_back(a: float, b: float, triangles: int) -> None:
    mask = int(d.depth_mask(triangles))
    step, number = (int(d.EMPTY) - mask + 1) * 2.0**-63, triangles - 1
    one, other = (int(d.key_of(np.float64(z), mask, number)) for z in (a, b))
    if a + step < b:
        assert one < other
    assert a - step < d.depth_of(one & mask) <= a
    assert one & ~mask == number and one != d.EMPTY


def one_triangle(**parts: float) -> np.ndarray:
    """A table whose first triangle has x < 2 and y < 3 inside, on an image of 5 x 4, at z = 1.5."""
    table = np.zeros(setup.TABLE)
    plain = {"E0": 1.5, "ACROSS0": -1.0, "E1": 2.5, "BELOW1": -1.0, "E2": 9.0, "RIGHT": 5.0, "BOTTOM": 4.0}
    for name, value in {**plain, "Z": 1.5, "BOUND": 1e-9, "AREA": 9.0, "NUMBER": 3.0, **parts}.items():
        table[getattr(setup, name)] = value
    return table


MASK = int(d.depth_mask(8))
GAP = int(d.gap_of(MASK, 2.0**-40))
CELLS = np.full((1, 1), np.inf), np.zeros((1, 1), np.bool_), np.zeros((1, 1), np.bool_)


def empty() -> d.Tile:
    return d.Tile(0, 0, 4, 5, 5, MASK, GAP, np.full((4, 5 + setup.LANES), d.EMPTY, np.int64), *CELLS)


def shown(tile: d.Tile) -> list[list[int]]:
    return np.where(tile.keys == d.EMPTY, -1, tile.keys & ~MASK)[:, :5].tolist()


def test_a_triangle_fills_what_is_certainly_inside() -> None:
    tile = empty()
    assert not d.fill(one_triangle(), 0, tile, None, True)
    assert shown(tile) == [[3, 3, -1, -1, -1]] * 3 + [[-1] * 5]


@pytest.mark.parametrize("e", [1.0, 1.0 + 1e-12, 1.0 - 1e-12])
def test_a_sample_within_the_bound_of_an_edge_is_a_doubt(e: float) -> None:
    table, tile, found, counts = one_triangle(E0=e), empty(), np.zeros(8, d.DOUBT), np.zeros(4, np.int64)
    assert d.fill(table, 0, tile, None, True)
    assert shown(tile) == [[3, -1, -1, -1, -1]] * 3 + [[-1] * 5]
    d.note(table, 0, tile, None, found, counts)
    assert counts[d.USED] == 3 and found["sample"][:3].tolist() == [1, 6, 11] and not found["sure"].any()


def test_depths_within_their_errors_are_doubts_about_both() -> None:
    tile, found, counts = empty(), np.zeros(99, d.DOUBT), np.zeros(4, np.int64)
    d.fill(one_triangle(), 0, tile, None, True)
    near_by = one_triangle(NUMBER=5.0, Z=1.5 - 2.0**-41)
    assert d.fill(near_by, 0, tile, None, True)
    assert shown(tile)[0] == [3, 3, -1, -1, -1]
    d.note(near_by, 0, tile, None, found, counts)
    d.settle(tile, found, counts)
    assert counts[d.USED] == 12 and found["sure"][:12].all()
    assert set((found["key"][:12] & ~MASK).tolist()) == {3, 5}


def test_a_depth_at_near_or_far_is_a_doubt() -> None:
    limits = d.limits_of(one_triangle(), 0, eye(near=1.5, far=1.9))
    tile, found, counts = empty(), np.zeros(99, d.DOUBT), np.zeros(4, np.int64)
    assert d.fill(one_triangle(), 0, tile, limits, True)
    assert shown(tile) == [[-1] * 5] * 4
    d.note(one_triangle(), 0, tile, limits, found, counts)
    assert counts[d.USED] == 6


def eye(near: float, far: float) -> setup.Eye:
    return setup.Eye(True, 5.0, 4.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, near, far, 2.0**-40)


def test_doubts_about_what_is_certainly_hidden_are_forgotten() -> None:
    tile, found, counts = empty(), np.zeros(99, d.DOUBT), np.zeros(4, np.int64)
    table = one_triangle(E0=1.0)
    d.fill(table, 0, tile, None, True)
    d.note(table, 0, tile, None, found, counts)
    d.fill(one_triangle(NUMBER=7.0, Z=1.25, E0=9.0, E1=1.5), 0, tile, None, True)
    d.settle(tile, found, counts)
    # The nearer one covers the first two lines. In the third nothing else is there.
    assert counts[d.USED] == 1 and found["sample"][0] == 11


def test_what_the_keys_show_is_a_candidate_of_a_doubtful_sample() -> None:
    tile, found, counts = empty(), np.zeros(99, d.DOUBT), np.zeros(4, np.int64)
    d.fill(one_triangle(NUMBER=7.0, Z=1.75, E0=9.0), 0, tile, None, True)
    table = one_triangle(E0=1.0)
    d.fill(table, 0, tile, None, True)
    d.note(table, 0, tile, None, found, counts)
    d.settle(tile, found, counts)
    assert counts[d.USED] == 6 and (found["key"][3:6] & ~MASK).tolist() == [7, 7, 7]
    assert found["sure"][:6].tolist() == [False] * 3 + [True] * 3


def test_a_lack_of_room_is_counted() -> None:
    table, tile, found, counts = (
        one_triangle(E0=1.0),
        empty(),
        np.zeros(1, d.DOUBT),
        np.zeros(4, np.int64),
    )
    d.note(table, 0, tile, None, found, counts)
    assert counts[d.USED] == 3 and found["sample"].tolist() == [1]


def test_spans_leave_out_only_what_is_outside() -> None:
    random = np.random.default_rng(5)
    for _ in range(300):
        row = tuple(random.normal(0.0, 1.0, 8) * 10.0 ** random.integers(-3, 4, 8))
        first, last = d.span_of(row, 0.0, 0, 0, 100)
        inside = [c for c in range(100) if d.at(row, float(c), None)[0] >= 0.0]
        assert all(first <= c < last for c in inside)
        assert 0 <= first <= last <= 100


@pytest.mark.parametrize("triangles", [8, 2**20])
def test_what_keys_cannot_tell_from_infinity_is_shown_as_the_farthest(triangles: int) -> None:
    mask = int(d.depth_mask(triangles))
    keys = np.full((4, 5 + setup.LANES), d.key_of(np.float64(setup.FARTHEST), mask, 3), np.int64)
    seen = eye(near=1.0, far=1.9)._replace(farthest=1e-20, scale=0.75)
    faces, face, depth = np.arange(8, dtype=np.int32), np.zeros((4, 5), np.int32), np.zeros((4, 5))
    tile = empty()._replace(mask=mask, keys=keys)
    d.read_out(tile, (0, 4, 0, 5), (faces, face, depth), seen)
    assert (face == 3).all() and (depth == 1e20).all()


@pytest.mark.parametrize("triangles", [1, 2**20, 2**31 - 2])
def test_the_gap_of_depths_covers_what_keys_cut_off(triangles: int) -> None:
    """However many bits tell the triangles apart."""
    mask, tie = d.depth_mask(triangles), 2.0**-36
    gap = d.depth_gap(d.gap_of(mask, tie))
    for z in np.random.default_rng(5).uniform(1.2, 1.8, 200):
        cut = z - d.depth_of(d.key_of(z, mask, 0))
        assert cut >= 0.0 and 2.0 * tie + cut < gap < 2.0 * tie + 2.0**-20
