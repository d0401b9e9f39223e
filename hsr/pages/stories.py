"""The histories of the samples of a scene at which methods differ, as many as a page has room for."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import zip_longest
from typing import Any, NamedTuple

import numpy as np

from hsr.base.arrays import Bools, Ints
from hsr.base.errors import MapError, ViewError
from hsr.difference.cause import Causes, causes
from hsr.difference.classes import OTHER_OWNER, Difference, SampleClass
from hsr.difference.history import Historian, History
from hsr.difference.study import Study
from hsr.pages.packing import digits
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View

STORIES = 5000
"""How many samples of a scene have their history in the page, at most: some seconds to tell."""

DIGITS = 2_500_000
"""How many digits the histories of a page may have, which take most of its bytes: 1 MB."""

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
    """

    name: str
    view: View | None
    maps: Mapping[str, VisibilityMap]
    reference: str | None
    differences: Mapping[str, Difference]
    causes: Mapping[str, Causes]
    beside: VisibilityMap | None = None


class Stories(NamedTuple):
    """What is told of samples.

    Attributes
    ----------
    parts : dict of int to JSON values
        The history of each by its number, ascending.
    faces : (n,) int32
        Those met in histories, ascending.
    wanted : int
        How many samples differ, for some method, or lie beside one that does.
    obstacle : str
        What keeps histories from being told at all.
    """

    parts: dict[int, Any]
    faces: Ints
    wanted: int
    obstacle: str


def stories(study: Study | Shown, most: int) -> Stories:
    """Tell the histories of samples at which methods differ, as long as there are digits left."""
    samples, wanted = _order(study.differences.values())
    parts: dict[int, Any] = {}
    faces: set[int] = set()
    try:
        for told in _histories(study, samples):
            sample = told.row * told.size[0] + told.column
            parts[sample] = told.parts()
            faces |= {entry.layer.face for entry in told.entries}
            most -= digits(parts[sample])
            if most <= 0:
                break
    except (ViewError, MapError) as error:  # no exact answer, or maps of another scene
        return Stories({}, np.zeros(0, np.int32), wanted, str(error))
    return Stories(dict(sorted(parts.items())), np.array(sorted(faces), dtype=np.int32), wanted, "")


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


def _order(differences: Collection[Difference]) -> tuple[list[int], int]:
    """Choose the samples whose history is told.

    The methods take turns: each names its clusters, the largest first, then its other samples, spread over
    the image. Their neighbours come last.

    Returns
    -------
    samples : list of int
        STORIES at most.
    wanted : int
        How many samples differ, for some method, or lie beside one that does.
    """
    from skimage.morphology import dilation

    if not differences:
        return [], 0
    differs = [np.isin(difference.classes, DIFFERING) for difference in differences]
    turns = zip_longest(*map(_spread, differences, differs))
    named = [sample for turn in turns for sample in turn if sample is not None]
    wanted = dilation(np.logical_or.reduce(differs), np.ones((3, 3)))
    samples = dict.fromkeys([*named, *np.flatnonzero(wanted)[:STORIES].tolist()])
    return list(samples)[:STORIES], int(np.count_nonzero(wanted))


def _spread(difference: Difference, differs: Bools) -> list[int]:
    """Return the first sample of each cluster, then others spread over the image."""
    first = [row * difference.a.width + column for row, column in (c.sample for c in difference.clusters)]
    samples = np.flatnonzero(differs)
    spread = np.linspace(0, len(samples) - 1, min(len(samples), STORIES)).astype(np.int64)
    return [*first[:STORIES], *samples[spread].tolist()]
