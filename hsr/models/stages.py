"""What a model of a pipeline consists of, and the causes it can name."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from functools import lru_cache
from typing import Any, NamedTuple

from hsr.base.arrays import Array, Floats, Ints
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View


class Cause(IntEnum):
    """Why a sample is wrong: the stage of the method's pipeline that makes it so."""

    NONE = 0
    TESSELLATION = 1
    INPUT_ROUNDING = 2
    TRANSFORM = 3
    CLIPPING = 4
    VERTEX_SNAPPING = 5
    FILL_RULE = 6
    DEPTH_ARITHMETIC = 7
    DEPTH_FORMAT = 8
    TRAVERSAL = 9
    INTERSECTOR = 10
    NO_DEPTH_TEST = 11
    UNEXPLAINED = 12

    @property
    def label(self) -> str:
        """The name as people read it: ``fill rule``."""
        return self.name.lower().replace("_", " ")


Whole = Callable[[View, Any], tuple[Ints, Floats]]
"""A model of whole maps: from the view and the method's options to face and depth (H, W)."""


Model = Callable[[View, Any, Array], Ints]
"""From the view, the method's options and samples (n,), numbered ``row * W + column``, to face ids (n,)."""


class Stage(NamedTuple):
    """One stage of a pipeline, and the model that works like the method up to and with it.

    Attributes
    ----------
    cause : Cause
        What a sample's error is put down to if this stage brings it in.
    faces : callable
        The model, which tells the face ids that it shows at samples.
    """

    cause: Cause
    faces: Model


class Pipeline(NamedTuple):
    """The models of a method, each one stage deeper than the one before.

    Attributes
    ----------
    stages : tuple of Stage
        The last works like the method from end to end.
    whole : callable or None
        The last model; None if that can only be asked for single samples.
    """

    stages: tuple[Stage, ...]
    whole: Whole | None


def rerun(render: Callable[[View, Any], VisibilityMap]) -> Whole:
    """Return the last model of a method: the method run again, for its faces and depths (H, W).

    The last answer is kept for the next question about the same view.
    """

    @lru_cache(maxsize=1)
    def rendered(view: View, options: Any) -> tuple[Ints, Floats]:
        again = render(view, options)
        return again.face, again.depth

    return rendered


def named(*models: Model) -> tuple[Stage, ...]:
    """Return the stages of models that are called as their causes are."""
    return tuple(Stage(Cause[model.__name__.upper()], model) for model in models)


def ending(whole: Whole, cause: Cause, *before: Stage) -> Pipeline:
    """Return the pipeline whose last stage is looked up in whole maps."""
    return Pipeline((*before, Stage(cause, lambda *asked: at_samples(whole, *asked))), whole)


def at_samples(whole: Whole, view: View, options: Any, samples: Array) -> Ints:
    """Return the face ids (n,) that a model of whole maps shows at samples."""
    return whole(view, options)[0].ravel()[samples]
