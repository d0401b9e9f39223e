"""The closed forms, against formats that are written out in NumPy."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hsr.lab.stability import theory
from hsr.lab.stability.cases.parallel_pair import CROSSINGS, FAR, NEAR

NEAR_FAR = (1.0, 1025.0)


def window(d: Any) -> Any:
    near, far = NEAR_FAR
    return (1.0 - near / d) / (1.0 - near / far)


FORMATS: dict[str, tuple[Callable[[Any], Any], Callable[[float], float]]] = {
    "D16": (lambda d: np.rint(window(d) * (2**16 - 1)), lambda d: theory.integers(16, d, *NEAR_FAR)),
    "D24": (lambda d: np.rint(window(d) * (2**24 - 1)), lambda d: theory.integers(24, d, *NEAR_FAR)),
    "D32F": (lambda d: window(d).astype(np.float32), lambda d: theory.float_window(d, *NEAR_FAR)),
    "reversed": (
        lambda d: ((1.0 / d - 1.0 / 1025.0) / (1.0 - 1.0 / 1025.0)).astype(np.float32),
        lambda d: theory.float_reversed(d, *NEAR_FAR),
    ),
    "reversed in [-1, 1]": (
        lambda d: (
            (2.0 * (1.0 - window(d)) - 1.0).astype(np.float32) * np.float32(0.5) + np.float32(0.5)
        ).astype(np.float32),
        lambda d: theory.reversed_through_ndc(d, *NEAR_FAR),
    ),
    "half": (
        lambda d: ((1.0 / d - 1.0 / 1025.0) / (1.0 - 1.0 / 1025.0)).astype(np.float16),
        lambda d: theory.float_reversed(d, *NEAR_FAR, mantissa=10, least=-24),
    ),
    "W16": (
        lambda d: np.rint((d - 1.0) / 1024.0 * (2**16 - 1)),
        lambda d: theory.linear(16, d, *NEAR_FAR),
    ),
    "1/w": (lambda d: (1.0 / d).astype(np.float32), theory.reciprocal),
    "log": (
        lambda d: np.rint(np.log(d) / math.log(1025.0) * (2**16 - 1)),
        lambda d: theory.logarithmic(16, d, *NEAR_FAR),
    ),
}


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("distance", [1.7, 13.0, 260.0])
def test_a_resolution_is_what_is_always_told_apart_and_little_more(name: str, distance: float) -> None:
    """At 1.05 of it pairs anywhere near the distance differ; at 0.6 of it some do not."""
    stored, resolution = FORMATS[name]
    near = distance * (1.0 + np.random.default_rng(0).uniform(0.0, 1e-3, 2000))
    dz = resolution(float(near.max()))
    assert (stored(near) != stored(near + 1.05 * dz)).all()
    assert (stored(near) == stored(near + 0.6 * dz)).any()


def test_theories_cross_where_the_chart_says() -> None:
    log, mean = CROSSINGS["log better than D16"], CROSSINGS["W16, W24 better than D16, D24"]
    assert theory.integers(16, log, NEAR, FAR) == pytest.approx(
        theory.logarithmic(16, log, NEAR, FAR), rel=1e-3
    )
    for bits in (16, 24):
        assert theory.integers(bits, mean, NEAR, FAR) == pytest.approx(
            theory.linear(bits, mean, NEAR, FAR), rel=1e-2
        )
    both = CROSSINGS["D24 no worse than D32F"]
    ratio = [
        theory.float_window(d, NEAR, FAR) / theory.integers(24, d, NEAR, FAR)
        for d in (both / 1.2, both * 1.2)
    ]
    assert ratio[0] < 0.6 and ratio[1] == pytest.approx(1.0, rel=1e-3)


def test_separation_has_its_two_limits() -> None:
    no_snapping = theory.separation(0.5, 10.0, 0.75, 200, 0.1)
    assert no_snapping == pytest.approx(0.5 * math.hypot(1.0, 0.75))  # dz / cos(alpha)
    no_format = theory.separation(0.0, 10.0, 0.75, 8, 0.1)
    assert no_format == pytest.approx(math.sqrt(2.0) * 2.0**-8 * 0.1 * 10.0)


def test_spacing_is_that_of_float32() -> None:
    for value in (1.0, 1.5, 0.3, 2.0**-126, 1e-41):
        assert theory.spacing(value) == float(np.spacing(np.float32(value)))
