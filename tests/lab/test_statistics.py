"""Medians, their intervals, and the interval of a ratio."""

from __future__ import annotations

import numpy as np
import pytest

from hsr.lab.statistics import ratio_band, timing


def test_a_timing_is_in_milliseconds() -> None:
    found = timing([0.004, 0.002, 0.003, 0.001, 0.005])
    assert (found.q1, found.median, found.q3) == (2.0, 3.0, 4.0)
    assert found.samples == (4.0, 2.0, 3.0, 1.0, 5.0), "the order of the turns is kept"
    assert 1.0 <= found.low <= found.median <= found.high <= 5.0


def test_equal_samples_leave_no_doubt() -> None:
    found = timing([0.002] * 4)
    assert found.low == found.median == found.high == 2.0


def test_an_outlier_moves_neither_median_nor_interval() -> None:
    calm = timing([0.001 + 1e-6 * k for k in range(21)])
    struck = timing([*(0.001 + 1e-6 * k for k in range(20)), 0.5])
    assert struck.median == calm.median and struck.high == pytest.approx(calm.high, abs=0.005)


def test_the_interval_holds_the_true_median_as_often_as_it_says() -> None:
    rng = np.random.default_rng(7)
    held = 0
    for _ in range(200):
        found = timing(rng.exponential(0.001, 21))
        held += found.low <= np.log(2.0) <= found.high
    assert 180 <= held <= 199, (
        held
    )  # 95 % of 200 is 190; percentile intervals of 21 samples fall a little short


def test_the_band_of_a_ratio_holds_it() -> None:
    rng = np.random.default_rng(3)
    before, after = rng.normal(1.0, 0.02, 21), rng.normal(1.2, 0.02, 21)
    low, high = ratio_band(before, after)
    assert 1.0 < low < 1.2 < high < 1.3
    back = ratio_band(after, before)
    assert back == (pytest.approx(1.0 / high, abs=0.01), pytest.approx(1.0 / low, abs=0.01))


def test_the_same_samples_give_the_same_interval() -> None:
    samples = np.random.default_rng(1).exponential(0.001, 15)
    assert timing(samples) == timing(samples)
