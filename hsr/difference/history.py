"""One sample's story: every face on its line of sight, and what each method made of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property, partial
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup

from hsr.base.deprecated import sample_by_name
from hsr.base.errors import MapError
from hsr.difference.cause import Causes, causes_at
from hsr.difference.nearby import check_sample, faces_nearby
from hsr.difference.sightline import EDGE_ON, Layer, Sightline, sightlines
from hsr.models.foreign import model_of
from hsr.models.llvmpipe.driver import SUBPIXEL_BITS, Drawn, drawn_at
from hsr.models.stages import Cause
from hsr.problem.map import BACKGROUND, VisibilityMap, name_in
from hsr.problem.view import View

LEVELS = 2**24 - 1
"""Greatest depth in a buffer of 24 bits."""

DRIVER = "llvmpipe"
"""The driver of OpenGL that is modelled."""

SNAPPED = f"after snapping to 1/{1 << SUBPIXEL_BITS} pixel"

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


Known = Mapping[str, Causes] | None
"""Causes of all wrong samples, by method, where they have been found already."""


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
    judge : callable
        From the layer to ``verdicts``, which are found when they are asked for.
    """

    name: str
    layer: Layer
    window: Fraction | None
    judge: Callable[[Layer], dict[str, str]]

    @cached_property
    def verdicts(self) -> dict[str, str]:
        """What became of it, by method."""
        return self.judge(self.layer)

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


class Story(NamedTuple):
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
        return self._asdict() | {"depth": self.depth if np.isfinite(self.depth) else None}


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
            "sample": {"x": self.column, "y": self.row},
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

    def _repr_html_(self) -> str:
        """Show the text in a notebook."""
        return Markup("<pre>{}</pre>").format(self)

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
        said = entry.verdicts
        methods = {verdict: [name for name in said if said[name] == verdict] for verdict in said.values()}
        verdicts = [[verdict, ", ".join(named)] for verdict, named in methods.items()]
        return {"line": line, "admissible": admissible, "verdicts": verdicts}


def _edges(entry: Entry) -> str:
    edges = ", ".join(f"{name} {distance:+.4g}" for name, distance in entry.layer.edges.items())
    return f"  px to {edges}" if edges else ""


# ---------------------------------------------------------------- telling histories


@sample_by_name
def history(
    view: View, maps: Sequence[VisibilityMap] = (), known: Known = None, *, x: int, y: int
) -> History:
    """Tell what lies on the line of sight of a sample, and what methods made of it.

    Parameters
    ----------
    view : View
    maps : sequence of VisibilityMap
        Of this view, by the methods they name with their options as registered.
    known : mapping of str to Causes, optional
        Causes of all wrong samples, by method, where they have been found already; others are
        looked for at this sample alone.
    x, y : int
        Column and row of the sample, counted from 0 at the top left.

    Returns
    -------
    History

    Raises
    ------
    ViewError
        If there is no such sample, or the view has no exact answer.
    MapError
        If a map is not of this view.

    Examples
    --------
    >>> import hsr
    >>> view = hsr.view(hsr.load("scenes/cyclic.toml"), size=(12, 9))
    >>> told = hsr.history(view, [hsr.render(view, "painter")], x=5, y=2)
    >>> [(entry.name, round(float(entry.layer.depth), 2)) for entry in told.entries if entry.layer.covered]
    [('third.front', 5.64), ('third.back', 5.84), ('second.front', 6.16), ('second.back', 6.37)]
    >>> print(told.stories[0].sentence.split("; ")[0])
    painter shows second.front because it paints without comparing depths (no depth test)
    """
    check_sample(view, x, y)
    sample = y * view.width + x
    return Historian(view, [sample], maps, known).tell(sample)


class Historian:
    """Tells the histories of some samples of a view.

    What the samples have in common is set up once.

    Parameters
    ----------
    view : View
    samples : sequence of int
        Numbers ``row * W + column``.
    maps : sequence of VisibilityMap
    known : mapping of str to Causes, optional
        As for :func:`history`.

    Raises
    ------
    ViewError
        If the view has no exact answer.
    MapError
        If a map is not of this view.
    """

    def __init__(
        self, view: View, samples: Sequence[int], maps: Sequence[VisibilityMap], known: Known = None
    ) -> None:
        for answer in maps:
            _check(view, answer)
        self.view, self.maps, self.known = view, maps, known or {}
        self.nearby = faces_nearby(view, np.array(samples))
        faces = [BACKGROUND, *self.nearby.origin.tolist()]
        self.number = {face: k for k, face in enumerate(faces, start=BACKGROUND)}
        self.sightlines = sightlines(self.nearby)
        self.name = cache(partial(name_in, view.manifest))
        self.cause = cache(self._cause)

    def tell(self, sample: int) -> History:
        """Tell the history of one of the samples."""
        seen, size = self.sightlines[sample], (self.view.width, self.view.height)
        told = [_Telling(self, sample, answer) for answer in self.maps]
        speakers = {telling.shows: telling for telling in told}

        def verdicts(layer: Layer) -> dict[str, str]:
            said = {shows: telling.verdict(layer) for shows, telling in speakers.items()}
            return {telling.answer.method: said[telling.shows] for telling in told}

        owners = {face: self.name(face) for face in sorted(seen.admissible)}
        deep = partial(window_depth, self.view)
        entries = (Entry(self.name(x.face), x, deep(x.depth), verdicts) for x in seen.layers)
        stories = tuple(telling.story() for telling in told)
        return History(*divmod(sample, size[0]), size, self.name(seen.owner), owners, tuple(entries), stories)

    @cached_property
    def tessellated(self) -> dict[int, Sightline]:
        """What is on the lines of sight where polygons stand for curved shapes, and matter."""

        def matters(sample: int) -> bool:
            return any(self.cause(sample, answer) == Cause.TESSELLATION for answer in self.maps)

        samples = np.array([*filter(matters, self.sightlines)])
        return sightlines(faces_nearby(self.view.tessellated(), samples))

    def _cause(self, sample: int, answer: VisibilityMap) -> Cause:
        """Return the stage at which a method goes wrong at a sample, if it does."""
        shown = int(answer.face.flat[sample])
        if shown in self.sightlines[sample].admissible:
            return Cause.NONE
        if answer.method in self.known:
            return Cause(int(self.known[answer.method].cause.flat[sample]))
        # The models are asked about the faces near the sample first, which is quick; about the whole view
        # where that explains nothing, as when triangles elsewhere have a say.
        (method, options), here = model_of(answer), np.array([sample])
        for view, face in ((self.nearby.view, self.number.get(shown)), (self.view, shown)):
            if view.placements and face is not None:
                cause = Cause(int(causes_at(method, view, here, np.array([face]), **options)[0]))
                if cause != Cause.UNEXPLAINED:
                    return cause
        return Cause.UNEXPLAINED


def _check(view: View, answer: VisibilityMap) -> None:
    for what, digest in view.hashes.items():
        if answer.hashes.get(what, digest) != digest:
            raise MapError(f"the map of {answer.method} shows another {what}; render it anew")
    if answer.face.shape != (view.height, view.width):
        raise MapError(f"the map of {answer.method} has another size; render it anew")


def window_depth(view: View, depth: Fraction | None) -> Fraction | None:
    """Turn a depth along the view axis, where there is one, into one of the window, without rounding.

    0 at near and 1 at far, affine on the screen: ``(1/near - 1/d) / (1/near - 1/far)`` under
    perspective, ``(d - near) / (far - near)`` for a parallel view.
    """
    if depth is None:
        return None
    near = Fraction(view.near)
    if not view.perspective:
        return (depth - near) / (Fraction(view.far) - near)
    beyond = 0 if view.far == float("inf") else 1 / Fraction(view.far)
    return (1 / near - 1 / depth) / (1 / near - beyond)


# ---------------------------------------------------------------- one method


class _Telling:
    """What one method made of a sample, in words.

    Methods of which ``shows`` is the same give the same verdicts.
    """

    def __init__(self, historian: Historian, sample: int, answer: VisibilityMap) -> None:
        self.historian, self.sample, self.answer = historian, sample, answer
        self.sightline, self.name = historian.sightlines[sample], historian.name
        self.face, self.depth = int(answer.face.flat[sample]), float(answer.depth.flat[sample])
        self.shown = self.sightline.of(self.face)
        self.covered = self.shown is not None and self.shown.covered
        self.modelled = DRIVER in answer.notes.get("driver", "")
        self.shows = self.face, None if self.covered else self.depth, self.modelled

    def verdict(self, layer: Layer) -> str:
        """Say what became of one face."""
        if layer is self.shown:
            return "won"
        first = layer is self.sightline.of(layer.face) and layer.face != self.face
        if first and {self.face, layer.face} <= self.sightline.admissible:
            return "tie"
        if layer.removed:
            return GONE[layer.removed]
        if layer.facing == EDGE_ON:
            return "edge-on"
        if layer.depth is None:
            edge, distance = layer.nearest_edge
            return f"not covered: {-distance:.3g} px outside {edge}"
        drawn = self.drawn(layer.face)
        if drawn is not None and drawn.inside < 0.0:
            return f"not covered: {_inside(drawn.inside)} {SNAPPED}"
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
        if gap > 0.0:
            return f"lost depth to {name} by {gap:.3g}"
        return f"passed over: {-gap:.3g} nearer than {name}" if gap else f"as deep as {name}"

    def story(self) -> Story:
        """Say whether the method is right, and if not, why."""
        method, name, owners = self.answer.method, self.name(self.face), len(self.sightline.admissible)
        cause = self.historian.cause(self.sample, self.answer)
        if cause == Cause.NONE:
            tie = f", one of {owners} that may own it" if owners > 1 else ""
            label, sentence = "", f"{method} is right: it shows {name}{tie}."
        else:
            label, because = cause.label, f"because {self._reason(cause)} ({cause.label})"
            sentence = f"{method} shows {name} {because}; exactly, {self._truth()}."
        return Story(method, self.face, name, self.depth, cause == Cause.NONE, label, sentence)

    def _truth(self) -> str:
        """Say by what numbers the owner owns the sample, and the face shown does not."""
        shown, owner = self.shown, self.sightline.of(self.sightline.owner)
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

    def drawn(self, face: int) -> Drawn | None:
        """How the driver sees a face at the sample, where it is the one that is modelled."""
        return drawn_at(self.historian.view, face, self.sample) if self.modelled else None

    def _reason(self, cause: Cause) -> str:
        """Say what went wrong, by the numbers of the method's own model if it has some."""
        shown, owner = self.drawn(self.face), self.drawn(self.sightline.owner)
        name = self.name(self.sightline.owner)
        if cause == Cause.TESSELLATION:
            return self._tessellated(name)
        if cause in (Cause.VERTEX_SNAPPING, Cause.FILL_RULE):
            drawn, what = (owner, name) if shown is None or self.covered else (shown, "it")
            if drawn is not None:
                return f"{SNAPPED} the sample lies {_inside(drawn.inside)} {what}"
        if cause in (Cause.DEPTH_ARITHMETIC, Cause.DEPTH_FORMAT) and shown is not None and owner is not None:
            first = ", and it was drawn first" if shown.level == owner.level else ""
            return f"its depth is stored as {shown.level} and that of {name} as {owner.level}{first}"
        return REASONS[cause]

    def _tessellated(self, name: str) -> str:
        """Say how the polygons lie that stand for the owner."""
        polygons = f"the polygons of {self.historian.view.segments} sides that stand for "
        layers = self.historian.tessellated[self.sample].layers
        own = [layer for layer in layers if layer.face == self.sightline.owner and layer.edges]
        if not own or any(layer.covered for layer in own):
            return f"{polygons}curved shapes lie elsewhere"
        missed = min(-layer.nearest_edge[1] for layer in own)
        return f"{polygons}{name} miss the sample by {missed:.3g} px"


def _inside(distance: float) -> str:
    if distance == 0.0:
        return "on an edge of"
    return f"{abs(distance):.3g} px {'inside' if distance > 0 else 'outside'}"
