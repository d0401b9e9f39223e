"""The owner of a sample at which only triangles meet, by the directions in which it can be left.

Near a sample all is straight: the lines on which it lies part the directions into sectors, and within one the
same triangles are there. Those of the least depth at the sample are nearest; where several are, their planes
fall off differently, and the lower envelope of their slopes, which are linear between two directions, tells
which is nearest from where to where. No two triangles are compared that are not in one sector.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator, Sequence
from fractions import Fraction
from heapq import heappop, heappush
from itertools import pairwise
from typing import NamedTuple

from hsr.exact.decide import Answer, Direction, turn
from hsr.problem.map import BACKGROUND

AXES: tuple[Direction, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1))
"""They keep every sector below half a turn; the first parts what is to the right and above from below."""

Slope = tuple[Fraction, Fraction]


class Corner(NamedTuple):
    """A triangle at a sample.

    Attributes
    ----------
    number, face : int
    level : int
        How many lesser depths there are at the sample.
    slope : Slope
        What is added to its depth by a step (1, 0) and (0, 1); any quantity that grows with depth will do.
    edges : sequence of Direction
        Of the half-planes it is within whose line the sample lies on: not negative, a dx + b dy, inside.
    """

    number: int
    face: int
    level: int
    slope: Slope
    edges: Sequence[Direction]


def decide_flat(corners: Sequence[Corner]) -> Answer:
    """Decide one sample; see :func:`hsr.exact.decide.decide`, whose answer it is."""
    admissible: set[int] = set()
    limit: Collection[Corner] = ()
    for first, last, there in _sectors(corners):
        for limit in _envelope(there, first, last) if there else [()]:
            admissible.update(corner.face for corner in limit)
            if not limit:
                admissible.add(BACKGROUND)
    # The last sector ends at the right, and its last part is what lies just below that.
    owner = min(limit, key=lambda corner: corner.face).number if limit else BACKGROUND
    return owner, frozenset(admissible)


def _sectors(corners: Sequence[Corner]) -> Iterator[tuple[Direction, Direction, list[Corner]]]:
    """Yield the sectors about a sample, counter-clockwise from the right, and the nearest in each."""
    edges = {edge for corner in corners for edge in corner.edges}
    rays = {turn(ray): ray for ray in (*AXES, *((b, -a) for a, b in edges), *((-b, a) for a, b in edges))}
    angles = sorted(rays)
    place = {angle: k for k, angle in enumerate(angles)}
    begins, ends = defaultdict(list), defaultdict(list)
    for corner in corners:
        for start, end in _spans(corner, place):
            begins[start].append(corner)
            ends[end].append(corner)
    present: dict[int, dict[int, Corner]] = defaultdict(dict)
    levels: list[int] = []
    for k, (first, last) in enumerate(pairwise([*angles, angles[0]])):
        for corner in ends[k]:
            del present[corner.level][corner.number]
        for corner in begins[k]:
            present[corner.level][corner.number] = corner
            heappush(levels, corner.level)
        while levels and not present[levels[0]]:
            heappop(levels)
        yield rays[first], rays[last], list(present[levels[0]].values()) if levels else []


def _spans(corner: Corner, place: dict[Fraction, int]) -> list[tuple[int, int]]:
    """Return the runs of sectors within all half-planes of a triangle, at most two as they are numbered."""
    spans = [(0, len(place))]
    for a, b in corner.edges:
        # Inside lies to the left of the ray (b, -a).
        start, end = place[turn((b, -a))], place[turn((-b, a))]
        inside = [(start, end)] if start < end else [(0, end), (start, len(place))]
        met = [(max(s, t), min(e, f)) for s, e in spans for t, f in inside]
        spans = [(s, e) for s, e in met if s < e]
    return spans


def _envelope(there: Sequence[Corner], first: Direction, last: Direction) -> Iterator[list[Corner]]:
    """Yield which are nearest from one direction to another, as often as that changes."""
    by_slope: dict[Slope, list[Corner]] = defaultdict(list)
    for corner in there:
        by_slope[corner.slope].append(corner)
    fall = {slope: (_along(slope, first), _along(slope, last)) for slope in by_slope}
    slope = min(fall, key=lambda one: fall[one])
    while True:
        yield by_slope[slope]
        begin, end = fall[slope]
        # What ends lower crosses it: how much later, by how far it begins above and ends below.
        later = {one: (a - begin) / (end - b) for one, (a, b) in fall.items() if b < end}
        if not later:
            return
        slope = min(later, key=lambda one: (later[one], fall[one][1]))


def _along(slope: Slope, direction: Direction) -> Fraction:
    return slope[0] * direction[0] + slope[1] * direction[1]
