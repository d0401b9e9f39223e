"""The drift of stepped depths is what theory says: below the bound at every length, and near it."""

from __future__ import annotations

import pytest

from benchmarks.drift import STEPPINGS, Stepping, guarded, worst

FLOAT32, DIRECT, UNGUARDED, *_ = STEPPINGS


@pytest.mark.jit
@pytest.mark.parametrize("length", [64, 1024, 4096])
@pytest.mark.parametrize("stepping", STEPPINGS, ids=lambda stepping: stepping.name)
def test_no_error_is_beyond_its_bound(stepping: Stepping, length: int) -> None:
    assert worst(stepping, length) <= stepping.bound(length)


@pytest.mark.jit
@pytest.mark.parametrize("length", [64, 1024, 4096])
@pytest.mark.parametrize("stepping", [FLOAT32, UNGUARDED, guarded(6)], ids=lambda stepping: stepping.name)
def test_steps_drift_in_proportion_to_the_span(stepping: Stepping, length: int) -> None:
    """Sums that are all rounded the same way: some span comes near the bound."""
    assert worst(stepping, length) >= 0.6 * stepping.bound(length)


@pytest.mark.jit
def test_evaluation_and_guard_bits_do_not_drift() -> None:
    for stepping in (DIRECT, guarded(12)):
        short, long = worst(stepping, 64), worst(stepping, 4096)
        assert 0.2 < long < 1.6 * short
