"""One scene, one view, many methods: every map, and how each differs from the reference."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hsr.algorithms.registry import Method, method_named
from hsr.base.arrays import Array
from hsr.base.errors import MethodError, UnavailableError
from hsr.difference.cause import Causes, causes
from hsr.difference.classes import Difference, compare
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View, view
from hsr.scene.model import Scene

COUNTED = ("seconds", "work", "notes")
"""What the JSON form tells of each map."""

Progress = Callable[[str], None]
"""Called with what is done next, before each step of long work."""

PATIENCE = 2**29
"""Tests of a face at a sample that a study waits for unasked: a few seconds on two cores."""


@dataclass(frozen=True, eq=False)
class Study:
    """What many methods make of one view.

    Attributes
    ----------
    name : str
    scene : Scene
    view : View
        The one problem all methods were given.
    camera : str
        Name of the camera.
    methods : tuple of str
        All that were asked for, the reference among them, in that order.
    reference : str or None
        The method the others are judged against. None if it could not run: the reason is in
        ``skipped``, ``differences`` is empty, and the agreement matrix still tells who agrees.
    maps : dict of str to VisibilityMap
        By method, in the order asked for.
    skipped : dict of str to str
        Methods that did not run, and why.
    missing : frozenset of str
        Those of them that need something this machine lacks.
    tessellating : tuple of str
        Methods that put polygons in place of the scene's curved shapes; empty if it has none. Along
        the silhouette of a curved shape they rightly differ from methods that do not.
    differences : dict of str to Difference
        Every other map against the reference's.
    causes : dict of str to Causes
        Why the wrong samples of every other map are wrong; empty unless the reference is exact.
    agreement : (M, M) int64
        Number of samples at which two methods show different faces, in the order of ``maps``.
    """

    name: str
    scene: Scene
    view: View
    camera: str
    methods: tuple[str, ...]
    reference: str | None
    maps: dict[str, VisibilityMap]
    skipped: dict[str, str]
    missing: frozenset[str]
    tessellating: tuple[str, ...]
    differences: dict[str, Difference]
    causes: dict[str, Causes]
    agreement: Array

    def to_json(self) -> dict[str, Any]:
        """Return the study as JSON values, without the maps themselves."""
        return {
            "hsr": 1,
            "name": self.name,
            "title": self.scene.title,
            "camera": self.camera,
            "size": [self.view.width, self.view.height],
            "faces": self.view.faces,
            "hashes": self.view.hashes,
            "reference": self.reference,
            "methods": {name: {key: vars(map)[key] for key in COUNTED} for name, map in self.maps.items()},
            "skipped": self.skipped,
            "tessellating": list(self.tessellating),
            "differences": {name: found.to_json() for name, found in self.differences.items()},
            "causes": {name: found.to_json() for name, found in self.causes.items()},
            "agreement": {"methods": list(self.maps), "differing": self.agreement.tolist()},
        }


def study(
    scene: Scene,
    methods: Sequence[str],
    reference: str,
    size: tuple[int, int] = (512, 512),
    camera: str | None = None,
    *,
    name: str = "",
    patient: bool = False,
    progress: Progress | None = None,
) -> Study:
    """Run methods on one view of a scene and compare their maps with that of the reference.

    A method that cannot run here, or cannot handle the view, is skipped with its reason. Every
    method first draws a tiny picture of the scene, so that its times hold no compilation; and each
    prepares the view for itself, so that its times do not depend on who came before.

    Parameters
    ----------
    scene : Scene
    methods : sequence of str
        Names that ``hsr algos`` lists.
    reference : str
        The method to judge against; it need not be among ``methods``.
    size : (width, height)
        In pixels.
    camera : str, optional
        Name of the camera; the scene's first by default.
    name : str
        What to call the study; the scene's title by default.
    patient : bool
        Whether to run exhaustive methods however long they take.
    progress : callable, optional
        Called with a method's name before it runs.

    Returns
    -------
    Study

    Raises
    ------
    MethodError
        If a method does not exist.
    ViewError
        If the view cannot be made.
    """
    chosen = [method_named(name) for name in dict.fromkeys([*methods, reference])]
    problem = view(scene, size, camera)
    maps: dict[str, VisibilityMap] = {}
    skipped: dict[str, str] = {}
    missing = set()
    for method in chosen:
        if progress is not None:
            progress(method.name)
        try:
            maps[method.name] = _run(method, problem, patient)
        except (MethodError, UnavailableError) as error:
            skipped[method.name] = str(error).removeprefix(f"{method.name}: ")
            if isinstance(error, UnavailableError):
                missing.add(method.name)
    truth = maps.get(reference)
    others = {name: map for name, map in maps.items() if truth and name != reference}
    why = {name: causes(problem, map, truth) for name, map in others.items() if truth and truth.admissible}
    return Study(
        name=name or scene.title or "scene",
        scene=scene,
        view=problem,
        camera=camera or scene.camera[0].name,
        methods=tuple(method.name for method in chosen),
        reference=reference if truth else None,
        maps=maps,
        skipped=skipped,
        missing=frozenset(missing),
        tessellating=tuple(method.name for method in chosen if problem.curved and not method.curved),
        differences={name: compare(map, truth) for name, map in others.items() if truth},
        causes=why,
        agreement=_agreement(list(maps.values())),
    )


def causes_of(studies: Sequence[Study], name: str) -> Counter[str]:
    """Count the wrong samples of a method by cause, over all studies that know why."""
    return sum((Counter(found.causes[name].counts) for found in studies if name in found.causes), Counter())


def _run(method: Method, problem: View, patient: bool) -> VisibilityMap:
    if method.exhaustive and not patient and problem.faces * problem.width * problem.height > PATIENCE:
        why = f"tests each of {problem.faces:,} faces at each sample, which may take minutes"
        raise MethodError(f"{why}; name it to run it all the same")
    method.warm_up(problem)
    # A geometry of its own: none profits from what another prepared.
    return method.render(replace(problem, placements=tuple(problem.placements)))


def _agreement(maps: Sequence[VisibilityMap]) -> Array:
    """Count the samples at which each pair of maps shows different faces."""
    differing = np.zeros((len(maps), len(maps)), dtype=np.int64)
    for i, first in enumerate(maps):
        for j, second in enumerate(maps[:i]):
            differing[i, j] = differing[j, i] = np.count_nonzero(first.face != second.face)
    return differing
