"""What a family of hard cases says about itself."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hsr.algorithms.registry import certified_methods, method_named, methods
from hsr.base.arrays import Bools, Ints
from hsr.base.errors import HsrError
from hsr.mistakes.renderers import Buffer
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View, view
from hsr.scene.model import Scene

SIDE, QUICK_SIDE = 64, 32
"""Side of the pictures in samples."""

EVERY = 3
"""A quick sweep takes the hardest value, and every third one before it."""

Mistake = Callable[[View], Ints]
"""A renderer with a planted mistake: from a view to the faces (H, W) int32 that it shows."""


Breaks = float | Callable[[int], float] | None
"""A value of the parameter, a function that computes it from the side of the picture, or none."""


def at_side(value: Breaks, side: int) -> float | None:
    """Return what a value is for pictures of this side."""
    return value(side) if callable(value) else value


@dataclass(frozen=True)
class Variant:
    """One way to render, and what theory says of it.

    Attributes
    ----------
    name : str
        Of a registered method, unless ``method`` or ``mistake`` is given.
    breaks : float, callable or None
        The value of the parameter from which on wrong samples are expected, or a function that
        computes it from the side of the picture in samples. None: none are, however hard it gets.
    because : str
        The formula of ``breaks`` and where it comes from. Without one there is no theory.
    factor : float
        By how much the measured break may differ from ``breaks``, either way.
    method : str
        The registered method, if ``name`` is not one.
    options : mapping
        In place of the method's own.
    mistake : callable, optional
        What runs in place of a method.
    safe : float, callable or None
        A value, or a function of the side, at which and before which theory proves that no sample is wrong;
        by default ``breaks``, within the factor.
    curve : callable, optional
        In a family with a figure of its own, the most that theory allows at a value of the parameter; in
        place of ``breaks``. What is measured may be less by the factor.
    excess : float
        By how much what is measured may be more than the curve.
    """

    name: str
    breaks: Breaks = None
    because: str = ""
    factor: float = 2.0
    method: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)
    mistake: Mistake | None = None
    safe: Breaks = None
    curve: Callable[[float], float] | None = None
    excess: float = 1.0

    @property
    def curved(self) -> bool:
        """Whether spheres and cylinders are exact; else the tessellated view is what it is judged on."""
        return self.mistake is not None or method_named(self.method or self.name).curved

    def render(self, seen: View) -> VisibilityMap:
        """Render a view; see :func:`hsr.render` for the errors."""
        if self.mistake is None:
            return method_named(self.method or self.name).render(seen, **self.options)
        with np.errstate(all="ignore"):
            face = self.mistake(seen)
        return VisibilityMap(face, np.where(face >= 0, 0.0, np.inf), self.name)


def buffer(name: str, breaks: Breaks, because: str, **mistake: Any) -> Variant:
    """Return a depth buffer with a mistake, or a format of its own: attributes of :class:`Buffer`."""
    return Variant(name, breaks, because, mistake=Buffer(**mistake))


@dataclass(frozen=True)
class Trial:
    """One view as one variant shows it, beside the truth.

    Attributes
    ----------
    family : Family
    value : float
        Of the parameter.
    view : View
        Tessellated if the variant knows no curved shapes.
    truth : VisibilityMap
    variant : Variant
    answer : VisibilityMap
        What the variant shows.
    """

    family: Family
    value: float
    view: View
    truth: VisibilityMap
    variant: Variant
    answer: VisibilityMap


def not_admissible(trial: Trial) -> Bools:
    """Count as wrong (H, W) what the truth does not admit."""
    return ~trial.truth.admits(trial.answer.face)


def another_choice(trial: Trial) -> Bools:
    """Count as wrong (H, W) every face but that of the truth, even if it may own the tie as well."""
    return np.asarray(trial.answer.face != trial.truth.face)


def square_picture(_: float, side: int) -> tuple[int, int]:
    """Return the size (width, height) of most pictures."""
    return side, side


@dataclass(frozen=True)
class Family:
    """Scenes that grow harder with one parameter.

    Attributes
    ----------
    name : str
    group : str
        What it is about: ``depth``, ``coverage``, ``rays``, ``order`` or ``relations``.
    story : str
        One paragraph for people.
    expected : str
        What the exact answer is.
    source : str
        The book or paper that the case, or the formula, goes back to.
    parameter : str
        What is swept, with its unit.
    sweep : tuple of float
        From easy to hard, ascending or descending.
    scene : callable
        From a value of the parameter, and the side of the picture, to the scene.
    variants : tuple of Variant
        Those theory says something of.
    size : callable
        From the value and the side to (width, height).
    wrong : callable
        Which samples (H, W) of a trial count as wrong.
    figure, figure_name
        If given, a function from a trial and its wrong samples to what is measured in place of their
        number, and the name of that. It is 0 where nothing is wrong.
    continuous : bool
        Whether values between those of the sweep make scenes as well; counts and exact grids do not.
    marked : mapping
        Values of the parameter that the chart marks, by what they are: where theories cross, say.
    """

    name: str
    group: str
    story: str
    expected: str
    source: str
    parameter: str
    sweep: tuple[float, ...]
    scene: Callable[[float, int], Scene]
    variants: tuple[Variant, ...]
    size: Callable[[float, int], tuple[int, int]] = square_picture
    wrong: Callable[[Trial], Bools] = not_admissible
    figure: Callable[[Trial, Bools], float] | None = None
    figure_name: str = "wrong samples"
    continuous: bool = True
    marked: Mapping[str, float] = field(default_factory=dict)

    @property
    def ascending(self) -> bool:
        """Whether it is large values that are hard."""
        return self.sweep[0] < self.sweep[-1]

    def values(self, quick: bool) -> tuple[float, ...]:
        """Return the values of the parameter, the easiest first."""
        return self.sweep[::-EVERY][::-1] if quick else self.sweep

    def view(self, value: float, side: int) -> View:
        """Return the view at a value of the parameter."""
        return view(self.scene(value, side), self.size(value, side))

    def scene_at(self, value: float, side: int) -> Scene:
        """Return the scene at a value of the parameter.

        Raises
        ------
        HsrError
            If the value lies outside the sweep, or between its values and that means nothing.
        """
        low, high = sorted((self.sweep[0], self.sweep[-1]))
        if not low <= value <= high:
            raise HsrError(f"{self.name}: --at {value:g} is outside the sweep, {low:g} to {high:g}")
        if not self.continuous and value not in self.sweep:
            there = ", ".join(f"{one:g}" for one in self.sweep)
            raise HsrError(f"{self.name}: --at {value:g} is not in the sweep; choose one of {there}")
        width, height = self.size(value, side)
        about = f"{self.parameter}: {value!r}; to be seen at {width}x{height} samples. {self.expected}"
        return self.scene(value, side).model_copy(update={"title": self.name, "about": about})

    def knows(self, name: str) -> bool:
        """Tell whether a name is that of a variant or of a method."""
        return name in methods() or name in {variant.name for variant in self.variants}

    def contenders(self, asked: tuple[str, ...] = (), quick: bool = False) -> tuple[Variant, ...]:
        """Return who takes part: the certified methods, the family's variants, the peers.

        Parameters
        ----------
        asked : tuple of str
            Names of variants or methods; if there are any, they alone take part.
        quick : bool
            Of methods that need the same, the first stands for all.

        Raises
        ------
        MethodError
            If a name is neither a variant of the family nor a method.
        """
        known = {variant.name: variant for variant in self.variants}
        proven = "certified: every sign is proven"
        certified = {name: Variant(name, None, proven) for name in certified_methods()}
        # A peer is a method that needs more than this package.
        outside = [method for method in methods().values() if method.needs]
        if quick:
            outside = list({method.needs: method for method in reversed(outside)}.values())
        peers = {method.name: Variant(method.name) for method in outside}
        everyone = {**certified, **peers, **known}
        if not asked:
            return tuple(everyone[name] for name in {**certified, **known, **peers})
        return tuple(everyone.get(name) or Variant(method_named(name).name) for name in asked)


GROUPS = {
    "depth": "Which of two surfaces is nearer",
    "coverage": "Which samples a face covers",
    "rays": "What a ray meets",
    "order": "Surfaces that touch, coincide or overlap in a cycle",
    "relations": "What must not change the answer",
}
"""What the families are about."""


Scenes = Callable[[float, int], Scene]
"""From a value of the parameter, and the side of the picture, to the scene."""


def octaves(first: float, last: float, step: float = 1.0) -> tuple[float, ...]:
    """Return ``2**first`` to ``2**last``, both included, in steps of so many octaves."""
    return tuple(2.0**k for k in np.linspace(first, last, round(abs(last - first) / step) + 1).tolist())


def hard_case(
    group: str, parameter: str, sweep: tuple[float, ...], continuous: bool = True
) -> Callable[[Scenes], Family]:
    """Make a family of the function below, which returns its scenes.

    The function's name is that of the family. The second paragraph of its docstring is the story; one that
    begins with ``Truth:`` says what the exact answer is, and one with ``Source:`` which book or paper the
    case, or the formula, goes back to. :func:`variants` and :func:`also` say the rest in between.
    """

    def made(scene: Scenes) -> Family:
        paragraphs = [" ".join(text.split()) for text in (inspect.getdoc(scene) or "").split("\n\n")]
        told = {name: text for name, mark, text in (part.partition(": ") for part in paragraphs) if mark}
        name, about = scene.__name__.replace("_", "-"), (paragraphs[1], told["Truth"], told["Source"])
        return Family(name, group, *about, parameter, sweep, scene, continuous=continuous, **vars(scene))

    return made


def variants(*those: Variant) -> Callable[[Scenes], Scenes]:
    """Say of which variants theory says something, and what."""
    return also(variants=those)


def also(**facts: Any) -> Callable[[Scenes], Scenes]:
    """Say what other attributes of :class:`Family` are, if they are not what they mostly are."""

    def noted(scene: Scenes) -> Scenes:
        vars(scene).update(facts)
        return scene

    return noted
