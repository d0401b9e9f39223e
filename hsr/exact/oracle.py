"""The truth about a view: the owner of every sample, and everyone who might own it.

Everything here is decided on the numbers of the view as they stand, without rounding: float64
proves what it can, integers and polynomials decide the rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr.arrays import Array, Floats, Ints
from hsr.exact.depths import depths_of
from hsr.exact.filter import Candidates, candidates, round_tables, triangle_tables
from hsr.exact.numbers import Frame, frame_of, samples
from hsr.exact.planes import triangles_of
from hsr.exact.quadrics import rounds_of
from hsr.exact.ties import Problem, Verdicts, settle
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


def problem_of(view: View) -> tuple[Frame, Problem]:
    """Set a view up in exact numbers."""
    frame = frame_of(view)
    triangles = triangles_of(view, frame)
    tables = triangle_tables(triangles, frame.nearer, view.width, view.height)
    rounds = rounds_of(view, frame, len(triangles))
    return frame, Problem(triangles, tables, rounds, frame.nearer, *samples(view))


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
    frame, problem = problem_of(view)
    tables = round_tables(problem.rounds, frame.nearer)
    found = candidates(problem.tables, tables, view.height, view.width)
    owner, unsettled = settled_by_filter(found)
    verdicts = list(settle(problem, found, unsettled))
    for verdict in verdicts:
        owners = np.array([piece for piece, _ in verdict.answers], dtype=np.int32)
        owner[verdict.sample] = owners[verdict.answer] if len(owners) else BACKGROUND
    curved = [this.piece.face for this in problem.rounds]
    face = np.concatenate([problem.triangles.face, np.array([*curved, BACKGROUND], dtype=np.int32)])[owner]
    shape = (view.height, view.width)
    depth = depths_of(frame, problem, owner)
    return Truth(face.reshape(shape), depth.reshape(shape), admissible_of(verdicts), len(unsettled))


def settled_by_filter(found: Candidates) -> tuple[Ints, Array]:
    """Return the piece (H W,) that owns each sample if certain, and the samples where it is not."""
    count = np.diff(found.start)
    owner = np.full(len(count), BACKGROUND, dtype=np.int32)
    single = np.flatnonzero(count == 1)
    owner[single] = found.piece[found.start[single]]
    settled = count == 0
    settled[single] = found.sure[found.start[single]]
    return owner, np.flatnonzero(~settled)


def admissible_of(verdicts: list[Verdicts]) -> Admissible:
    """Collect the tied samples."""
    samples_, lists = [np.zeros(0, np.int64)], [np.zeros((0, 2), np.int64)]
    for verdict in verdicts:
        size = np.array([len(faces) for _, faces in verdict.answers], dtype=np.int64)
        listed = np.array([face for _, faces in verdict.answers for face in sorted(faces)], dtype=np.int64)
        tied = np.flatnonzero(size[verdict.answer] > 1)
        count = size[verdict.answer[tied]]
        begin = (np.cumsum(size) - size)[verdict.answer[tied]]
        place = np.repeat(begin - (np.cumsum(count) - count), count) + np.arange(count.sum())
        samples_.append(verdict.sample[tied])
        lists.append(np.stack([np.repeat(verdict.sample[tied], count), listed[place]], axis=1))
    entries = np.concatenate(lists)
    entries = entries[np.argsort(entries[:, 0], kind="stable")]
    sample = np.sort(np.concatenate(samples_))
    start = np.searchsorted(entries[:, 0], np.append(sample, np.iinfo(np.int64).max))
    return Admissible(sample, start, entries[:, 1].astype(np.int32))
