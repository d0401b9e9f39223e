"""One sample's story: every face on its line of sight, and what each method made of it."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property, partial
from itertools import chain
from typing import Any

import numpy as np
from markupsafe import Markup

from hsr.base.deprecated import sample_by_name
from hsr.base.errors import MapError
from hsr.difference.cause import Causes, causes_at
from hsr.difference.nearby import check_sample, faces_nearby
from hsr.difference.sightline import Layer, Sightline, sightlines
from hsr.difference.telling import Said, Story, Telling, say
from hsr.models.foreign import model_of
from hsr.models.stages import Cause
from hsr.problem.map import BACKGROUND, VisibilityMap, name_in
from hsr.problem.view import View

LEVELS = 2**24 - 1
"""Greatest depth in a buffer of 24 bits."""

MISSES_TOLD = 8
"""How many of the faces that just miss the sample the text names; JSON names all."""

MISSED = "within a pixel, not covering:"
"""Heads the faces that just miss the sample."""

PARTS = ("headline", "faces", "missed", "sentence")
"""Of the text of a history."""

INDENT = {"verdict": "    ", "missed": "  "}
"""What the lines of a history begin with, by what they are."""


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
        From the layer to ``said``, which is found when it is asked for.
    """

    name: str
    layer: Layer
    window: Fraction | None
    judge: Callable[[Layer], dict[str, Said]]

    @cached_property
    def said(self) -> dict[str, Said]:
        """What became of it, by method, with the numbers."""
        return self.judge(self.layer)

    @property
    def verdicts(self) -> dict[str, str]:
        """What became of it, by method, in words."""
        return {method: str(verdict) for method, verdict in self.said.items()}

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

    def lines(self) -> Iterator[tuple[str, Said]]:
        """Yield the lines of the text, each with what it is.

        Yields
        ------
        kind : {"headline", "owner", "face", "verdict", "missed", "sentence"}
            A face that covers the sample is an ``owner`` if it is admissible; its verdicts follow it.
        said : Said
        """
        met = [entry for entry in self.entries if entry.layer.covered]
        missed = [entry for entry in self.entries if not entry.layer.covered]
        yield "headline", self._headline()
        for entry in met:
            yield from self._told(entry)
        for entry in missed[:MISSES_TOLD]:
            yield "missed", say("{}  {}", entry.name, entry.layer.facing) + _edges(entry)
        if len(missed) > MISSES_TOLD:
            yield "missed", say("and {} more", len(missed) - MISSES_TOLD)
        yield from (("sentence", story.said) for story in self.stories)

    def _repr_html_(self) -> str:
        """Show the text in a notebook."""
        return Markup("<pre>{}</pre>").format(self)

    def __str__(self) -> str:
        told: dict[str, list[str]] = {part: [] for part in PARTS}
        for kind, said in self.lines():
            told[kind if kind in PARTS else "faces"].append(f"{INDENT.get(kind, '')}{said}")
        told["missed"] = ["", MISSED, *told["missed"]] if told["missed"] else []
        return "\n".join([*told["headline"], "", *told["faces"], *told["missed"], "", *told["sentence"]])

    def _headline(self) -> Said:
        others = [name for name in self.admissible.values() if name != self.owner]
        tie = say("; a tie with {}", ", ".join(others)) if others else say("")
        place = say("column {}, row {} of {}x{}", self.column, self.row, *self.size)
        return place + say(": owned by {}", self.owner) + tie

    def _told(self, entry: Entry) -> Iterator[tuple[str, Said]]:
        """Tell of a face that covers the sample: where it is, then what became of it."""
        depth, window = float(entry.layer.depth or 0), float(entry.window or 0)
        line = say("{}  {}  depth {:.9g}  window {:.9g}", entry.name, entry.layer.facing, depth, window)
        if entry.quantised is not None:
            line += say("  D24 {}", entry.quantised)
        admissible = entry.layer.face in self.admissible
        if admissible and len(self.admissible) > 1:
            line += say("  admissible")
        yield "owner" if admissible else "face", line + _edges(entry)
        words = entry.verdicts
        for verdict, said in {words[method]: said for method, said in entry.said.items()}.items():
            methods = ", ".join(method for method in words if words[method] == verdict)
            yield "verdict", said + say(": {}", methods)


def _edges(entry: Entry) -> Said:
    edges = entry.layer.edges.items()
    form = ", ".join(["{} {:+.4g}"] * len(edges))
    return Said(f"  px to {form}" if edges else "", tuple(chain(*edges)))


# ---------------------------------------------------------------- telling histories


def explain(
    scene: str, sample: str, size: tuple[int, int], camera: str = "", asked: Sequence[str] = ()
) -> str:
    """Return the command that tells the history of a sample, quoted for a shell.

    Parameters
    ----------
    scene : str
        Its file.
    sample : str
        Column and row: ``"311,204"``.
    size : (width, height)
    camera : str
        Its name, empty for the first of the scene.
    asked : sequence of str
        Options that say what is asked: ``-a METHOD``, ``--map FILE``.
    """
    width, height = size
    seen = ["--camera", camera] if camera else []
    return shlex.join(["hsr", "explain", scene, sample, "--size", f"{width}x{height}", *seen, *asked])


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
        told = [Telling(self.view, answer, sample, seen, self.name) for answer in self.maps]
        speakers = {telling.shows: telling for telling in told}

        def verdicts(layer: Layer) -> dict[str, Said]:
            said = {shows: telling.verdict(layer) for shows, telling in speakers.items()}
            return {telling.answer.method: said[telling.shows] for telling in told}

        owners = {face: self.name(face) for face in sorted(seen.admissible)}
        deep = partial(window_depth, self.view)
        entries = (Entry(self.name(x.face), x, deep(x.depth), verdicts) for x in seen.layers)
        stories = (it.story(self.cause(sample, it.answer), lambda: self.tessellated[sample]) for it in told)
        owner, (row, column) = self.name(seen.owner), divmod(sample, size[0])
        return History(row, column, size, owner, owners, tuple(entries), tuple(stories))

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
