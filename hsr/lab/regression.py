"""Two runs compared: which methods have become slower, or wrong.

A row is slower if the median of all its stages has grown by more than a limit *and* by more than noise
explains: the noise band of the ratio lies above 1 altogether. Noise is

* what the samples show: the bootstrap interval of the ratio of medians;
* other programs: of P processors they kept f busy, and a method that uses all P may have waited for them,
  its time longer by up to ``P / (P - f)``. So much less the later time may have been, and the earlier;
* the machine itself, if the yardstick took longer in the run that looks slower.

On a quiet machine the last two are 1; on a busy one the band is wide, and nothing can be told.
More wrong samples are more wrong samples: the count has no noise.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from hsr.base.errors import HsrError
from hsr.lab.results import Results, Row
from hsr.lab.statistics import ratio_band
from hsr.lab.tables import Table

NOTABLE_LOAD = 0.1
"""Processors kept busy by others from which a person should be told."""

LIMIT = 0.10
"""By how much a median may grow unless ``--fail`` says otherwise."""

SLOWER, FASTER, SAME, WRONG, FIXED = "slower", "faster", "same", "more wrong", "less wrong"
GONE, NEW, OTHER, ABSENT = "gone", "new", "another scene", "absent"

FAILURES = (WRONG, GONE, OTHER)
"""Verdicts that no comparison lets pass; ``slower`` is one where a limit is set."""

HEAD = ("row", "before [ms]", "after [ms]", "ratio", "noise band", "wrong", "verdict")


@dataclass(frozen=True)
class Change:
    """One row in two runs.

    Attributes
    ----------
    row : str
        Its id.
    verdict : str
        ``same``, ``slower`` or ``faster``; ``more wrong`` or ``less wrong``; ``gone``: it has no figures
        any more; ``new``; ``absent`` from both; ``another scene``: the rows do not show the same thing.
    before, after : float or None
        Medians of all stages, in milliseconds.
    ratio, low, high : float or None
        ``after / before`` and its noise band.
    wrong : tuple of 2 int or None
        Wrong samples before and after.
    """

    row: str
    verdict: str
    before: float | None = None
    after: float | None = None
    ratio: float | None = None
    low: float | None = None
    high: float | None = None
    wrong: tuple[int, int] | None = None

    def cells(self) -> tuple[str, ...]:
        """Return the cells of the table: one for each column of ``HEAD``."""
        if self.ratio is None or self.wrong is None:
            return (self.row, "", "", "", "", "", self.verdict)
        before, after = self.wrong
        wrong = f"{after:,}" if before == after else f"{before:,} -> {after:,}"
        figures = (f"{figure:.3f}" for figure in (self.before, self.after, self.ratio))
        return (self.row, *figures, f"{self.low:.3f} to {self.high:.3f}", wrong, self.verdict)


def table(changes: Sequence[Change], title: str) -> Table:
    """Return a line a change."""
    return Table(HEAD, [change.cells() for change in changes], HEAD[1:6], title)


def limit_of(text: str) -> float:
    """Read a limit such as ``median:10%`` as a fraction.

    Raises
    ------
    HsrError
        If it is written in another way.
    """
    found = re.fullmatch(r"median:(\d+(?:\.\d+)?)%", text)
    if found is None:
        raise HsrError(f"--fail {text!r}: write median:PERCENT%, such as median:10%")
    return float(found[1]) / 100.0


def changes(before: Results, after: Results, limit: float = LIMIT) -> list[Change]:
    """Compare two runs row by row.

    Parameters
    ----------
    before, after : Results
        The rows are matched by their ids.
    limit : float
        By which fraction the median of all stages may grow, or shrink, and be the same.

    Returns
    -------
    list of Change
        In the order of ``before``, then what is new.

    Raises
    ------
    HsrError
        If the runs have no row in common.
    """
    old, new = ({row.id: row for row in results.rows} for results in (before, after))
    if not old.keys() & new.keys():
        raise HsrError("nothing to compare: the runs have no scene, size and method in common")
    processors = before.machine.processors, after.machine.processors
    found = [_change(row, new.get(name), limit, processors) for name, row in old.items()]
    return [*found, *(Change(name, NEW) for name in new if name not in old)]


def _change(before: Row, after: Row | None, limit: float, processors: tuple[int, int]) -> Change:
    if before.absent:
        return Change(before.id, ABSENT if after is None or after.absent else NEW)
    if after is None or after.absent:
        return Change(before.id, GONE)
    if before.hashes != after.hashes:
        return Change(before.id, OTHER)
    old, new = before.times["total"], after.times["total"]
    ratio = new.median / old.median
    low, high = noise_band(before, after, processors)
    assert before.verdict is not None and after.verdict is not None, "both have figures"
    wrong = before.verdict.wrong, after.verdict.wrong
    if wrong[0] != wrong[1]:
        verdict = WRONG if wrong[1] > wrong[0] else FIXED
    elif ratio > 1.0 + limit and low > 1.0:
        verdict = SLOWER
    elif ratio < 1.0 / (1.0 + limit) and high < 1.0:
        verdict = FASTER
    else:
        verdict = SAME
    return Change(before.id, verdict, old.median, new.median, ratio, low, high, wrong)


def noise_band(before: Row, after: Row, processors: tuple[int, int]) -> tuple[float, float]:
    """Return between what the ratio of the two medians may lie by noise; see the head of this module.

    Parameters
    ----------
    before, after : Row
        With figures.
    processors : (int, int)
        Of the two machines.

    Returns
    -------
    low, high : float
    """
    low, high = ratio_band(before.times["total"].samples, after.times["total"].samples)
    drift = (after.yardstick or 1.0) / (before.yardstick or 1.0)
    low *= _left(after, processors[1]) / max(drift, 1.0)
    left = _left(before, processors[0]) * min(drift, 1.0)
    return low, high / left if left > 0.0 else math.inf


def _left(row: Row, processors: int) -> float:
    """Return the share of the processors that other programs left."""
    return max(1.0 - (row.foreign_load or 0.0) / processors, 0.0)


def warnings(before: Results, after: Results) -> list[str]:
    """Say what makes the times of two runs hard to compare: other machines, other load."""
    told = []
    for what in ("name", "processors", "threads", "environment"):
        a, b = getattr(before.machine, what), getattr(after.machine, what)
        if a != b:
            told += [f"the machines differ: {what} {a} before, {b} after; times may differ for that reason"]
    load = max(results.foreign_load or 0.0 for results in (before, after))
    if load > NOTABLE_LOAD:
        told.append(f"other programs kept up to {load:.2f} processors busy: the noise bands are wide")
    return told
