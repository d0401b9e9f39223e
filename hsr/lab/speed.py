"""Speed against error: how fast each method is, and how wrong, on the same views in the same run.

Nothing is timed that is not judged: the first map of each method is held against exact arithmetic. Then
the methods take turns, in a new order every time, so that a drift of the machine touches all alike and
nobody always follows the same neighbour. Every turn gets a view of its own: nothing prepared in an earlier
turn is used again, and every stage is measured anew.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from statistics import median
from typing import Any

import numpy as np

from hsr.algorithms.registry import Method, default_methods, method_named, render
from hsr.base.arrays import Floats
from hsr.difference.cause import causes
from hsr.difference.classes import SampleClass, compare
from hsr.difference.study import Progress
from hsr.lab.machine import clocks, commit, equal_threads, foreign_load, machine, peak_of, yardstick
from hsr.lab.results import FEWEST, DepthOff, Results, Row, Verdict
from hsr.lab.statistics import timing
from hsr.problem.map import VisibilityMap
from hsr.problem.view import CULL, View, view
from hsr.scene.model import Scene

PATIENCE = 2.0**26
"""Tests of a face at a sample that one waits for, turn after turn: about a second on two cores."""

SHARE = 15.0
"""Seconds after which a method has had its turns on a case; but it has three in any case."""

REST = 0.01
"""Seconds before each turn: idle threads of GNU OpenMP spin for some milliseconds after the turn before."""

SEED = 1
"""Of the order in which the methods take their turns."""


@dataclass(frozen=True, eq=False)
class Case:
    """One problem for all methods.

    Attributes
    ----------
    scene : str
        What to call it.
    view : View
    cull : {"scene", "none", "back"}
        How ``view`` was culled.
    series : str
        The scaling series it belongs to.
    """

    scene: str
    view: View
    cull: str = "scene"
    series: str = ""


def make_case(name: str, scene: Scene, size: tuple[int, int], cull: str = "scene") -> Case:
    """See a scene by its first camera, with all objects culled in one way.

    Parameters
    ----------
    name : str
    scene : Scene
    size : (width, height)
        In pixels.
    cull : {"scene", "none", "back"}
        ``scene`` leaves each object its own; else it replaces them. What is culled takes no part, so the
        truth changes with it.

    Returns
    -------
    Case

    Raises
    ------
    ViewError
        If the view cannot be made.
    """
    seen = view(scene, size)
    if cull != "scene":
        seen = replace(seen, placements=tuple(replace(p, cull=CULL[cull]) for p in seen.placements))
    return Case(name, seen, cull)


def measure(
    cases: Sequence[Case],
    names: Sequence[str] | None = None,
    repeat: int = 15,
    *,
    explain: bool = True,
    patience: float = math.inf,
    progress: Progress | None = None,
) -> Results:
    """Judge and time methods on cases.

    A method that is missing here, refuses a case, or breaks down keeps its row, which says why; the run
    goes on.

    Parameters
    ----------
    cases : sequence of Case
    names : sequence of str, optional
        Of the methods; :func:`hsr.algorithms.registry.default_methods` without.
    repeat : int
        Turns of every method, three at least. One that has used up its share of time, 15 seconds, has no
        more turns on that case once it has had three.
    explain : bool
        Whether to find the causes of wrong samples.
    patience : float
        How many tests of a face at a sample to wait for: exhaustive methods sit out cases that need more.
    progress : callable, optional
        Called before every step with its name; a case has ``repeat + 1``.

    Returns
    -------
    Results

    Raises
    ------
    MethodError
        If a method does not exist.
    """
    equal_threads()
    chosen = [method_named(name) for name in dict.fromkeys(names or default_methods())]
    turns = max(repeat, FEWEST)
    rows: list[Row] = []
    for case in cases:
        contest = [Contestant(method, case, _reason_to_sit_out(method, case, patience)) for method in chosen]
        rows += _measure_case(case, contest, turns, explain, progress or (lambda _: None))
    day, on = datetime.now(UTC).isoformat(timespec="seconds"), machine()
    return Results(hsr=1, kind="bench", date=day, commit=commit(), repeat=turns, machine=on, rows=tuple(rows))


def _measure_case(
    case: Case, contest: Sequence[Contestant], repeat: int, explain: bool, step: Progress
) -> Iterator[Row]:
    label = f"{case.scene} {case.view.width}x{case.view.height}"
    step(f"{label}: judging")
    truth = render(fresh(case.view), "exact")
    for contestant in contest:
        contestant.attempt(contestant.judge, truth, explain)
    order, begun = np.random.default_rng(SEED), clocks()
    marks: list[float] = []
    for turn in range(repeat):
        step(f"{label}: turn {turn + 1} of {repeat}")
        marks.append(yardstick())
        for k in order.permutation(len(contest)):
            contest[k].attempt(contest[k].take_turn)
    state = {"foreign_load": foreign_load(begun), "yardstick": round(median(marks), 4)}
    for contestant in contest:
        yield contestant.row(state)


def _reason_to_sit_out(method: Method, case: Case, patience: float) -> str:
    seen = case.view
    if not method.exhaustive or seen.faces * seen.width * seen.height <= patience:
        return ""
    return f"sits out: it would test each of {seen.faces:,} faces at each sample"


def fresh(view: View) -> View:
    """Return an equal view of a geometry of its own, of which nothing has been prepared."""
    return replace(view, placements=tuple(view.placements))


# ---------------------------------------------------------------- one method on one case


@dataclass(eq=False)
class Contestant:
    """A method on a case: judged once, then timed turn by turn, until it fails or has used up its share."""

    method: Method
    case: Case
    absent: str
    facts: dict[str, Any] = field(default_factory=dict)
    turns: list[dict[str, float]] = field(default_factory=list)

    def attempt(self, step: Callable[..., None], *what: Any) -> None:
        """Take a step unless the method is out; if it breaks down, it is, and the reason is kept."""
        if self.absent:
            return
        try:
            step(*what)
        except Exception as error:  # another package's method may raise anything
            told = str(error).removeprefix(f"{self.method.name}: ") or type(error).__name__
            self.absent = " ".join(told.split())

    def take_turn(self) -> None:
        """Render once more, on a view of its own, and keep the times of all stages."""
        used = sum(sum(turn.values()) for turn in self.turns)
        if len(self.turns) < FEWEST or used < SHARE:
            time.sleep(REST)
            self.turns.append(self.method.render(fresh(self.case.view)).seconds)

    def judge(self, truth: VisibilityMap, explain: bool) -> None:
        """Warm up, render once under watch, and compare the map with the truth."""
        start = time.perf_counter()
        self.method.warm_up(fresh(self.case.view))
        warm_up = 1e3 * (time.perf_counter() - start)
        problem = fresh(self.case.view)
        answer, peak = peak_of(lambda: self.method.render(problem))
        self.facts = {
            "driver": answer.notes.get("driver", ""),
            "threads": answer.notes.get("threads", equal_threads()),
            "warm_up": round(warm_up, 4),
            "verdict": verdict(self.case.view, answer, truth, explain),
            "work": answer.work,
            "peak_bytes": peak,
            "buffer_bytes": answer.face.nbytes + answer.depth.nbytes,
        }

    def row(self, state: dict[str, float | None]) -> Row:
        """Return what was found, with the state of the machine meanwhile."""
        case, seen = self.case, self.case.view
        head: dict[str, Any] = {
            "id": f"{case.scene}/{seen.width}x{seen.height}/{case.cull}/{self.method.name}",
            "series": case.series,
            "scene": case.scene,
            "width": seen.width,
            "height": seen.height,
            "cull": case.cull,
            "method": self.method.name,
            "faces": seen.faces,
            "triangles": len(seen.tessellated().polygons.triangle_face),
            "hashes": seen.hashes,
        }
        if self.absent:
            return Row(**head, absent=self.absent)
        turns = [turn | {"total": sum(turn.values())} for turn in self.turns]
        times = {stage: timing([turn[stage] for turn in turns]) for stage in turns[0]}
        return Row(**head, **self.facts, times=times, **state)


# ---------------------------------------------------------------- judging


def verdict(view: View, answer: VisibilityMap, truth: VisibilityMap, explain: bool = True) -> Verdict:
    """Say how wrong a map is.

    Parameters
    ----------
    view : View
    answer : VisibilityMap
    truth : VisibilityMap
        The exact map of the same view, with its admissible owners.
    explain : bool
        Whether to find the causes of wrong samples.

    Returns
    -------
    Verdict
        Depths are compared wherever the method shows the exact owner.
    """
    difference = compare(answer, truth)
    right = (answer.face == truth.face) & np.isfinite(truth.depth)
    return Verdict(
        wrong=difference.different,
        ties=difference.counts[SampleClass.TIE.label],
        clusters=len(difference.clusters),
        largest_cluster=difference.largest,
        causes=causes(view, answer, truth).counts if explain else None,
        depth=_depth_off(answer.depth[right], truth.depth[right]),
    )


def _depth_off(shown: Floats, exact: Floats) -> DepthOff:
    if not len(exact):
        return DepthOff(samples=0, max=0.0, median=0.0, max_ulp=0.0, median_ulp=0.0)
    off = np.abs(shown - exact)
    ulp = off / np.spacing(np.abs(exact))
    figures = {"max": off.max(), "median": np.median(off), "max_ulp": ulp.max(), "median_ulp": np.median(ulp)}
    return DepthOff(samples=len(exact), **{name: float(value) for name, value in figures.items()})
