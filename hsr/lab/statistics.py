"""The statistics of timings: medians, their bootstrap intervals, and the interval of a ratio.

Times of one stage are skewed and have outliers, so nothing here assumes a distribution: intervals are
percentiles of resampled medians (B. Efron, R. Tibshirani, *An Introduction to the Bootstrap*, 1993,
chapter 13). The same samples always give the same interval.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.stats import bootstrap

from hsr.base.arrays import Array
from hsr.lab.results import Timing

CONFIDENCE = 0.95
"""Of the interval of one median."""

BAND = 0.99
"""Confidence of the noise band of a ratio: a comparison judges dozens of rows at once."""

RESAMPLES = 2000
SEED = 1


def timing(seconds: Sequence[float]) -> Timing:
    """Sum up the samples of one stage.

    Parameters
    ----------
    seconds : sequence of float
        Three at least, in the order of the turns.

    Returns
    -------
    Timing
        In milliseconds, to 0.1 microseconds: the clock of the machine is no finer.
    """
    samples = np.round(1e3 * np.asarray(seconds), 4)
    q1, median, q3 = np.percentile(samples, [25, 50, 75])
    low, high = _interval((samples,), np.median, CONFIDENCE)
    figures = {"median": median, "q1": q1, "q3": q3, "low": low, "high": high}
    rounded = {name: round(float(value), 4) for name, value in figures.items()}
    return Timing(**rounded, samples=tuple(samples.tolist()))


def ratio_band(before: Sequence[float], after: Sequence[float]) -> tuple[float, float]:
    """Return the bootstrap interval of ``median(after) / median(before)``.

    Parameters
    ----------
    before, after : sequence of float
        Positive, in one unit.

    Returns
    -------
    low, high : float
    """
    return _interval((np.asarray(before), np.asarray(after)), _ratio_of_medians, BAND)


def _ratio_of_medians(before: Array, after: Array, axis: int) -> Any:
    return np.median(after, axis=axis) / np.median(before, axis=axis)


def _interval(data: tuple[Array, ...], statistic: Any, confidence: float) -> tuple[float, float]:
    how = {"n_resamples": RESAMPLES, "method": "percentile", "rng": np.random.default_rng(SEED)}
    found = bootstrap(data, statistic, confidence_level=confidence, **how).confidence_interval
    return float(found.low), float(found.high)
