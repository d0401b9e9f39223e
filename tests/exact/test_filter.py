"""What float64 claims must be true, and it must claim nearly everything."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hsr.exact.decide import nearest
from hsr.exact.filter import (
    ROUNDING,
    TINY,
    candidates,
    conic,
    key_between,
    narrowed,
    round_tables,
)
from hsr.exact.infinitesimals import beside
from hsr.exact.oracle import settled_by_filter
from hsr.exact.problem import problem_of
from tests.exact.hard import CONES, CURVED, PLANAR, hard_view, loose_view

unit = st.floats(-1.0, 1.0)


@settings(deadline=None)
@given(st.tuples(unit, unit, unit), st.integers(-32, 31))
def test_columns_that_are_sure_are_inside_and_those_left_out_are_not(
    half: tuple[float, float, float], j: int
) -> None:
    width = 24
    a, b, c = half
    slack = ROUNDING * (abs(a) * width + abs(b) * 32 + abs(c)) + TINY
    if 0.0 < abs(a) < 2.0**-500:
        return
    first, last, surely_first, surely_last = narrowed(np.array(half), slack, j, width)
    for column in range(width):
        i = 2 * column + 1 - width
        value = Fraction(a) * i + Fraction(b) * j + Fraction(c)
        if surely_first <= column <= surely_last:
            assert value > 0
        if not first <= column <= last:
            assert value < 0


@settings(deadline=None)
@given(st.lists(unit, min_size=6, max_size=6), st.integers(-4095, 4095), st.integers(-4095, 4095))
def test_conics_lie_within_their_bounds(coefficients: list[float], i: int, j: int) -> None:
    low, high = conic(np.array(coefficients), i, j)
    powers = (i * i, i * j, j * j, i, j, 1)
    terms = [Fraction(c) * p for c, p in zip(coefficients, powers, strict=True)]
    assert Fraction(float(low)) <= sum(terms) <= Fraction(float(high))
    assert high - low <= 2.0**-47 * float(sum(map(abs, terms))) + 2.0**-990


@settings(deadline=None)
@given(unit, st.sampled_from([-1, 0, 1]), st.floats(0.0, 1.0), unit.filter(lambda s: abs(s) > 1e-6))
def test_keys_lie_within_their_bounds(p: float, q: int, r: float, s: float) -> None:
    surd = np.zeros((4, 6))
    surd[:, 5] = p, q, r, s
    low, high = key_between(surd, 3, 5)
    # (x s - p)^2 against r, on the side of q, tells where a bound x lies.
    for bound, side in ((low, -1), (high, 1)):
        rest = (Fraction(float(bound)) * Fraction(s) - Fraction(p)) * (1 if s > 0 else -1)
        root_sign = q * (1 if s > 0 else -1)
        square = rest * abs(rest) - root_sign * Fraction(r)
        assert square * side >= 0


def test_a_denominator_that_may_vanish_bounds_nothing() -> None:
    surd = np.zeros((4, 6))
    surd[0, 5], surd[3, 3] = 1.0, 1.0
    assert key_between(surd, 0, 5) == (-np.inf, np.inf)


@pytest.mark.parametrize("shapes", [PLANAR, CURVED, CONES], ids=["planar", "curved", "cones"])
@pytest.mark.parametrize("seed", range(100, 112))
def test_the_owner_is_a_candidate_and_settled_only_if_certain(shapes: tuple[str, ...], seed: int) -> None:
    view = (hard_view if seed % 2 else loose_view)(seed, shapes)
    problem = problem_of(view, np.arange(view.width * view.height))
    tables = round_tables(problem.rounds, problem.frame.nearer)
    found = candidates(problem.tables, tables, view.height, view.width)
    owner, unsettled = settled_by_filter(found)
    everything = [problem.piece(k) for k in range(len(problem.triangles) + len(problem.rounds))]
    for sample in range(view.width * view.height):
        i, j = (int(x) for x in problem.frame.at(np.array(sample)))
        seen = {piece.number for piece in nearest(everything, beside(i, j), problem.frame.nearer)}
        assert seen <= set(found.piece[found.start[sample] : found.start[sample + 1]].tolist())
        if sample not in unsettled:
            assert seen == ({int(owner[sample])} if owner[sample] >= 0 else set())


def test_almost_nothing_is_left_to_decide_where_nothing_ties() -> None:
    view = loose_view(5, (*PLANAR, *CURVED), side=64)
    problem = problem_of(view, np.arange(view.width * view.height))
    found = candidates(problem.tables, round_tables(problem.rounds, problem.frame.nearer), 64, 64)
    assert len(settled_by_filter(found)[1]) == 0
    assert found.start[-1] > 100
