"""All that the inspector knows of one scene: what is shown at every sample, and the stories of some.

Most methods agree at most samples. So the map of one of them, the *base*, is kept whole, and every other as
it differs from the one before it that it is most like. Where its class is *same*, its depths are within
rounding of the base's, and given as those.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any
from urllib.parse import urlencode

import numpy as np

from hsr.base.arrays import Array, Ints
from hsr.difference.classes import SampleClass
from hsr.difference.history import MISSED
from hsr.difference.study import Study
from hsr.pages.outlines import outlines
from hsr.pages.overlays import SMALLEST, Drawn
from hsr.pages.packing import pack, pack_json, pack_told
from hsr.pages.shading import facing
from hsr.pages.stories import CLUSTERS, HISTORIES, Shown, stories
from hsr.pictures.maps import depth_shares, depth_span
from hsr.pictures.palette import CAUSE_COLOURS, CLASS_COLOURS, NEUTRAL, PLASTIC, to_bytes
from hsr.problem.map import BACKGROUND, VisibilityMap
from hsr.problem.view import View

FARTHEST, EMPTY = 2**9 - 2, 2**9 - 1
"""Levels in which depths are kept for pictures: from 0 at the nearest to FARTHEST; EMPTY is no depth."""

FINE = 32
"""Steps of a pixel in which the ends of edges are kept."""

BAND = 8
"""Height in pixels of the bands in which they are listed."""

NEAR_ENOUGH = 2**24
"""Pixels from the corner of the image within which they are."""

CLASS_LETTERS = "MEWDT"
CAUSE_LETTERS = "TIRCSFADVNO?"
"""What is written on samples zoomed in on, by class and by cause: colour is not all that tells them apart."""

HELP = (
    ("1 … 9", "method by its number, on the right"),
    ("Shift+1 … Shift+9", "reference by its number, on the left"),
    ("j k", "next and previous method"),
    ("J K", "next and previous reference"),
    ("t", "two pictures side by side, zoomed together"),
    ("b", "blink; Space flips by hand"),
    ("s o", "swipe, onion skin; , and . move the share of the method"),
    ("i p z", "faces, shaded picture, depth"),
    ("m c", "class map, cause map"),
    ("Ctrl+← Ctrl+→", "the picture before, the next: faces, shaded, depth, classes, causes"),
    ("n", "stretch the greys of depth over what is in view, and back"),
    ("v", "next overlay: facing, depth complexity, face size, wireframe"),
    ("← ↑ → ↓", "move by one sample, with Shift by ten"),
    ("[ ]", "previous and next cluster of the method"),
    ("g", "go to a sample: column, row"),
    ("+ - f 0", "zoom in, out, fit, one pixel a sample"),
    ("y", "count rows from the bottom, as OpenGL does, or from the top"),
    ("? Escape", "this help; close"),
)
"""Keys of the inspector and what they do."""


def inspected(data: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return what ``inspector.html`` is given: scenes by :func:`inspection`, and what signs mean."""
    return {"help": HELP, "key": key() if data else None, "data": data}


def key() -> dict[str, Any]:
    """Return what the inspector's signs mean, the same for all scenes, as JSON values.

    Returns
    -------
    dict
        ``classes`` and ``causes`` by number, each with ``label``, ``letter`` and ``colour``, None for 0;
        ``facing``: colours of front and back; ``ramp``: colours of complexity and size, from the least
        up; ``farthest`` and ``empty``: levels of depth; ``smallest``: the power of two of size 0;
        ``missed``: the words above faces beside the sample; ``plastic`` and ``neutral``: what colours of
        faces are made of, see :func:`hsr.pictures.palette.face_colours`; ``fine``: steps of a pixel.
    """
    from matplotlib import colormaps  # only pages need it, and it takes long to load

    return {
        "classes": _signs(CLASS_COLOURS, CLASS_LETTERS),
        "causes": _signs(CAUSE_COLOURS, CAUSE_LETTERS),
        "facing": [(86, 140, 220), (214, 96, 40)],
        "ramp": to_bytes(colormaps["viridis"](np.linspace(0, 1, 64))[:, :3]).tolist(),
        "farthest": FARTHEST,
        "empty": EMPTY,
        "smallest": SMALLEST,
        "missed": MISSED,
        "plastic": PLASTIC,
        "neutral": NEUTRAL,
        "fine": FINE,
    }


def _signs(colours: Mapping[str, Any], letters: str) -> list[dict[str, Any] | None]:
    signs = zip(colours.items(), letters, strict=True)
    return [None, *({"label": label, "letter": letter, "colour": rgb} for (label, rgb), letter in signs)]


def fragment(scene: str, method: str, sample: tuple[int, int] | None = None) -> str:
    """Return the end of a report's address that opens the inspector at a sample.

    Parameters
    ----------
    scene : str
        The name of a study in the report.
    method : str
        What is shown beside the reference.
    sample : (row, column), optional
        Row 0 is the top row; without it the method's largest cluster is shown.

    Returns
    -------
    str
        ``#scene=teapot&method=opengl&x=311&y=204``: x is the column, y the row.
    """
    named = {"scene": scene, "method": method}
    if sample is not None:
        named |= {"x": str(sample[1]), "y": str(sample[0])}
    return f"#{urlencode(named, safe='/')}"


def inspection(
    study: Study | Shown, most: int | None = HISTORIES, linked: Sequence[tuple[int, int]] = ()
) -> dict[str, Any]:
    """Gather what the inspector shows of a study.

    Parameters
    ----------
    study : Study or Shown
        With one map at least.
    most : int or None
        How many samples have their history told, None for all that differ or lie beside one that does. The
        largest clusters of every method have theirs in any case.
    linked : sequence of (row, column)
        Other samples that have theirs in any case.

    Returns
    -------
    dict
        JSON values, arrays packed by :func:`hsr.pages.packing.pack`:

        * ``name``, ``size`` (width, height); ``drawn``: whether the view is known, and with it what is
          below called ``sizes``, ``facing``, ``complexity``, ``edges`` and ``hidden``;
        * ``base``: place among the methods of the one whose map is whole, the reference if there is one;
          ``judged``: whether there is;
        * ``faces`` (n,): the ids that some method shows, ascending, the background first: what ``index``
          counts; ``manifest``, deflated JSON: their names; ``sizes`` (n - 1,) of all but the background, see
          :meth:`Drawn.sizes`;
        * ``index`` (H, W) and ``depth`` (H, W): what the base shows; depth in levels of ``span``, the
          nearest and the farthest depth;
        * ``facing`` (1 front, 2 back) and ``complexity`` (H, W) of the base;
        * ``edges`` of the faces that the base shows, and ``hidden`` of others in a history: ``points`` (2, p)
          and ``ends`` (2, m), see :func:`outlines`, points in steps of ``1 / FINE`` pixel;
        * ``methods``: ``name``; ``like``: what comes before it that it is most like, 0 for the base, k for
          method k - 1; ``differs``, a bit a sample in reading order, and of the samples (k,) that differ
          from that, ``index``, ``depth``, ``classes`` and ``causes``; ``clusters``, deflated JSON: of each
          its first row and column, then its box;
        * ``told``: the numbers of samples (k,), ascending, whose history is told; ``stories``: the facts
          of each, packed by :func:`hsr.pages.packing.pack_told`; ``wanted``: how many samples differ or
          lie beside one that does; ``untold``: what keeps histories from being told at all; ``command``: what
          tells the history of any sample, with X,Y in its place.
    """
    base = _Whole(study)
    told = stories(study, most, linked)
    return {
        "name": study.name,
        "size": [base.map.width, base.map.height],
        "drawn": study.view is not None,
        "base": list(study.maps).index(base.name),
        "judged": study.reference is not None,
        "faces": pack(base.faces, 0),
        "manifest": pack_json(base.map.manifest),
        "index": pack(base.index, 0),
        "span": base.span,
        "depth": pack(base.depth, 1),
        **_drawing(study.view, base, told.faces),
        "methods": list(_methods(study, base)),
        "told": pack(np.array(list(told.lines), dtype=np.uint32), 0),
        "stories": pack_told(told.lines.values()),
        "wanted": told.wanted,
        "untold": told.obstacle,
        "command": study.command,
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
        self.span = depth_span(self.map.depth)
        self.index, self.depth = self.of(self.map)

    def of(self, map: VisibilityMap) -> tuple[Array, Array]:
        """Return index and depth (H, W) of a map."""
        index = np.searchsorted(self.faces, map.face)
        narrow = np.uint16 if len(self.faces) <= 2**16 else np.uint32
        share = depth_shares(map.depth, self.span)
        level = np.where(np.isnan(share), EMPTY, np.rint(FARTHEST * share)).astype(np.uint16)
        return index.astype(narrow), level


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
    # In bands across the image, what lies near each other is also listed so: differences are small.
    order = np.lexsort((points[:, 0], points[:, 1] // BAND))
    ends = np.sort(np.argsort(order)[ends].astype(np.uint32), axis=1)
    ends = ends[np.lexsort((ends[:, 1], ends[:, 0]))]
    places = FINE * points[order].T
    if np.abs(points).max(initial=0.0) < NEAR_ENOUGH:
        places = np.rint(places).astype(np.int32)
    return {"points": pack(places, *([1] if places.dtype == np.int32 else [])), "ends": pack(ends.T, 1)}


def _methods(study: Study | Shown, base: _Whole) -> Iterator[dict[str, Any]]:
    """Yield what each method shows, by how it differs from the one before it that it is most like."""
    none = np.zeros_like(base.map.face, dtype=np.uint8)
    before = [(base.index, base.depth, none, none)]
    for name, map in study.maps.items():
        difference, why = study.differences.get(name), study.causes.get(name)
        classes = none if difference is None else difference.classes
        index, depth = base.of(map)
        same = (classes == SampleClass.SAME) & (map.face == base.map.face)
        shown = (index, np.where(same, base.depth, depth), classes, none if why is None else why.cause)
        apart = [np.any([a != b for a, b in zip(shown, other, strict=True)], axis=0) for other in before]
        like = int(np.argmin([np.count_nonzero(differs) for differs in apart]))
        index, depth, classes, why_of = (part[apart[like]] for part in shown)
        clusters = () if difference is None else difference.clusters[:CLUSTERS]
        before.append(shown)
        yield {
            "name": name,
            "like": like,
            "differs": pack(np.packbits(apart[like])),
            "index": pack(index, 0),
            "depth": pack(depth, 0),
            "classes": pack(classes),
            "causes": pack(why_of),
            "clusters": pack_json([[*cluster.sample, *cluster.box] for cluster in clusters]),
        }
