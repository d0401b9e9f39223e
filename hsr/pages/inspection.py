"""All that the inspector knows of one scene: what is shown at every sample, and the stories of some.

Most methods agree at most samples. So the map of one of them, the *base*, is kept whole, and of every other
only the samples of another class than *same*: where it shows another face, or a depth further from the base's
than rounding explains. Elsewhere its depths are given as those of the base.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import zip_longest
from typing import Any, NamedTuple

import numpy as np
from scipy import ndimage

from hsr.base.arrays import Array, Floats, Ints
from hsr.base.errors import MapError, ViewError
from hsr.difference.cause import Causes, causes
from hsr.difference.classes import OTHER_OWNER, Difference, SampleClass
from hsr.difference.history import MISSED, Historian, History
from hsr.difference.study import Study
from hsr.models.stages import Cause
from hsr.pages.outlines import outlines
from hsr.pages.overlays import SMALLEST, Drawn
from hsr.pages.packing import digits, pack, pack_alike, pack_json
from hsr.pages.pictures import CAUSE_COLOURS, CLASS_COLOURS
from hsr.pages.shading import depth_span, face_colours, facing
from hsr.problem.map import BACKGROUND, VisibilityMap
from hsr.problem.view import View

STORIES = 5000
"""How many samples of a scene have their history in the page, at most: some seconds to tell."""

DIGITS = 2_500_000
"""How many digits the histories of a page may have, which take most of its bytes: 1 MB."""

AT_ONCE = 500
"""How many histories are told together."""

CLUSTERS = 200
"""How many clusters of a method can be walked through."""

FARTHEST, EMPTY = 2**14 - 2, 2**14 - 1
"""Levels in which depths are kept for pictures: from 0 at the nearest to FARTHEST; EMPTY is no depth."""

CLASS_LETTERS = " MEWDT"
CAUSE_LETTERS = " TIRCSFADVNO?"
"""What is written on samples zoomed in on, by class and by cause: colour is not all that tells them apart."""


def key() -> dict[str, Any]:
    """Return what the inspector's signs mean, the same for all scenes, as JSON values.

    Returns
    -------
    dict
        ``classes`` and ``causes`` by number, each with ``label``, ``letter`` and ``colour``, None for 0;
        ``facing``: colours of front and back; ``ramp``: colours of complexity and size, from the least
        up; ``farthest`` and ``empty``: levels of depth; ``smallest``: the power of two of size 0;
        ``missed``: the words above faces beside the sample.
    """
    from matplotlib import colormaps  # only pages need it, and it takes long to load

    return {
        "classes": [None, *(_sign(kind, CLASS_LETTERS, CLASS_COLOURS[kind]) for kind in CLASS_COLOURS)],
        "causes": [None, *(_sign(cause, CAUSE_LETTERS, CAUSE_COLOURS[cause]) for cause in CAUSE_COLOURS)],
        "facing": [(86, 140, 220), (214, 96, 40)],
        "ramp": np.rint(255 * colormaps["viridis"](np.linspace(0, 1, 64))[:, :3]).astype(int).tolist(),
        "farthest": FARTHEST,
        "empty": EMPTY,
        "smallest": SMALLEST,
        "missed": MISSED,
    }


def _sign(kind: SampleClass | Cause, letters: str, colour: tuple[int, int, int]) -> dict[str, Any]:
    return {"label": kind.label, "letter": letters[kind], "colour": colour}


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
    """

    name: str
    view: View | None
    maps: Mapping[str, VisibilityMap]
    reference: str | None
    differences: Mapping[str, Difference]
    causes: Mapping[str, Causes]


def inspection(study: Study | Shown, most: int = DIGITS) -> dict[str, Any]:
    """Gather what the inspector shows of a study.

    Parameters
    ----------
    study : Study or Shown
        With one map at least.
    most : int
        How many digits the histories may have; no more are told then.

    Returns
    -------
    dict
        JSON values, arrays packed by :func:`hsr.pages.packing.pack`:

        * ``name``, ``size`` (width, height); ``drawn``: whether the view is known, and with it what is
          below called ``sizes``, ``facing``, ``complexity``, ``edges`` and ``hidden``;
        * ``base``: place among the methods of the one whose map is whole, the reference if there is one;
          ``judged``: whether there is;
        * ``names`` (n,), deflated JSON, and ``colours`` (n, 3) of the faces that some method shows,
          ascending, the background first: what ``index`` counts; ``sizes`` (n - 1,) of all but the
          background, see :meth:`Drawn.sizes`;
        * ``index`` (H, W) and ``depth`` (H, W): what the base shows; depth in levels of ``span``, the
          nearest and the farthest depth;
        * ``facing`` (1 front, 2 back) and ``complexity`` (H, W) of the base;
        * ``edges`` of the faces that the base shows, and ``hidden`` of others in a history: ``points`` and
          ``ends``, see :func:`outlines`;
        * ``methods``: ``name``; ``differs``, a bit a sample in reading order, and of the samples (k,) that
          differ from the base how much more ``index`` and ``depth`` are than those of the base, class
          and cause; ``clusters``, each its first row and column, then its box;
        * ``told``: the numbers of samples (k,), ascending, whose history is told; ``stories``: the parts
          of each, packed by :func:`hsr.pages.packing.pack_alike`; ``wanted``: how many samples differ or
          lie beside one that does; ``untold``: what keeps histories from being told at all.
    """
    base = _Whole(study)
    chosen, wanted = _order(study, STORIES)
    stories = _stories(study, chosen, most)
    return {
        "name": study.name,
        "size": [base.map.width, base.map.height],
        "drawn": study.view is not None,
        "base": list(study.maps).index(base.name),
        "judged": study.reference is not None,
        "names": pack_json([base.map.name_of(face) for face in base.faces.tolist()]),
        "colours": pack(face_colours(base.faces)),
        "index": pack(base.index, 0),
        "span": base.span,
        "depth": pack(base.depth, 1, 0),
        **_drawing(study.view, base, stories.faces),
        "methods": [_method(study, name, map, base) for name, map in study.maps.items()],
        "told": pack(np.array(sorted(stories.parts), dtype=np.uint32), 0),
        "stories": pack_alike(stories.parts[sample] for sample in sorted(stories.parts)),
        "wanted": wanted,
        "untold": stories.obstacle,
    }


class _Whole:
    """The base of a study, and how faces and depths are counted for the page.

    Attributes
    ----------
    name : str
    map : VisibilityMap
    faces : (n,) int32
        Those that some method shows, ascending, the background first.
    span : (nearest, farthest)
    index, depth : (H, W)
        Place among ``faces``, and level in ``span``.
    """

    def __init__(self, study: Study | Shown) -> None:
        self.name = study.reference or next(iter(study.maps))
        self.map = study.maps[self.name]
        shown = [np.unique(map.face) for map in study.maps.values()]
        self.faces = np.unique(np.concatenate([[BACKGROUND], *shown])).astype(np.int32)
        self.span = depth_span(self.map)
        index, depth = self.of(self.map, np.arange(self.map.face.size))
        self.index, self.depth = index.reshape(self.map.face.shape), depth.reshape(self.map.face.shape)

    def of(self, map: VisibilityMap, samples: Array) -> tuple[Array, Array]:
        """Return index and depth of the numbered samples (k,) of a map."""
        index = np.searchsorted(self.faces, map.face.ravel()[samples])
        narrow = np.uint16 if len(self.faces) <= 2**16 else np.uint32
        return index.astype(narrow), _levels(map.depth.ravel()[samples], self.span)


def _levels(depth: Floats, span: tuple[float, float]) -> Array:
    """Share out the depths between the nearest and the farthest over the levels."""
    nearest, farthest = span
    extent = max(farthest - nearest, np.finfo(np.float64).tiny)
    seen = np.isfinite(depth)
    share = np.clip((np.where(seen, depth, nearest) - nearest) / extent, 0.0, 1.0)
    return np.where(seen, np.rint(FARTHEST * share), EMPTY).astype(np.uint16)


def _drawing(view: View | None, base: _Whole, told: Ints) -> dict[str, Any]:
    """Gather what only the view tells: overlays, edges of the faces that are shown, and of others told of."""
    if view is None:
        return {}
    drawn = Drawn(view)
    seen = np.unique(base.map.face[base.map.face != BACKGROUND])
    return {
        "sizes": pack(drawn.sizes(base.faces[1:])),
        "facing": pack((facing(base.map, view) % 3).astype(np.uint8)),
        "complexity": pack(drawn.complexity()),
        "edges": _edges(view, seen),
        "hidden": _edges(view, np.setdiff1d(told, seen)),
    }


def _edges(view: View, faces: Ints) -> dict[str, Any]:
    points, ends = outlines(view, faces)
    return {"points": pack(points), "ends": pack(ends, 0)}


def _method(study: Study | Shown, name: str, map: VisibilityMap, base: _Whole) -> dict[str, Any]:
    """Gather what one method shows differently."""
    difference, why = study.differences.get(name), study.causes.get(name)
    none = np.zeros(map.face.shape, dtype=np.uint8)
    classes = none if difference is None else difference.classes
    differs = (map.face != base.map.face) | (classes > SampleClass.SAME)
    samples = np.flatnonzero(differs)
    index, depth = base.of(map, samples)
    clusters = () if difference is None else difference.clusters[:CLUSTERS]
    return {
        "name": name,
        "differs": pack(np.packbits(differs)),
        "index": pack(index - base.index.ravel()[samples]),
        "depth": pack(depth - base.depth.ravel()[samples]),
        "classes": pack(classes.ravel()[samples]),
        "causes": pack((none if why is None else why.cause).ravel()[samples]),
        "clusters": [[*cluster.sample, *cluster.box] for cluster in clusters],
    }


# ---------------------------------------------------------------- histories


class Stories(NamedTuple):
    """Histories by number of their sample, the faces in them, and what keeps them from being told."""

    parts: dict[int, Any]
    faces: Ints
    obstacle: str


def _stories(study: Study | Shown, samples: Array, most: int) -> Stories:
    """Tell the histories of samples in their order, as long as there are digits left."""
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
        return Stories({}, np.zeros(0, np.int32), str(error))
    return Stories(parts, np.array(sorted(faces), dtype=np.int32), "")


def _histories(study: Study | Shown, samples: Array) -> Iterator[History]:
    if study.view is None:
        raise MapError("nothing says which scene the maps show")
    causes_of = study.causes or _causes(study.view, study.maps)
    known = {study.maps[name].method: why for name, why in causes_of.items()}
    for first in range(0, len(samples), AT_ONCE):
        some = samples[first : first + AT_ONCE].tolist()
        yield from map(Historian(study.view, some, list(study.maps.values()), known).tell, some)


def _causes(view: View, maps: Mapping[str, VisibilityMap]) -> dict[str, Causes]:
    """Find the causes in whole maps, where a map that knows the truth is no reference but there."""
    truth = next((map for map in maps.values() if map.admissible is not None), None)
    if truth is None:
        return {}
    return {name: causes(view, map, truth) for name, map in maps.items() if map is not truth}


DIFFERING = (*OTHER_OWNER, SampleClass.TIE)
"""The classes whose samples have a story: another face is shown."""


def _order(study: Study | Shown, most: int) -> tuple[Array, int]:
    """Choose the samples whose history is told.

    The methods take turns: each names its clusters, the largest first, then its other samples, spread over
    the image. Their neighbours come last.

    Returns
    -------
    samples : (n,) int64
        As many as asked for, at most.
    wanted : int
        How many samples differ, for some method, or lie beside one that does.
    """
    if not study.differences:
        return np.zeros(0, dtype=np.int64), 0
    differs = [np.isin(difference.classes, DIFFERING) for difference in study.differences.values()]
    turns = zip_longest(*(_spread(difference, most) for difference in study.differences.values()))
    named = [sample for turn in turns for sample in turn if sample is not None]
    wanted = ndimage.binary_dilation(np.logical_or.reduce(differs, axis=0), np.ones((3, 3)))
    samples = dict.fromkeys([*named, *np.flatnonzero(wanted)[:most].tolist()])
    return np.array(list(samples)[:most], dtype=np.int64), int(np.count_nonzero(wanted))


def _spread(difference: Difference, most: int) -> list[int]:
    """Return the first sample of each cluster, then others spread over the image, so many of both at most."""
    width = difference.a.width
    first = [row * width + column for row, column in (c.sample for c in difference.clusters[:most])]
    samples = np.flatnonzero(np.isin(difference.classes, DIFFERING))
    spread = np.linspace(0, len(samples) - 1, min(len(samples), most)).astype(np.int64)
    return [*first, *samples[spread].tolist()]
