"""Why each wrong sample is wrong: the stage of the method's pipeline that makes it so.

A sample is wrong where a method shows an owner that is not admissible. Models of the method's pipeline
are asked what they show there, from the method itself back to the truth, each doing one stage less as
the method does it and all the later ones without error. The cause is the stage from which on all deeper
models show what the method shows. If already the deepest does not, the sample is unexplained: a bug,
in the method or in its model. There is no tolerance anywhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from hsr.algorithms.registry import Method
from hsr.base.arrays import Array, Pixels
from hsr.base.errors import MapError, MethodError, UnavailableError
from hsr.models.foreign import CANDIDATES, has_model, model_of, modelled
from hsr.models.rounded import tessellated_truth
from hsr.models.stages import Cause, Pipeline
from hsr.pictures.maps import class_picture
from hsr.pictures.palette import CAUSE_COLOURS
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View


@dataclass(frozen=True, eq=False)
class Causes:
    """Why the wrong samples of a map are wrong.

    Attributes
    ----------
    method : str
    cause : (H, W) uint8
        A :class:`Cause` per sample, 0 where the owner is admissible. Row 0 is the top row.
    reproduced : bool or None
        Whether the deepest model shows the faces and depths of the whole map, bit for bit; None if
        the method has no model of whole maps.
    """

    method: str
    cause: Pixels
    reproduced: bool | None

    @cached_property
    def counts(self) -> dict[str, int]:
        """Number of wrong samples of each cause that occurs, by its name, in the order of the stages."""
        number = np.bincount(self.cause.ravel(), minlength=len(Cause))
        return {cause.label: int(number[cause]) for cause in Cause if cause and number[cause]}

    @property
    def wrong(self) -> int:
        """Number of samples with an owner that is not admissible."""
        return int(np.count_nonzero(self.cause))

    @property
    def unexplained(self) -> int:
        """Number of wrong samples that the deepest model does not show."""
        return self.counts.get(Cause.UNEXPLAINED.label, 0)

    def _repr_html_(self) -> str:
        """Show in a notebook where it is wrong, and why."""
        from hsr.pictures.notebook import figure  # Pillow and its like are for pictures only

        colours = {int(cause): CAUSE_COLOURS[cause.label] for cause in Cause if cause}
        told = "".join(f"\n{number:,} {name}" for name, number in self.counts.items())
        picture = class_picture(self.cause, self.cause > 0, colours)
        return figure(picture, f"where {self.method} is wrong", f"{self.method}: {self.wrong:,} wrong{told}")

    def to_json(self) -> dict[str, Any]:
        """Return the figures as JSON values."""
        return {
            "method": self.method,
            "wrong": self.wrong,
            "causes": self.counts,
            "unexplained": self.unexplained,
            "reproduced": self.reproduced,
        }


def causes(view: View, answer: VisibilityMap, truth: VisibilityMap, **options: Any) -> Causes:
    """Say for every wrong sample of a map at which stage of its method it went wrong.

    Parameters
    ----------
    view : View
        What ``answer`` shows; curved shapes not tessellated.
    answer : VisibilityMap
        The map that is judged, by the method that it names, or the model (:func:`hsr.testing.modelled`).
    truth : VisibilityMap
        The exact map of the same view, with its admissible owners.
    **options
        The options with which the method ran, as for ``render``.

    Returns
    -------
    Causes
        All wrong samples are unexplained if the method has no models.

    Raises
    ------
    MapError
        If the maps have not the size of the view, or ``truth`` knows no admissible owners.
    MethodError
        If the method does not have such an option.

    Examples
    --------
    >>> import hsr
    >>> view = hsr.view(hsr.load("scenes/cyclic.toml"), size=(12, 9))
    >>> hsr.causes(view, hsr.render(view, "painter"), hsr.render(view, "exact")).counts
    {'no depth test': 2}
    """
    method, noted = model_of(answer)
    return causes_by(method, view, answer, truth, **noted | options)


def explained(view: View, answer: VisibilityMap, truth: VisibilityMap) -> tuple[VisibilityMap, Causes | None]:
    """Put the wrong samples of a map down to causes, by whomever it was made.

    Parameters
    ----------
    view, answer, truth
        As for :func:`causes`.

    Returns
    -------
    VisibilityMap
        The map. If it notes no model, and none is known of its method, all candidates
        (``hsr.models.foreign.CANDIDATES``) are tried, and it notes the one that explains most, the first of
        equals, if that explains at least half of the wrong samples.
    Causes or None
        None if no candidate does.
    """
    if has_model(answer):
        return answer, causes(view, answer, truth)
    best: tuple[VisibilityMap, Causes | None] = answer, None
    fewest = int(np.count_nonzero(~truth.admits(answer.face))) // 2 + 1
    for candidate in CANDIDATES:
        if not fewest:
            break
        made = modelled(answer, **candidate)
        try:
            found = causes(view, made, truth)
        except (MethodError, UnavailableError):  # this view is beyond its limits
            continue
        if found.unexplained < fewest:
            best, fewest = (made, found), found.unexplained
    return best


def causes_by(
    method: Method | None, view: View, answer: VisibilityMap, truth: VisibilityMap, **options: Any
) -> Causes:
    """Do the same for a map by a method that need not be registered, or by none that is known."""
    _check(view, answer, truth)
    samples = np.flatnonzero(~truth.admits(answer.face))
    cause = np.zeros(answer.face.shape, dtype=np.uint8)
    cause.ravel()[samples] = causes_at(method, view, samples, answer.face.ravel()[samples], **options)
    return Causes(answer.method, cause, _reproduced(*_modelled(method, options), view, answer))


def _check(view: View, answer: VisibilityMap, truth: VisibilityMap) -> None:
    for name, shown in (("answer", answer), ("truth", truth)):
        if shown.face.shape != (view.height, view.width):
            sizes = f"{shown.width}x{shown.height} is no map of a view of {view.width}x{view.height}"
            raise MapError(f"{name}: {shown.method} at {sizes}; render it at that size")
    if truth.admissible is None:
        raise MapError(f"truth: a map by {truth.method} does not say who may own ties; render it by 'exact'")


def causes_at(method: Method | None, view: View, samples: Array, shown: Array, **options: Any) -> Pixels:
    """Say at which stage a method went wrong at samples (n,) that show faces (n,) not admissible there.

    From the deepest model towards the truth, as long as the models show what the method shows.
    """
    cause = np.full(len(samples), Cause.UNEXPLAINED, dtype=np.uint8)
    pipeline, chosen = _modelled(method, options)
    if pipeline is None:
        return cause
    alike = np.arange(len(samples))
    for stage in reversed(pipeline.stages):
        if not len(alike) or (stage.cause == Cause.TESSELLATION and not view.curved):
            break
        alike = alike[stage.faces(view, chosen, samples[alike]) == shown[alike]]
        cause[alike] = stage.cause
    if len(samples) and view.curved and pipeline.stages[0].cause == Cause.TESSELLATION:
        # Who may own a tie of the tessellated view is wrong by the tessellation alone.
        truth = tessellated_truth(view)
        face = truth.face.copy()
        face.ravel()[samples] = shown
        cause[truth.admits(face).ravel()[samples]] = Cause.TESSELLATION
    return cause


def _modelled(method: Method | None, options: dict[str, Any]) -> tuple[Pipeline | None, Any]:
    """Return the models of a method, if it has some, and the options with which it ran."""
    pipeline = method.load_pipeline() if method else None
    return pipeline, method.options(**options) if method and pipeline else None


def _reproduced(pipeline: Pipeline | None, chosen: Any, view: View, answer: VisibilityMap) -> bool | None:
    if pipeline is None or pipeline.whole is None:
        return None
    face, depth = pipeline.whole(view, chosen)
    return np.array_equal(face, answer.face) and np.array_equal(depth, answer.depth)
