"""The truth about a view: the owner of every sample, and everyone who might own it.

Everything here is decided on the numbers of the view as they stand, without rounding: float64
proves what it can, integers and polynomials decide the rest.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from hsr.base.arrays import Array, Floats, Ints, ranges
from hsr.exact.decide import Answer
from hsr.exact.depths import depths_of
from hsr.exact.filter import Candidates, candidates, round_tables
from hsr.exact.problem import Problem, problem_of
from hsr.exact.ties import Verdicts, firsts, settle
from hsr.problem.map import BACKGROUND, Admissible
from hsr.problem.view import View


@dataclass(frozen=True, eq=False)
class Truth:
    """The exact answer for a view.

    Attributes
    ----------
    face : (H, W) int32
    depth : (H, W) float64
    admissible : Admissible
    uncertain : int
        How many samples float64 could not settle.
    """

    face: Ints
    depth: Floats
    admissible: Admissible
    uncertain: int


def truth(view: View) -> Truth:
    """Decide every sample of a view exactly.

    Parameters
    ----------
    view : View

    Returns
    -------
    Truth

    Raises
    ------
    ViewError
        If the camera is singular, or its depth does not grow along its lines of sight.
    """
    problem = problem_of(view)
    owner, verdicts, unsettled = _decided(problem, view, np.arange(view.height * view.width))
    shape = (view.height, view.width)
    face, depth = _faces(problem)[owner].reshape(shape), depths_of(problem, owner).reshape(shape)
    return Truth(face, depth, admissible_of(verdicts), len(unsettled))


def answers(view: View, samples: Array) -> dict[int, Answer]:
    """Decide some samples of a view exactly.

    Parameters
    ----------
    view : View
    samples : (n,) int64
        Numbers ``row * W + column``, ascending, each once.

    Returns
    -------
    dict
        By sample the face that owns it, and all that may own it; -1 is the background.

    Raises
    ------
    ViewError
        If the camera is singular, or its depth does not grow along its lines of sight.
    """
    problem = problem_of(view)
    owner, verdicts, _ = _decided(problem, view, samples)
    faces = _faces(problem)[owner[samples]].tolist()
    found = {sample: (face, frozenset([face])) for sample, face in zip(samples.tolist(), faces, strict=True)}
    for verdict in verdicts:
        for sample, which in zip(verdict.sample.tolist(), verdict.answer.tolist(), strict=True):
            found[sample] = found[sample][0], verdict.answers[which][1]
    return found


def _decided(problem: Problem, view: View, samples: Array) -> tuple[Ints, list[Verdicts], Array]:
    """Return the piece (H W,) that owns each of some samples, verdicts, and those of unsettled samples."""
    curved = round_tables(problem.rounds, problem.frame.nearer)
    found = candidates(problem.tables, curved, view.height, view.width)
    owner, unsettled = settled_by_filter(found)
    unsettled = np.intersect1d(unsettled, samples, assume_unique=True)
    verdicts = list(settle(problem, found, unsettled))
    for verdict in verdicts:
        owners = np.array([piece for piece, _ in verdict.answers], dtype=np.int32)
        owner[verdict.sample] = owners[verdict.answer]
    return owner, verdicts, unsettled


def _faces(problem: Problem) -> Ints:
    """Return the face of every piece, and last that of piece -1, the background."""
    others = [*(this.piece.face for this in problem.rounds), BACKGROUND]
    return np.concatenate([problem.triangles.face, np.array(others, dtype=np.int32)])


def settled_by_filter(found: Candidates) -> tuple[Ints, Array]:
    """Return the piece (H W,) that owns each sample if certain, and the samples where it is not."""
    count = np.diff(found.start)
    single = np.flatnonzero(count == 1)
    single = single[found.sure[found.start[single]]]
    owner = np.full(len(count), BACKGROUND, dtype=np.int32)
    owner[single] = found.piece[found.start[single]]
    return owner, np.flatnonzero((count > 0) & (owner == BACKGROUND))


def admissible_of(verdicts: Iterable[Verdicts]) -> Admissible:
    """Collect the tied samples."""
    parts = [np.zeros((2, 0), np.int64)]
    for verdict in verdicts:
        start = np.cumsum([0, *(len(faces) for _, faces in verdict.answers)])
        listed = np.array([face for _, faces in verdict.answers for face in sorted(faces)], dtype=np.int64)
        tied = np.flatnonzero(np.diff(start)[verdict.answer] > 1)
        which, entry = ranges(start[verdict.answer[tied]], start[verdict.answer[tied] + 1])
        parts.append(np.stack([verdict.sample[tied][which], listed[entry]]))
    sample, face = np.concatenate(parts, axis=1)
    order = np.argsort(sample, kind="stable")
    first = firsts(sample[order])
    return Admissible(sample[order][first], np.append(first, len(face)), face[order].astype(np.int32))
