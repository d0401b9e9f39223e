"""What one method made of a sample, told by facts: forms of words, and what stands in their gaps."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from hsr.difference.sightline import EDGE_ON, Layer, Sightline
from hsr.models.llvmpipe.driver import SUBPIXEL_BITS, Drawn, drawn_at
from hsr.models.stages import Cause
from hsr.problem.map import BACKGROUND, VisibilityMap
from hsr.problem.view import View

DRIVER = "llvmpipe"
"""The driver of OpenGL that is modelled."""

SNAPPED = f"after snapping to 1/{1 << SUBPIXEL_BITS} pixel"

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
class Said:
    """A text by its facts.

    Attributes
    ----------
    form : str
        The words, with gaps as ``str.format`` fills them: ``{}``, or a number's ``{:.3g}``.
    values : tuple of str, int or float
        What stands in the gaps.
    """

    form: str
    values: tuple[str | float, ...] = ()

    def __str__(self) -> str:
        return self.form.format(*self.values)

    def __add__(self, other: Said) -> Said:
        return Said(self.form + other.form, self.values + other.values)


def say(form: str, *values: str | float) -> Said:
    """Say something by a form and what stands in its gaps."""
    return Said(form, values)


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
    said : Said
        The sentence that tells all of it.
    """

    method: str
    face: int
    name: str
    depth: float
    right: bool
    cause: str
    said: Said

    @property
    def sentence(self) -> str:
        """All of it in words."""
        return str(self.said)

    def to_json(self) -> dict[str, Any]:
        """Return all of it as JSON values."""
        *facts, _ = self._asdict().items()
        depth = self.depth if np.isfinite(self.depth) else None
        return {**dict(facts), "depth": depth, "sentence": self.sentence}


class Telling:
    """What one method made of a sample, in words.

    Methods of which ``shows`` is the same give the same verdicts.

    Parameters
    ----------
    view : View
    answer : VisibilityMap
        By the method.
    sample : int
        Number ``row * W + column``.
    sightline : Sightline
        Of the sample.
    name : callable
        From the id of a face to what people call it.
    """

    def __init__(
        self, view: View, answer: VisibilityMap, sample: int, sightline: Sightline, name: Callable[[int], str]
    ) -> None:
        self.view, self.answer, self.sample, self.sightline, self.name = view, answer, sample, sightline, name
        self.face, self.depth = int(answer.face.flat[sample]), float(answer.depth.flat[sample])
        self.shown = self.sightline.of(self.face)
        self.covered = self.shown is not None and self.shown.covered
        self.modelled = DRIVER in answer.notes.get("driver", "")
        self.shows = self.face, None if self.covered else self.depth, self.modelled

    def verdict(self, layer: Layer) -> Said:
        """Say what became of one face."""
        if layer is self.shown:
            return say("won")
        first = layer is self.sightline.of(layer.face) and layer.face != self.face
        if first and {self.face, layer.face} <= self.sightline.admissible:
            return say("tie")
        if layer.removed:
            return say(GONE[layer.removed])
        if layer.facing == EDGE_ON:
            return say("edge-on")
        if layer.depth is None:
            edge, distance = layer.nearest_edge
            return say("not covered: {:.3g} px outside {}", -distance, edge)
        drawn = self.drawn(layer.face)
        if drawn is not None and drawn.inside < 0.0:
            return say("not covered: ") + _inside(drawn.inside) + say(f" {SNAPPED}")
        if self.face == BACKGROUND:
            return say("missed")
        return self._compared(layer.depth)

    def _compared(self, depth: Fraction) -> Said:
        """Compare a depth with that of the face shown: the exact one if it covers the sample."""
        shown = self.shown
        of_shown = self.depth if shown is None or shown.depth is None else shown.depth
        gap, name = float(depth - of_shown), self.name(self.face)
        if math.isnan(gap):
            return say("passed over for {}, whose depth is not told", name)
        if gap > 0.0:
            return say("lost depth to {} by {:.3g}", name, gap)
        nearer = say("passed over: {:.3g} nearer than {}", -gap, name)
        return nearer if gap else say("as deep as {}", name)

    def story(self, cause: Cause, tessellated: Callable[[], Sightline]) -> Story:
        """Say whether the method is right, and if not, why: there may be polygons for curved shapes."""
        method, name, owners = self.answer.method, self.name(self.face), len(self.sightline.admissible)
        if cause == Cause.NONE:
            tie = say(", one of {} that may own it.", owners) if owners > 1 else say(".")
            right = say("{} is right: it shows {}", method, name) + tie
            return Story(method, self.face, name, self.depth, True, "", right)
        because = say("{} shows {} because ", method, name) + self._reason(cause, tessellated)
        told = because + say(" ({}); exactly, ", cause.label) + self._truth() + say(".")
        return Story(method, self.face, name, self.depth, False, cause.label, told)

    def _truth(self) -> Said:
        """Say by what numbers the owner owns the sample, and the face shown does not."""
        shown, owner = self.shown, self.sightline.of(self.sightline.owner)
        owns = say("nothing covers it") if owner is None else say("{} owns it", self.name(owner.face))
        if shown is not None and shown.removed:
            return say(f"it is {GONE[shown.removed]}, and ") + owns
        if shown is not None and shown.depth is None and shown.edges:
            edge, distance = shown.nearest_edge
            return say("the sample lies {:.3g} px outside its {}, and ", -distance, edge) + owns
        if owner is None or owner.depth is None:
            return owns
        if shown is not None and shown.depth is not None:
            return say("{} is nearer by {:.3g}", self.name(owner.face), float(shown.depth - owner.depth))
        edge, distance = owner.nearest_edge
        inside = say("the sample lies {:.3g} px inside {} of ", distance, edge)
        return inside + say("{}, which owns it", self.name(owner.face))

    def drawn(self, face: int) -> Drawn | None:
        """How the driver sees a face at the sample, where it is the one that is modelled."""
        return drawn_at(self.view, face, self.sample) if self.modelled else None

    def _reason(self, cause: Cause, tessellated: Callable[[], Sightline]) -> Said:
        """Say what went wrong, by the numbers of the method's own model if it has some."""
        shown, owner = self.drawn(self.face), self.drawn(self.sightline.owner)
        name = self.name(self.sightline.owner)
        if cause == Cause.TESSELLATION:
            return self._tessellated(name, tessellated())
        if cause in (Cause.VERTEX_SNAPPING, Cause.FILL_RULE):
            drawn, what = (owner, name) if shown is None or self.covered else (shown, "it")
            if drawn is not None:
                return say(f"{SNAPPED} the sample lies ") + _inside(drawn.inside) + say(" {}", what)
        if cause in (Cause.DEPTH_ARITHMETIC, Cause.DEPTH_FORMAT) and shown is not None and owner is not None:
            first = say(", and it was drawn first" if shown.level == owner.level else "")
            stored = say("its depth is stored as {} and that of {} as {}", shown.level, name, owner.level)
            return stored + first
        return say(REASONS[cause])

    def _tessellated(self, name: str, sightline: Sightline) -> Said:
        """Say how the polygons lie that stand for the owner."""
        polygons = say("the polygons of {} sides that stand for ", self.view.segments)
        own = [layer for layer in sightline.layers if layer.face == self.sightline.owner and layer.edges]
        if not own or any(layer.covered for layer in own):
            return polygons + say("curved shapes lie elsewhere")
        missed = min(-layer.nearest_edge[1] for layer in own)
        return polygons + say("{} miss the sample by {:.3g} px", name, missed)


def _inside(distance: float) -> Said:
    if distance == 0.0:
        return say("on an edge of")
    return say(f"{{:.3g}} px {'inside' if distance > 0 else 'outside'}", abs(distance))
