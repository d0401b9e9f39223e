"""Every figure of a benchmark, declared once: tables, charts, CSV and comparisons read them from here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from hsr.lab.results import Row, Verdict

Figure = float | int | None


@dataclass(frozen=True)
class Metric:
    """One figure of a row. The less the better, for all of them.

    Attributes
    ----------
    name : str
        In the heads of CSV files and tables.
    unit : str
        Empty for a count.
    about : str
        What it is, for people: titles of axes and footnotes.
    of : callable
        The figure of a row; None if the row has none.
    """

    name: str
    unit: str
    about: str
    of: Callable[[Row], Figure]

    @property
    def title(self) -> str:
        """Name and unit, for a column or an axis."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name

    @property
    def axis(self) -> str:
        """What it is, and the unit, for an axis."""
        return f"{self.about} [{self.unit}]" if self.unit else self.about

    def text(self, row: Row) -> str:
        """Write the figure as people read it; empty without one."""
        value = self.of(row)
        if value is None:
            return ""
        return f"{value:,}" if isinstance(value, int) else written(value)


def written(value: float) -> str:
    """Write a number with three significant digits at least, and no exponent where people need none."""
    return f"{value:,.0f}" if 100.0 <= value < 1e7 else f"{value:.3g}"


def _time(stage: str) -> Callable[[Row], Figure]:
    return lambda row: row.times[stage].median if stage in row.times else None


def _judged(figure: Callable[[Verdict], Figure]) -> Callable[[Row], Figure]:
    return lambda row: None if row.verdict is None else figure(row.verdict)


def _megabytes(count: int | None) -> Figure:
    return None if count is None else round(count / 1e6, 3)


SPEED = Metric("render", "ms", "time to render", _time("render"))
ERROR = Metric("wrong", "", "wrong samples", _judged(lambda verdict: verdict.wrong))
"""The two by which methods are ranked and the chart is drawn."""

STAGES = (
    Metric("prepare", "ms", "preparing the arrays, uploading", _time("prepare")),
    Metric("build", "ms", "building hierarchies", _time("build")),
    SPEED,
    Metric("read", "ms", "reading ids and depths back", _time("read")),
)
METRICS: Sequence[Metric] = (
    *STAGES,
    Metric("total", "ms", "all stages of a turn", _time("total")),
    Metric("warm-up", "ms", "first tiny picture: compiling, opening drivers", lambda row: row.warm_up),
    ERROR,
    Metric("ties", "", "ties shown otherwise, not wrong", _judged(lambda verdict: verdict.ties)),
    Metric("cluster", "", "largest cluster of wrong samples", _judged(lambda v: v.largest_cluster)),
    Metric("depth max", "scene units", "largest depth error", _judged(lambda v: v.depth.max)),
    Metric("depth median", "scene units", "median depth error", _judged(lambda v: v.depth.median)),
    Metric("depth max", "ulp", "largest depth error", _judged(lambda v: v.depth.max_ulp)),
    Metric("depth median", "ulp", "median depth error", _judged(lambda v: v.depth.median_ulp)),
    Metric("peak", "MB", "rise of resident memory", lambda row: _megabytes(row.peak_bytes)),
    Metric("buffers", "MB", "ids and depths returned", lambda row: _megabytes(row.buffer_bytes)),
    Metric("foreign load", "processors", "kept busy by other programs", lambda row: row.foreign_load),
    Metric("yardstick", "ms", "a fixed piece of work, on one thread", lambda row: row.yardstick),
)
"""All of them, in the order of tables."""


# ---------------------------------------------------------------- ranks


def dominators(rows: Sequence[Row]) -> dict[str, list[str]]:
    """Say for every row of one case which methods are better than its own.

    A method dominates another if it is neither slower nor more often wrong, and better in one of both.
    Rows that nobody dominates are the Pareto frontier.

    Parameters
    ----------
    rows : sequence of Row
        Of one case; rows without figures take no part.

    Returns
    -------
    dict of str to list of str
        By row id, the names of the methods, the fastest first. The length of the list + 1 is the rank.
    """
    ran = sorted((row for row in rows if not row.absent), key=_standing)
    return {row.id: [other.method for other in ran if _dominates(other, row)] for row in ran}


def _standing(row: Row) -> tuple[float, float]:
    speed, error = SPEED.of(row), ERROR.of(row)
    assert speed is not None and error is not None, "a row without a reason to be absent has figures"
    return float(speed), float(error)


def _dominates(one: Row, other: Row) -> bool:
    (a, b), (c, d) = _standing(one), _standing(other)
    return a <= c and b <= d and (a, b) != (c, d)
