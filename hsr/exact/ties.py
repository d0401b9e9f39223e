"""The samples float64 cannot settle, decided exactly: many at a time, where many are alike.

What meets at a sample in planes is the same for whole families of samples: all those on one edge,
all those on which two coplanar faces lie. The *situation* of a sample says all that its owner
depends on: which triangles contain it, on which of their edges it lies, and in what order of depth
they come. Each situation is decided once.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints, ranges
from hsr.exact.decide import Answer, decide
from hsr.exact.filter import Candidates
from hsr.exact.planes import HALVES
from hsr.exact.problem import Problem
from hsr.exact.sectors import Corner, decide_flat

CHUNK = 1 << 17
"""Candidates whose integers are held at a time."""

LEVEL_BITS = 26
"""Bits for a depth level in a code, beside 31 for the triangle and one for each half-plane."""


class Verdicts(NamedTuple):
    """Samples, each with one of a list of answers.

    Attributes
    ----------
    sample, answer : (n,) int64
    answers : list of Answer
    """

    sample: Array
    answer: Array
    answers: list[Answer]


def settle(problem: Problem, found: Candidates, unsettled: Array) -> Iterator[Verdicts]:
    """Decide samples exactly; of those that turn out to show the background nothing is said.

    Parameters
    ----------
    problem : Problem
    found : Candidates
    unsettled : (n,) int64
        The samples to decide, ascending.
    """
    which, entry = ranges(found.start[unsettled], found.start[unsettled + 1])
    sample, piece, sure = unsettled[which], found.piece[entry], found.sure[entry]
    curved = np.zeros(len(found.start) - 1, dtype=np.bool_)
    curved[sample[piece >= len(problem.triangles)]] = True
    flat = ~curved[sample]
    if flat.any():
        yield from _settle_flat(problem, sample[flat], piece[flat], sure[flat])
    if not flat.all():
        yield _settle_curved(problem, sample[~flat], piece[~flat], sure[~flat])


def firsts(sample: Array) -> Array:
    """Return where in a list ordered by sample each sample begins."""
    return np.flatnonzero(np.diff(sample, prepend=-1))


# ---------------------------------------------------------------- curved: one by one


def _settle_curved(problem: Problem, sample: Array, piece: Ints, sure: Bools) -> Verdicts:
    """Decide each sample by itself; but where all pieces coincide, one speaks for all with the same."""
    pieces = {number: problem.piece(number) for number in np.unique(piece).tolist()}
    first = firsts(sample)
    lists = zip(np.split(piece, first[1:]), np.split(sure, first[1:]), strict=True)
    known: dict[tuple[int, ...], int] = {}
    answers: list[Answer] = []
    which = []
    for (numbers, certain), i, j in zip(lists, *problem.frame.exactly_at(sample[first]), strict=True):
        present = [pieces[number] for number in numbers.tolist()]
        alike = bool(certain.all()) and len({piece.surface for piece in present}) == 1
        name = tuple(numbers.tolist()) if alike else (-1, i, j)
        if name not in known:
            known[name] = len(answers)
            answers.append(decide(present, i, j, problem.frame.nearer))
        which.append(known[name])
    return Verdicts(sample[first], np.array(which, dtype=np.int64), answers)


# ---------------------------------------------------------------- planar: by situation


def _settle_flat(problem: Problem, sample: Array, piece: Ints, sure: Bools) -> Iterator[Verdicts]:
    """Decide samples where only triangles meet; one entry a candidate."""
    edges, inside = _edges_met(problem, sample, piece, sure)
    sample, piece, edges = sample[inside], piece[inside], edges[inside]
    if not len(sample):
        return
    order, level = _by_depth(problem, sample, piece)
    sample, piece, edges = sample[order], piece[order], edges[order]
    seen = _down_to_full(sample, level, edges == 0)
    code = level | edges.astype(np.int64) << LEVEL_BITS | piece.astype(np.int64) << LEVEL_BITS + HALVES
    order = np.lexsort((code[seen], level[seen], sample[seen]))
    yield from _by_situation(problem, sample[seen][order], code[seen][order])


def _edges_met(problem: Problem, sample: Array, piece: Ints, sure: Bools) -> tuple[Ints, Bools]:
    """Return on which lines each candidate has its sample, as bits, and whether it contains it."""
    edges = np.zeros(len(sample), dtype=np.int32)
    inside = np.ones(len(sample), dtype=np.bool_)
    unsure = np.flatnonzero(~sure)
    for first in range(0, len(unsure), CHUNK):
        some = unsure[first : first + CHUNK]
        i, j = (ends[:, None] for ends in problem.frame.exactly_at(sample[some]))
        half = problem.triangles.half[piece[some]]
        value = half[:, :, 0] * i + half[:, :, 1] * j + half[:, :, 2]
        edges[some] = (value == 0) @ (1 << np.arange(HALVES))
        inside[some] = (value >= 0).all(axis=1)
    return edges, inside


def _by_depth(problem: Problem, sample: Array, piece: Ints) -> tuple[Array, Array]:
    """Sort the candidates of every sample by depth.

    Returns
    -------
    order : (n,) int64
        Candidates in order of sample, then depth.
    level : (n,) int64
        How many lesser depths the sample has, in that order.
    """
    plane = _planes(problem, piece)
    order = np.lexsort((_key(problem, sample, piece), sample))
    while True:
        step = _steps(problem, sample[order], piece[order], plane[order])
        wrong = np.flatnonzero(step < 0)
        if not len(wrong):
            break
        # Float64 sorts all but neighbours within rounding: exchange those, no two pairs that touch.
        wrong = wrong[np.diff(wrong, prepend=-2) > 1]
        order[wrong], order[wrong + 1] = order[wrong + 1], order[wrong]
    deeper = np.cumsum(np.concatenate([[0], step])[: len(order)])
    first = firsts(sample[order])
    return order, deeper - np.repeat(deeper[first], np.diff(first, append=len(order)))


def _planes(problem: Problem, piece: Ints) -> Array:
    """Give triangles the same number exactly if they lie in the same plane."""
    triangles, which = np.unique(piece, return_inverse=True)
    numbers: dict[tuple[int, ...], int] = {}
    plane = [numbers.setdefault(problem.triangles.plane(t), len(numbers)) for t in triangles]
    return np.array(plane, dtype=np.int64)[which]


def _key(problem: Problem, sample: Array, piece: Ints) -> Floats:
    i, j = problem.frame.at(sample)
    key = problem.tables.key[piece]
    return np.asarray(key[:, 0] * i + key[:, 1] * j + key[:, 2])


def _steps(problem: Problem, sample: Array, piece: Ints, plane: Array) -> Array:
    """Compare each candidate with the next (n - 1,): 1 if that is deeper, 0 if equally deep, else -1.

    Candidates of different samples count as in order.
    """
    gap = np.diff(_key(problem, sample, piece))
    slack = problem.tables.key_slack[piece]
    bound = slack[:-1] + slack[1:]
    step = np.where(gap > bound, 1, np.where(gap < -bound, -1, 0))
    step[np.diff(sample) != 0] = 1
    close = np.flatnonzero((step == 0) & (np.diff(plane) != 0))
    for first in range(0, len(close), CHUNK):
        some = close[first : first + CHUNK]
        step[some] = _compared(problem, sample[some], piece[some], piece[some + 1])
    return step


def _compared(problem: Problem, sample: Array, one: Ints, other: Ints) -> Array:
    """Compare the depths of two triangles' planes exactly."""
    zeta, det = problem.triangles.zeta, problem.triangles.det
    i, j = problem.frame.exactly_at(sample)
    of_one, of_other = (zeta[t, 0] * i + zeta[t, 1] * j + zeta[t, 2] for t in (one, other))
    further = (of_one * det[other] - of_other * det[one]) * problem.frame.nearer
    return np.asarray((further > 0).astype(np.int64) - (further < 0))


def _down_to_full(sample: Array, level: Array, full: Bools) -> Bools:
    """Keep what lies no deeper than the first triangle that covers a sample's neighbourhood."""
    first = firsts(sample)
    floor = np.minimum.reduceat(np.where(full, level, len(level)), first)
    return np.asarray(level <= np.repeat(floor, np.diff(first, append=len(sample))))


def _by_situation(problem: Problem, sample: Array, code: Array) -> Iterator[Verdicts]:
    """Decide each situation once: the sequence of codes of a sample's candidates."""
    first = firsts(sample)
    count = np.diff(first, append=len(sample))
    for length in np.flatnonzero(np.bincount(count)):
        these = first[count == length]
        rows = code[these[:, None] + np.arange(length)]
        situations, which = np.unique(rows, axis=0, return_inverse=True)
        answers = [_decide_situation(problem, situation) for situation in situations]
        yield Verdicts(sample[these], which, answers)


def _decide_situation(problem: Problem, situation: Array) -> Answer:
    """Decide what is alike at all its samples: only half-planes that are met there bound what is near by."""
    triangles, corners = problem.triangles, []
    for code in situation.tolist():
        number, edges = code >> LEVEL_BITS + HALVES, code >> LEVEL_BITS & (1 << HALVES) - 1
        (a, b, _), det = triangles.zeta[number], triangles.det[number] * -problem.frame.nearer
        met = [(a, b) for k, (a, b, _) in enumerate(triangles.half[number]) if edges >> k & 1 and (a or b)]
        slope, level = (Fraction(a, det), Fraction(b, det)), code & (1 << LEVEL_BITS) - 1
        corners.append(Corner(number, int(triangles.face[number]), level, slope, met))
    return decide_flat(corners)
