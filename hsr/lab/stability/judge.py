"""Running a family: every variant at every value, judged by the truth, held against its theory."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np

from hsr.algorithms.registry import method_named
from hsr.base.arrays import Bools
from hsr.base.errors import MethodError, UnavailableError
from hsr.difference.cause import causes
from hsr.difference.study import Progress
from hsr.lab.stability.family import QUICK_SIDE, SIDE, Family, Trial, Variant, at_side
from hsr.models.stages import Cause
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View

TRACED, QUICK_TRACED = 64, 8
"""At most so many wrong samples of a picture are put down to a cause, evenly spread: models are slow."""

HALVINGS = 6
"""So often the gap in which a variant breaks is halved: one of 4 to 1 shrinks to 2 percent."""

PLANTED = "planted mistake"
"""The cause of all that a mistake gets wrong."""

OTHER_CHOICE = "another choice at a tie"
"""The cause of a sample that counts as wrong although the face is admissible."""


class Verdict(StrEnum):
    """How what was measured compares with what theory says."""

    HOLDS = "holds"
    AS_PREDICTED = "breaks as predicted"
    EARLY = "breaks early"
    THEORY_WRONG = "theory wrong"
    NO_THEORY = "breaks, no theory"
    REFUSED = "refused every view"


FINE = (Verdict.HOLDS, Verdict.AS_PREDICTED, Verdict.NO_THEORY)
"""The verdicts that contradict nothing. Who refuses every view has shown nothing."""


@dataclass(frozen=True)
class Point:
    """One variant at one value of the parameter.

    Attributes
    ----------
    value : float
    wrong, samples : int
        Samples that count as wrong, and all of the picture.
    figure : float
        What the family measures: the number of wrong samples, unless it has a figure of its own.
    causes : dict of str to int
        Why they are wrong; of more than ``TRACED`` wrong samples so many are asked.
    refused : str
        Why the method did not render, empty if it did.
    """

    value: float
    wrong: int
    samples: int
    figure: float
    causes: dict[str, int]
    refused: str = ""


@dataclass(frozen=True)
class Row:
    """One variant in one family.

    Attributes
    ----------
    variant : str
    because : str
        The theory, empty if there is none.
    points : tuple of Point
        From easy to hard.
    predicted, measured : float or None
        The value of the parameter from which on samples are wrong; None: nowhere in the sweep. It is
        measured by bisection, unless the run is quick or the family knows no values between. Of a variant
        with a curve, the figure where the two differ most.
    curve : tuple of float
        The figure that theory expects at every point, if the family has one of its own.
    verdict : Verdict
    at : float or None
        Of a variant with a curve, the value of the parameter where the two figures differ most.
    """

    variant: str
    because: str
    points: tuple[Point, ...]
    predicted: float | None
    measured: float | None
    curve: tuple[float, ...]
    verdict: Verdict
    at: float | None = None

    @property
    def wrong(self) -> int:
        """Number of wrong samples over the whole sweep."""
        return sum(point.wrong for point in self.points)

    @property
    def traced(self) -> int:
        """Number of wrong samples that were put to the models of the method."""
        return sum(count for cause, count in self.causes.items() if cause != PLANTED)

    @property
    def unexplained(self) -> int:
        """Number of those traced that no model of the method explains."""
        return self.causes.get(Cause.UNEXPLAINED.label, 0)

    @property
    def causes(self) -> dict[str, int]:
        """Wrong samples by cause, of those that were traced over the whole sweep."""
        return dict(sum((Counter(point.causes) for point in self.points), Counter()))

    def to_json(self) -> dict[str, Any]:
        """Return the row as JSON values."""
        totals = {"wrong": self.wrong, "causes": self.causes}
        return asdict(self) | totals | {"traced": self.traced, "unexplained": self.unexplained}


@dataclass(frozen=True)
class Result:
    """A family, and a row for everyone who took part.

    Attributes
    ----------
    family : Family
    side : int
        Of the pictures, in samples.
    rows : tuple of Row
    skipped : dict of str to str
        Who could not take part on this machine, and why.
    drivers : dict of str to str
        What the peers' libraries say of themselves.
    """

    family: Family
    side: int
    rows: tuple[Row, ...]
    skipped: dict[str, str]
    drivers: dict[str, str]

    def to_json(self) -> dict[str, Any]:
        """Return the result as JSON values."""
        of, rows = self.family, [row.to_json() for row in self.rows]
        about = {"family": of.name, "group": of.group, "parameter": of.parameter, "figure": of.figure_name}
        return about | {"side": self.side, "rows": rows, "skipped": self.skipped, "drivers": self.drivers}


def judge(
    family: Family, quick: bool = False, asked: Sequence[str] = (), progress: Progress | None = None
) -> Result:
    """Run a family.

    Parameters
    ----------
    family : Family
    quick : bool
        Small pictures and short sweeps.
    asked : sequence of str
        The variants or methods that take part; by default the certified methods, the family's variants
        and the peers.
    progress : callable, optional
        Called with a line before each value of the parameter.

    Raises
    ------
    MethodError
        If a name that was asked for is unknown.
    UnavailableError
        If this machine lacks what one that was asked for needs; others are skipped.
    """
    side, traced = (QUICK_SIDE, QUICK_TRACED) if quick else (SIDE, TRACED)
    points: dict[str, list[Point]] = defaultdict(list)
    skipped: dict[str, str] = {}
    drivers: dict[str, str] = {}
    variants = family.contenders(tuple(asked), quick)
    for value in family.values(quick):
        if progress is not None:
            progress(f"{family.name} {value:g}")
        problem = _Problem(family, value, side)
        for variant in (one for one in variants if one.name not in skipped):
            try:
                point, driver = _judged(problem, variant, traced)
            except UnavailableError as error:
                if asked:
                    raise
                skipped[variant.name] = str(error)
                continue
            points[variant.name].append(point)
            if driver:
                drivers[variant.name] = driver
    sharp = family.continuous and not quick
    ran = [variant for variant in variants if variant.name not in skipped]
    rows = tuple(_row(family, side, variant, points[variant.name], sharp) for variant in ran)
    return Result(family, side, rows, skipped, drivers)


class _Problem:
    """The views of one value, each with its truth, which all variants share."""

    def __init__(self, family: Family, value: float, side: int) -> None:
        self.family, self.value = family, value
        self._view = family.view(value, side)
        self._truths: dict[bool, tuple[View, VisibilityMap]] = {}

    def truth(self, curved: bool) -> tuple[View, VisibilityMap]:
        """Return the view as a variant is given it, and its exact map."""
        curved = curved or not self._view.curved
        if curved not in self._truths:
            seen = self._view if curved else self._view.tessellated()
            self._truths[curved] = seen, method_named("exact").render(seen)
        return self._truths[curved]


def _judged(problem: _Problem, variant: Variant, traced: int) -> tuple[Point, str]:
    """Render one value by one variant; return what came out, and the driver that did it, if one did."""
    seen, truth = problem.truth(variant.curved)
    samples = seen.width * seen.height
    try:
        answer = variant.render(seen)
    except MethodError as refusal:
        return Point(problem.value, 0, samples, 0.0, {}, str(refusal)), ""
    trial = Trial(problem.family, problem.value, seen, truth, variant, answer)
    wrong = problem.family.wrong(trial)
    count = int(np.count_nonzero(wrong))
    figure = problem.family.figure(trial, wrong) if problem.family.figure else float(count)
    point = Point(problem.value, count, samples, figure, _causes(trial, wrong, traced))
    return point, answer.notes.get("driver", "")


def _causes(trial: Trial, wrong: Bools, traced: int) -> dict[str, int]:
    """Count the wrong samples (H, W) by cause; at most so many of them are traced."""
    samples = np.flatnonzero(wrong)
    if not len(samples):
        return {}
    if trial.variant.mistake is not None:
        return {PLANTED: len(samples)}
    chosen = samples[:: -(-len(samples) // traced)]
    face = trial.truth.face.copy()  # what is right needs no cause
    face.ravel()[chosen] = trial.answer.face.ravel()[chosen]
    answer = replace(trial.answer, face=face)
    found = causes(trial.view, answer, trial.truth, **trial.variant.options).cause.ravel()[chosen]
    labels = {cause: cause.label for cause in Cause} | {Cause.NONE: OTHER_CHOICE}
    return {label: n for cause, label in labels.items() if (n := int(np.count_nonzero(found == cause)))}


# ---------------------------------------------------------------- theory against measurement


def _row(family: Family, side: int, variant: Variant, points: Sequence[Point], sharp: bool) -> Row:
    if variant.curve is not None:
        return _row_of_curve(variant, points)
    if all(point.refused for point in points):
        return Row(variant.name, variant.because, tuple(points), None, None, (), Verdict.REFUSED)
    predicted, values = at_side(variant.breaks, side), [point.value for point in points]
    measured = next((point.value for point in points if point.wrong), None)
    if sharp and variant.because and measured not in (None, values[0]):
        k = values.index(measured)
        right, measured = _bisected(family, side, variant, values[k - 1], measured)
        values.insert(k, right)
    verdict = _verdict(family, side, variant, values, measured)
    return Row(variant.name, variant.because, tuple(points), predicted, measured, (), verdict)


def _bisected(family: Family, side: int, variant: Variant, right: float, wrong: float) -> tuple[float, float]:
    """Return a right and a wrong value between these two, so near each other that the break is sharp."""
    for _ in range(HALVINGS if right * wrong > 0.0 else 0):  # there is no geometric mean with 0
        middle = math.copysign(math.sqrt(right * wrong), wrong)
        point, _ = _judged(_Problem(family, middle, side), variant, 1)
        right, wrong = (right, middle) if point.wrong else (middle, wrong)
    return right, wrong


def _verdict(
    family: Family, side: int, variant: Variant, values: list[float], measured: float | None
) -> Verdict:
    """Judge a break: none before the predicted one within the factor, and one by the first value beyond it.

    Exactly at the predicted value over the factor is not too early; at the safe value it is.
    """
    if not variant.because:
        return Verdict.HOLDS if measured is None else Verdict.NO_THEORY
    sign, ease = (1.0, variant.factor) if family.ascending else (-1.0, 1.0 / variant.factor)
    predicted, safe = at_side(variant.breaks, side), at_side(variant.safe, side)
    # Of hardness, which ascends in any case: what never breaks does so beyond all values.
    first, expected = (math.inf if value is None else sign * value for value in (measured, predicted))
    due = next((sign * value for value in values if sign * value >= expected * ease), math.inf)
    if first < expected / ease or (safe is not None and first <= sign * safe):
        return Verdict.EARLY
    if first > due:
        return Verdict.THEORY_WRONG
    return Verdict.HOLDS if measured is None else Verdict.AS_PREDICTED


def _row_of_curve(variant: Variant, points: Sequence[Point]) -> Row:
    """Judge a figure at every point, 0 where the method is never wrong: the curve bounds it."""
    assert variant.curve is not None
    curve = tuple(variant.curve(point.value) for point in points)
    ratios = [point.figure / theory for point, theory in zip(points, curve, strict=True)]
    worst = max(range(len(points)), key=lambda k: abs(math.log(ratios[k])) if ratios[k] else math.inf)
    if max(ratios) > variant.excess:
        verdict = Verdict.EARLY
    else:
        verdict = Verdict.AS_PREDICTED if min(ratios) >= 1.0 / variant.factor else Verdict.THEORY_WRONG
    predicted, measured, at = curve[worst], points[worst].figure, points[worst].value
    return Row(variant.name, variant.because, tuple(points), predicted, measured, curve, verdict, at)


# ---------------------------------------------------------------- over all families


def contradictions(results: Sequence[Result]) -> list[tuple[Result, Row]]:
    """Return every row that contradicts its theory."""
    return [(result, row) for result in results for row in result.rows if row.verdict not in FINE]
