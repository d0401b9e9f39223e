"""The truth about a view: the owner of every sample, and everyone who might own it.

Everything here is decided on the numbers of the view as they stand, without rounding: float64
proves what it can, integers and polynomials decide the rest.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from hsr.base.arrays import Array, Ints, ranges
from hsr.exact.decide import Answer
from hsr.exact.depths import depths_of
from hsr.exact.filter import Candidates, candidates, round_tables
from hsr.exact.problem import Problem, problem_of
from hsr.exact.ties import Verdicts, firsts, settle
from hsr.problem.map import BACKGROUND, Admissible, VisibilityMap
from hsr.problem.view import View


def truth(view: View) -> VisibilityMap:
    """Decide every sample of a view exactly.

    Parameters
    ----------
    view : View

    Returns
    -------
    VisibilityMap
        Work: ``uncertain``, the samples that float64 could not settle; ``ties``, those with more than one
        admissible owner.

    Raises
    ------
    ViewError
        If the camera is singular, or its depth does not grow along its lines of sight.
    """
    shape = (view.height, view.width)
    problem, owner, face, ties, uncertain = _decided(view, np.arange(view.height * view.width))
    depth, work = depths_of(problem, owner).reshape(shape), {"uncertain": uncertain, "ties": len(ties.sample)}
    return VisibilityMap(face.reshape(shape), depth, "exact", work, admissible=ties)


def owners(view: View, samples: Array) -> Ints:
    """Decide some samples of a view exactly, as :func:`truth` does all, and return their faces (n,) int32.

    Parameters
    ----------
    view : View
    samples : (n,) int64
        Numbers ``row * W + column``.
    """
    return _decided(view, np.unique(samples))[2][samples]


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
    _, _, face, ties, _ = _decided(view, samples)
    shown = zip(samples.tolist(), face[samples].tolist(), strict=True)
    return {sample: (owner, ties.faces(sample) or frozenset([owner])) for sample, owner in shown}


def _decided(view: View, samples: Array) -> tuple[Problem, Ints, Ints, Admissible, int]:
    """Decide some samples: the piece (H W,) and the face of each, their ties, and how many were uncertain."""
    problem = problem_of(view, samples)
    curved = round_tables(problem.rounds, problem.frame.nearer)
    found = candidates(problem.tables, curved, view.height, view.width)
    owner, unsettled = settled_by_filter(found)
    unsettled = np.intersect1d(unsettled, samples, assume_unique=True)
    verdicts = list(settle(problem, found, unsettled))
    for verdict in verdicts:
        owners = np.array([piece for piece, _ in verdict.answers], dtype=np.int32)
        owner[verdict.sample] = owners[verdict.answer]
    # Piece -1, the last one, is the background.
    others = [*(piece.face for piece in problem.rounds), BACKGROUND]
    face = np.concatenate([problem.triangles.face, np.array(others, dtype=np.int32)])[owner]
    return problem, owner, face, admissible_of(verdicts), len(unsettled)


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
