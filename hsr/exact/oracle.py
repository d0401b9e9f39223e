"""The truth about a view: the owner of every sample, and everyone who might own it.

Everything here is decided on the numbers of the view as they stand, without rounding: float64
proves what it can, integers and polynomials decide the rest.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from hsr.arrays import Array, Floats, Ints
from hsr.exact.depths import depths_of
from hsr.exact.filter import Candidates, candidates, round_tables
from hsr.exact.problem import problem_of
from hsr.exact.ties import Verdicts, entries, firsts, settle
from hsr.viewing import View
from hsr.visibility import BACKGROUND, Admissible


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
    curved = round_tables(problem.rounds, problem.frame.nearer)
    found = candidates(problem.tables, curved, view.height, view.width)
    owner, unsettled = settled_by_filter(found)
    verdicts = list(settle(problem, found, unsettled))
    for verdict in verdicts:
        owners = np.array([piece for piece, _ in verdict.answers], dtype=np.int32)
        owner[verdict.sample] = owners[verdict.answer]
    others = [*(this.piece.face for this in problem.rounds), BACKGROUND]
    face = np.concatenate([problem.triangles.face, np.array(others, dtype=np.int32)])[owner]
    shape = (view.height, view.width)
    depth = depths_of(problem, owner)
    return Truth(face.reshape(shape), depth.reshape(shape), admissible_of(verdicts), len(unsettled))


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
        entry, which = entries(start, verdict.answer[tied])
        parts.append(np.stack([verdict.sample[tied][which], listed[entry]]))
    sample, face = np.concatenate(parts, axis=1)
    order = np.argsort(sample, kind="stable")
    first = firsts(sample[order])
    return Admissible(sample[order][first], np.append(first, len(face)), face[order].astype(np.int32))
