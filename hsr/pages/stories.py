"""The histories of samples of a scene at which methods differ: those that a page leads to, and some more."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, zip_longest
from typing import NamedTuple

import numpy as np

from hsr.base.arrays import Ints
from hsr.base.errors import MapError, ViewError
from hsr.difference.cause import Causes, causes
from hsr.difference.classes import OTHER_OWNER, Difference, SampleClass
from hsr.difference.history import Historian, History
from hsr.difference.study import Study
from hsr.difference.telling import Said
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View

HISTORIES = 60
"""How many samples of a scene have their history in the page unless more are asked for."""

CLUSTERS = 200
"""How many clusters of a method can be walked through."""

LISTED = 10
"""How many of them a page lists: their first samples have a history, however few are asked for."""

AT_ONCE = 500
"""How many histories are told together."""

DIFFERING = (*OTHER_OWNER, SampleClass.TIE)
"""The classes whose samples have a story: another face is shown."""


class Shown(NamedTuple):
    """What the inspector can show besides a study: maps, whoever made them, of a view that may be unknown.

    Attributes
    ----------
    name : str
    view : View or None
        What the maps show; without it there are no edges, no overlays and no histories.
    maps : mapping of str to VisibilityMap
        One at least, by the name under which the page speaks of them.
    reference : str or None
        The one the others are judged against.
    differences : mapping of str to Difference
        Of the others from it.
    causes : mapping of str to Causes
        As far as they are known.
    beside : VisibilityMap or None
        What was expected, if it has another size and can only be looked at.
    command : str
        The command that tells the history of a sample, with X,Y in its place; empty if there is none.
    """

    name: str
    view: View | None
    maps: Mapping[str, VisibilityMap]
    reference: str | None
    differences: Mapping[str, Difference]
    causes: Mapping[str, Causes]
    beside: VisibilityMap | None = None
    command: str = ""


class Stories(NamedTuple):
    """What is told of samples.

    Attributes
    ----------
    lines : dict of int to list of (str, Said)
        The history of each by its number, ascending; see :meth:`hsr.difference.history.History.lines`.
    faces : (n,) int32
        Those met in histories, ascending.
    wanted : int
        How many samples differ, for some method, or lie beside one that does.
    obstacle : str
        What keeps histories from being told at all.
    """

    lines: dict[int, list[tuple[str, Said]]]
    faces: Ints
    wanted: int
    obstacle: str


def stories(study: Study | Shown, most: int | None, linked: Sequence[tuple[int, int]]) -> Stories:
    """Tell the histories of samples at which methods differ; see :func:`hsr.pages.inspector.inspection`."""
    samples, wanted = _order(study, most, linked)
    lines: dict[int, list[tuple[str, Said]]] = {}
    faces: set[int] = set()
    try:
        for told in _histories(study, samples):
            lines[told.row * told.size[0] + told.column] = list(told.lines())
            faces |= {entry.layer.face for entry in told.entries}
    except (ViewError, MapError) as error:  # no exact answer, or maps of another scene
        return Stories({}, np.zeros(0, np.int32), wanted, str(error))
    return Stories(dict(sorted(lines.items())), np.array(sorted(faces), dtype=np.int32), wanted, "")


def _histories(study: Study | Shown, samples: Sequence[int]) -> Iterator[History]:
    if study.view is None:
        raise MapError("nothing says which scene the maps show")
    causes_of = study.causes or _causes(study.view, study.maps)
    known = {study.maps[name].method: why for name, why in causes_of.items()}
    for first in range(0, len(samples), AT_ONCE):
        some = samples[first : first + AT_ONCE]
        yield from map(Historian(study.view, some, list(study.maps.values()), known).tell, some)


def _causes(view: View, maps: Mapping[str, VisibilityMap]) -> dict[str, Causes]:
    """Find the causes in whole maps, where a map that knows the truth is no reference but there."""
    truth = next((map for map in maps.values() if map.admissible is not None), None)
    if truth is None:
        return {}
    return {name: causes(view, map, truth) for name, map in maps.items() if map is not truth}


def _order(
    study: Study | Shown, most: int | None, linked: Sequence[tuple[int, int]]
) -> tuple[list[int], int]:
    """Choose the samples whose history is told.

    Those that are linked to come first. Then the methods take turns, each with the first samples of its
    clusters, the largest first. What touches these follows, then others, spread over the image.

    Returns
    -------
    samples : list of int
        As many as are asked for, but all those that the page links to.
    wanted : int
        How many samples differ, for some method, or lie beside one that does.
    """
    from skimage.morphology import dilation

    differences = study.differences.values()
    height, width = next(iter(study.maps.values())).face.shape
    if all(found.same for found in differences):
        linked = linked or [(height // 2, width // 2)]  # where the inspector opens
    differs = np.zeros((height, width), dtype=np.bool_)
    for difference in differences:
        differs |= np.isin(difference.classes, DIFFERING)
    turns = chain.from_iterable(zip_longest(*(found.clusters[:CLUSTERS] for found in differences)))
    first = [*linked, *(cluster.sample for cluster in turns if cluster is not None)]
    least = len(linked) + sum(len(found.clusters[:LISTED]) for found in differences)
    ring = np.zeros_like(differs)
    if first:
        ring[tuple(np.transpose(first))] = True
    around, wanted = (np.flatnonzero(dilation(mask, np.ones((3, 3)))) for mask in (ring, differs))
    most = max(least, len(wanted) if most is None else most)
    spread = wanted[np.linspace(0, len(wanted) - 1, min(len(wanted), most)).astype(np.int64)]
    numbers = [row * width + column for row, column in first]
    return list(dict.fromkeys([*numbers, *around.tolist(), *spread.tolist()]))[:most], len(wanted)
