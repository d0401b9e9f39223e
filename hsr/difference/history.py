"""One sample's story: every face on its line of sight, and what each method made of it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from hsr.difference.cause import Causes, causes
from hsr.difference.models.llvmpipe import LLVMPIPE, Drawn, drawn_at
from hsr.difference.models.stages import Cause
from hsr.difference.sight import EDGE_ON, Layer, Sight, nearby, sight
from hsr.errors import MapError
from hsr.viewing import View
from hsr.visibility import BACKGROUND, Admissible, VisibilityMap, name_in

LEVELS = 2**24 - 1
"""Greatest depth in a buffer of 24 bits."""

DRIVER = "llvmpipe"
"""The driver of OpenGL that is modelled."""

SNAPPED = f"after snapping to 1/{1 << LLVMPIPE.subpixel_bits} pixel"

MISSES_TOLD = 8
"""How many of the faces that just miss the sample the text names; JSON names all."""

MISSED = "within a pixel, not covering:"
"""Heads the faces that just miss the sample."""

GONE = {"culled": "culled", "near": "clipped: in front of near", "far": "clipped: behind far"}

REASONS = {
    Cause.INPUT_ROUNDING: "vertices are rounded in world space",
    Cause.TRANSFORM: "transformed coordinates are rounded",
    Cause.CLIPPING: "the corners that clipping makes are rounded",
    Cause.VERTEX_SNAPPING: "coordinates on the screen are rounded",
    Cause.FILL_RULE: "its fill rule, or the rounding of its edges, decides otherwise",
    Cause.DEPTH_ARITHMETIC: "depths are computed with rounding",
    Cause.DEPTH_FORMAT: "depths are rounded when they are stored",
    Cause.TRAVERSAL: "its traversal leaves out the right face",
    Cause.INTERSECTOR: "its test of the ray with the face is rounded",
    Cause.NO_DEPTH_TEST: "it paints without comparing depths",
    Cause.UNEXPLAINED: "of something no model of it does",
}
"""What a stage does that makes a sample wrong."""


@dataclass(frozen=True)
class Entry:
    """A face on the line of sight, or just beside it.

    Attributes
    ----------
    name : str
    layer : Layer
        How it lies.
    window : Fraction or None
        Depth in the window: 0 at near, 1 at far, affine on the screen. None if the sample is not in
        the face.
    verdicts : dict of str to str
        What became of it, by method.
    """

    name: str
    layer: Layer
    window: Fraction | None
    verdicts: dict[str, str]

    @property
    def quantised(self) -> int | None:
        """Window depth as a buffer of 24 bits holds it, if rounded but once."""
        return round(self.window * LEVELS) if self.window is not None and 0 <= self.window <= 1 else None

    def to_json(self, admissible: Iterable[int]) -> dict[str, Any]:
        """Return all of it as JSON values."""
        return {
            "face": self.layer.face,
            "name": self.name,
            "facing": self.layer.facing,
            "covered": self.layer.covered,
            "edges": dict(self.layer.edges),
            "depth": None if self.layer.depth is None else float(self.layer.depth),
            "window": None if self.window is None else float(self.window),
            "d24": self.quantised,
            "removed": self.layer.removed,
            "admissible": self.layer.face in admissible and self.layer.covered,
            "verdicts": self.verdicts,
        }


@dataclass(frozen=True)
class Story:
    """What one method shows, and why.

    Attributes
    ----------
    method : str
    face : int
        -1 for the background.
    name : str
    depth : float
    right : bool
        Whether the face is admissible.
    cause : str
        The stage of the method's pipeline that makes it wrong; empty if it is right.
    sentence : str
    """

    method: str
    face: int
    name: str
    depth: float
    right: bool
    cause: str
    sentence: str

    def to_json(self) -> dict[str, Any]:
        """Return all of it as JSON values."""
        return vars(self) | {"depth": self.depth if np.isfinite(self.depth) else None}


@dataclass(frozen=True)
class History:
    """All that is known of one sample.

    Attributes
    ----------
    row, column : int
        Row 0 is the top row.
    size : (width, height)
    owner : str
        Name of the face that owns the sample.
    admissible : dict of int to str
        Ids and names of the faces that may own it; more than one is a tie.
    entries : tuple of Entry
        Those that cover the sample, nearest first; then those that miss it by less than a pixel.
    stories : tuple of Story
        One a method.
    """

    row: int
    column: int
    size: tuple[int, int]
    owner: str
    admissible: dict[int, str]
    entries: tuple[Entry, ...]
    stories: tuple[Story, ...]

    def to_json(self) -> dict[str, Any]:
        """Return all of it as JSON values."""
        return {
            "sample": [self.column, self.row],
            "size": list(self.size),
            "owner": self.owner,
            "admissible": list(self.admissible.values()),
            "faces": [entry.to_json(self.admissible) for entry in self.entries],
            "methods": [story.to_json() for story in self.stories],
        }

    def parts(self) -> dict[str, Any]:
        """Return the text in its parts, as JSON values.

        Returns
        -------
        dict
            ``headline``; ``faces`` that cover the sample, each with its ``line``, whether it is
            ``admissible``, and its ``verdicts``: pairs of a verdict and the methods that gave it;
            ``missed``, a line each; ``sentences``, one a method.
        """
        met = [entry for entry in self.entries if entry.layer.covered]
        missed = [entry for entry in self.entries if not entry.layer.covered]
        more = [f"and {len(missed) - MISSES_TOLD} more"] if len(missed) > MISSES_TOLD else []
        return {
            "headline": self._headline(),
            "faces": [self._told(entry) for entry in met],
            "missed": [f"{x.name}  {x.layer.facing}{_edges(x)}" for x in missed[:MISSES_TOLD]] + more,
            "sentences": [story.sentence for story in self.stories],
        }

    def __str__(self) -> str:
        parts = self.parts()
        lines = [parts["headline"], ""]
        for face in parts["faces"]:
            lines += [face["line"], *(f"    {verdict}: {methods}" for verdict, methods in face["verdicts"])]
        if parts["missed"]:
            lines += ["", MISSED, *(f"  {line}" for line in parts["missed"])]
        return "\n".join([*lines, "", *parts["sentences"]])

    def _headline(self) -> str:
        width, height = self.size
        text = f"column {self.column}, row {self.row} of {width}x{height}: owned by {self.owner}"
        others = [name for name in self.admissible.values() if name != self.owner]
        return text + (f"; a tie with {', '.join(others)}" if others else "")

    def _told(self, entry: Entry) -> dict[str, Any]:
        """Tell of a face that covers the sample: where it is, then what became of it."""
        depth, window = float(entry.layer.depth or 0), float(entry.window or 0)
        numbers = f"depth {depth:.9g}  window {window:.9g}"
        if entry.quantised is not None:
            numbers += f"  D24 {entry.quantised}"
        admissible = entry.layer.face in self.admissible
        tie = "  admissible" if admissible and len(self.admissible) > 1 else ""
        line = f"{entry.name}  {entry.layer.facing}  {numbers}{tie}{_edges(entry)}"
        methods: dict[str, list[str]] = {}
        for method, verdict in entry.verdicts.items():
            methods.setdefault(verdict, []).append(method)
        verdicts = [[verdict, ", ".join(named)] for verdict, named in methods.items()]
        return {"line": line, "admissible": admissible, "verdicts": verdicts}


def _edges(entry: Entry) -> str:
    edges = ", ".join(f"{name} {distance:+.4g}" for name, distance in entry.layer.edges.items())
    return f"  px to {edges}" if edges else ""


# ---------------------------------------------------------------- telling a history


def history(
    view: View,
    row: int,
    column: int,
    maps: Sequence[VisibilityMap],
    known: Mapping[str, Causes] | None = None,
) -> History:
    """Tell what lies on the line of sight of a sample, and what methods made of it.

    Parameters
    ----------
    view : View
    row, column : int
        Row 0 is the top row.
    maps : sequence of VisibilityMap
        Of this view, by the methods they name with their options as registered.
    known : mapping of str to Causes, optional
        Causes of all wrong samples, by method, where they have been found already; others are
        looked for at this sample alone.

    Returns
    -------
    History

    Raises
    ------
    ViewError
        If there is no such sample, or the view has no exact answer.
    MapError
        If a map is not of this view.
    """
    seen = sight(view, row, column)
    for answer in maps:
        _check(view, answer)
    names = {layer.face: name_in(view.manifest, layer.face) for layer in seen.layers}
    found = known or {}
    told = [_Telling(view, row, column, seen, answer, found.get(answer.method)) for answer in maps]
    entries = [
        Entry(
            names[layer.face],
            layer,
            None if layer.depth is None else window_depth(view, layer.depth),
            {telling.answer.method: telling.verdict(layer) for telling in told},
        )
        for layer in seen.layers
    ]
    admissible = {face: name_in(view.manifest, face) for face in sorted(seen.admissible)}
    return History(
        row,
        column,
        (view.width, view.height),
        name_in(view.manifest, seen.owner),
        admissible,
        tuple(entries),
        tuple(telling.story() for telling in told),
    )


def _check(view: View, answer: VisibilityMap) -> None:
    for what, digest in view.hashes.items():
        if answer.hashes.get(what, digest) != digest:
            raise MapError(f"the map of {answer.method} shows another {what}; render it anew")
    if answer.face.shape != (view.height, view.width):
        raise MapError(f"the map of {answer.method} has another size; render it anew")


def window_depth(view: View, depth: Fraction) -> Fraction:
    """Turn a depth along the view axis into one of the window, without rounding.

    0 at near and 1 at far, affine on the screen: ``(1/near - 1/d) / (1/near - 1/far)`` under
    perspective, ``(d - near) / (far - near)`` for a parallel view.
    """
    near = Fraction(view.near)
    if not view.perspective:
        return (depth - near) / (Fraction(view.far) - near)
    beyond = Fraction(0) if view.far == float("inf") else 1 / Fraction(view.far)
    return (1 / near - 1 / depth) / (1 / near - beyond)


# ---------------------------------------------------------------- one method


@dataclass(frozen=True, eq=False)
class _Telling:
    """What one method made of a sample, in words."""

    view: View
    row: int
    column: int
    sight: Sight
    answer: VisibilityMap
    known: Causes | None

    @property
    def face(self) -> int:
        return int(self.answer.face[self.row, self.column])

    @property
    def depth(self) -> float:
        return float(self.answer.depth[self.row, self.column])

    @property
    def shown(self) -> Layer | None:
        return self.sight.of(self.face)

    def name(self, face: int) -> str:
        return name_in(self.view.manifest, face)

    def verdict(self, layer: Layer) -> str:
        """Say what became of one face."""
        if layer is self.shown:
            return "won"
        first = layer is self.sight.of(layer.face) and layer.face != self.face
        if first and {self.face, layer.face} <= self.sight.admissible:
            return "tie"
        if layer.removed:
            return GONE[layer.removed]
        if layer.facing == EDGE_ON:
            return "edge-on"
        if layer.depth is None:
            edge, distance = layer.nearest_edge
            return f"not covered: {-distance:.3g} px outside {edge}"
        if layer.face in self.drawn and self.drawn[layer.face].inside < 0.0:
            return f"not covered: {_inside(self.drawn[layer.face].inside)} {SNAPPED}"
        if self.face == BACKGROUND:
            return "missed"
        return self._compared(layer.depth)

    def _compared(self, depth: Fraction) -> str:
        """Compare a depth with that of the face shown: the exact one if it covers the sample."""
        shown = self.shown
        of_shown = self.depth if shown is None or shown.depth is None else shown.depth
        gap, name = float(depth - of_shown), self.name(self.face)
        if math.isnan(gap):
            return f"passed over for {name}, whose depth is not told"
        if gap == 0.0:
            return f"as deep as {name}"
        return (
            f"lost depth to {name} by {gap:.3g}" if gap > 0 else f"passed over: {-gap:.3g} nearer than {name}"
        )

    def story(self) -> Story:
        """Say whether the method is right, and if not, why."""
        right = self.face in self.sight.admissible
        cause = Cause.NONE if right else self._cause()
        label = "" if right else cause.label
        sentence = self._right() if right else self._wrong(cause)
        method, name = self.answer.method, self.name(self.face)
        return Story(method, self.face, name, self.depth, right, label, sentence)

    def _cause(self) -> Cause:
        if self.known is not None:
            return Cause(int(self.known.cause[self.row, self.column]))
        return cause_of(self.view, self.row, self.column, self.sight, self.answer)

    def _right(self) -> str:
        tie = (
            ""
            if len(self.sight.admissible) == 1
            else f", one of {len(self.sight.admissible)} that may own it"
        )
        return f"{self.answer.method} is right: it shows {self.name(self.face)}{tie}."

    def _wrong(self, cause: Cause) -> str:
        return (
            f"{self.answer.method} shows {self.name(self.face)} because {self._reason(cause)} "
            f"({cause.label}); exactly, {self._truth()}."
        )

    def _truth(self) -> str:
        """Say by what numbers the owner owns the sample, and the face shown does not."""
        shown, owner = self.shown, self.sight.of(self.sight.owner)
        owns = "nothing covers it" if owner is None else f"{self.name(owner.face)} owns it"
        if shown is not None and shown.removed:
            return f"it is {GONE[shown.removed]}, and {owns}"
        if shown is not None and shown.depth is None and shown.edges:
            edge, distance = shown.nearest_edge
            return f"the sample lies {-distance:.3g} px outside its {edge}, and {owns}"
        if owner is None or owner.depth is None:
            return owns
        if shown is not None and shown.depth is not None:
            return f"{self.name(owner.face)} is nearer by {float(shown.depth - owner.depth):.3g}"
        edge, distance = owner.nearest_edge
        return f"the sample lies {distance:.3g} px inside {edge} of {self.name(owner.face)}, which owns it"

    @cached_property
    def drawn(self) -> dict[int, Drawn]:
        """How the driver sees each face near the sample, where it is the one that is modelled."""
        if DRIVER not in self.answer.notes.get("driver", ""):
            return {}
        near, origin = nearby(self.view, self.row, self.column)
        drawn: dict[int, Drawn] = {}
        for found in drawn_at(near, self.row, self.column):
            face = int(origin[found.face])
            drawn[face] = max(drawn.get(face, found), found, key=lambda one: one.inside)
        return drawn

    def _reason(self, cause: Cause) -> str:
        """Say what went wrong, by the numbers of the method's own model if it has some."""
        shown, owner = self.drawn.get(self.face), self.drawn.get(self.sight.owner)
        exact = self.shown
        name = self.name(self.sight.owner)
        if cause == Cause.TESSELLATION:
            return self._tessellated()
        if cause in (Cause.VERTEX_SNAPPING, Cause.FILL_RULE):
            if shown is not None and (exact is None or not exact.covered):
                return f"{SNAPPED} the sample lies {_inside(shown.inside)} it"
            if owner is not None:
                return f"{SNAPPED} the sample lies {_inside(owner.inside)} {name}"
        if cause in (Cause.DEPTH_ARITHMETIC, Cause.DEPTH_FORMAT) and shown is not None and owner is not None:
            first = ", and it was drawn first" if shown.level == owner.level else ""
            return f"its depth is stored as {shown.level} and that of {name} as {owner.level}{first}"
        return REASONS[cause]

    def _tessellated(self) -> str:
        """Say how the polygons lie that stand for the owner."""
        name = self.name(self.sight.owner)
        polygons = f"the polygons of {self.view.segments} sides that stand for "
        layers = _polygons_there(self.view, self.row, self.column)
        own = [layer for layer in layers if layer.face == self.sight.owner and layer.edges]
        if not own or any(layer.covered for layer in own):
            return f"{polygons}curved shapes lie elsewhere"
        missed = min(-layer.nearest_edge[1] for layer in own)
        return f"{polygons}{name} miss the sample by {missed:.3g} px"


@lru_cache(maxsize=1)  # every method that is wrong at a sample asks
def _polygons_there(view: View, row: int, column: int) -> tuple[Layer, ...]:
    """Look at the polygons that stand for curved shapes on the line of sight of a sample."""
    return sight(view.tessellated(), row, column).layers


def _inside(distance: float) -> str:
    if distance == 0.0:
        return "on an edge of"
    return f"{abs(distance):.3g} px {'inside' if distance > 0 else 'outside'}"


# ---------------------------------------------------------------- causes


def cause_of(view: View, row: int, column: int, seen: Sight, answer: VisibilityMap) -> Cause:
    """Find the stage of its pipeline at which a method goes wrong at one sample.

    The models are asked about the faces near the sample first, which is quick; about the whole view
    where that explains nothing, as when triangles elsewhere have a say.
    """
    near, origin = nearby(view, row, column)
    number = {int(face): k for k, face in enumerate(origin)} | {BACKGROUND: BACKGROUND}
    shown = int(answer.face[row, column])
    if near.placements and shown in number:
        truth = [number[seen.owner], *(number[face] for face in seen.admissible)]
        cause = _caused(near, row, column, answer.method, number[shown], truth)
        if cause != Cause.UNEXPLAINED:
            return cause
    return _caused(view, row, column, answer.method, shown, [seen.owner, *seen.admissible])


def _caused(view: View, row: int, column: int, method: str, shown: int, truth: Sequence[int]) -> Cause:
    """Ask for the cause at one sample, as if the maps were empty elsewhere."""
    sample = row * view.width + column
    faces = np.array(sorted(set(truth)), dtype=np.int32)
    tied = Admissible(np.array([sample]), np.array([0, len(faces)]), faces)
    found = causes(view, _dotted(view, sample, method, shown), _dotted(view, sample, "exact", truth[0], tied))
    return Cause(int(found.cause[row, column]))


def _dotted(
    view: View, sample: int, method: str, face: int, admissible: Admissible | None = None
) -> VisibilityMap:
    """Return a map that shows one face at one sample."""
    faces = np.full((view.height, view.width), BACKGROUND, dtype=np.int32)
    faces.ravel()[sample] = face
    return VisibilityMap(faces, np.full(faces.shape, np.inf), method, admissible=admissible)
