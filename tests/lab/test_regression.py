"""Two runs compared: noise is not flagged, a slow-down is."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from hsr.base.errors import HsrError
from hsr.lab.regression import changes, limit_of, warnings
from tests.lab.made_up import MACHINE, noisy, results, row


def verdicts(before: Sequence[float], after: Sequence[float], **state: float) -> str:
    (change,) = changes(results(row("a", before)), results(row("a", after, **state)))
    return change.verdict


@pytest.mark.parametrize("seed", range(10))
def test_the_same_speed_is_not_flagged(seed: int) -> None:
    assert verdicts(noisy(0.002, seed), noisy(0.002, 100 + seed)) == "same"


@pytest.mark.parametrize("seed", range(10))
def test_a_fifth_more_is_caught(seed: int) -> None:
    assert verdicts(noisy(0.002, seed), noisy(0.0024, 100 + seed)) == "slower"
    assert verdicts(noisy(0.0024, seed), noisy(0.002, 100 + seed)) == "faster"


def test_less_than_the_limit_is_the_same_however_certain() -> None:
    assert verdicts([0.001] * 9, [0.00109] * 9) == "same"
    assert verdicts([0.001] * 9, [0.00111] * 9) == "slower"


def test_more_than_the_limit_within_the_noise_is_the_same() -> None:
    wild = [0.001, 0.0012, 0.0015, 0.0018, 0.002]
    assert verdicts(wild, [1.2 * sample for sample in wild]) == "same"


def test_a_busy_machine_widens_the_band() -> None:
    """Half a processor of two taken by others: up to 4/3 of the time."""
    steady, slow = [0.001] * 9, [0.0013] * 9
    assert verdicts(steady, slow) == "slower"
    assert verdicts(steady, slow, foreign_load=0.5) == "same"
    assert verdicts(steady, [0.00135] * 9, foreign_load=0.5) == "slower"
    assert verdicts(steady, [0.01] * 9, foreign_load=2.0) == "same", "nothing can be told"
    (change,) = changes(
        results(row("a", slow, foreign_load=2.0)), results(row("a", steady, foreign_load=0.0))
    )
    assert change.verdict == "same" and change.high == float("inf")


def test_a_slower_machine_widens_the_band() -> None:
    steady, slow = [0.001] * 9, [0.0013] * 9
    assert verdicts(steady, slow, yardstick=0.4) == "same"
    assert verdicts(steady, slow, yardstick=0.2) == "slower", "a faster machine explains no slow-down"


def test_wrong_samples_have_no_noise() -> None:
    right, wrong = results(row("a", wrong=3)), results(row("a", wrong=4))
    assert [change.verdict for change in changes(right, wrong)] == ["more wrong"]
    assert [change.verdict for change in changes(wrong, right)] == ["less wrong"]
    assert changes(right, wrong)[0].cells()[-2:] == ("3 -> 4", "more wrong")


def test_rows_that_are_not_in_both() -> None:
    before = results(row("a"), row("b"), row("c"), row("d", absent="no driver"), row("e", absent="no driver"))
    after = results(row("a"), row("c", absent="broke"), row("d"), row("f"))
    told = {change.row.rpartition("/")[2]: change.verdict for change in changes(before, after)}
    assert told == {"a": "same", "b": "gone", "c": "gone", "d": "new", "e": "absent", "f": "new"}


def test_rows_of_another_scene_are_not_compared() -> None:
    (change,) = changes(results(row("a")), results(row("a", hashes={"scene": "07he4"})))
    assert change.verdict == "another scene" and change.ratio is None


def test_runs_without_a_common_row() -> None:
    with pytest.raises(HsrError, match="nothing to compare"):
        changes(results(row("a")), results(row("b")))


def test_limits() -> None:
    assert limit_of("median:10%") == 0.1 and limit_of("median:2.5%") == 0.025
    for text in ("10%", "median:10", "mean:10%", "median:-1%"):
        with pytest.raises(HsrError, match="write median:PERCENT%"):
            limit_of(text)


def test_what_makes_times_hard_to_compare_is_told() -> None:
    quiet = results(row("a"))
    assert warnings(quiet, quiet) == []
    other = results(row("a", foreign_load=0.7), machine=MACHINE.model_copy(update={"threads": 1}))
    told = warnings(quiet, other)
    assert len(told) == 2 and "threads 2 before, 1 after" in told[0] and "0.70 processors" in told[1]
