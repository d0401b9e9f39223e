"""One scene, one view, many methods: every map, and how each differs from the reference."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hsr.algorithms.ahead import Ahead
from hsr.algorithms.registry import Method, driver_of, method_named, methods
from hsr.base.arrays import Array
from hsr.base.errors import MapError, MethodError, UnavailableError
from hsr.base.jit import is_compiled, kernels_loaded
from hsr.base.store import Store
from hsr.difference.cause import Causes, causes, causes_by
from hsr.difference.cause import explained as put_down
from hsr.difference.classes import Difference, compare
from hsr.difference.history import explain
from hsr.models.foreign import MODEL
from hsr.problem.map import READ, VisibilityMap
from hsr.problem.view import View, view
from hsr.scene.files import ball_of
from hsr.scene.fitting import words
from hsr.scene.model import Scene

RECALLED = "recalled"
"""Note of a map that was computed before: its seconds were not measured now."""

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
        Why the wrong samples of every other map are wrong, once :func:`explained` if the reference is exact.
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

    @property
    def command(self) -> str:
        """The command that tells the history of a sample, X,Y in its place; empty if none can."""
        file, cameras = self.scene.file, self.scene.cameras_of_file
        if not file:
            return ""
        (seen,) = (camera for camera in self.scene.camera if camera.name == self.camera)
        base = next((camera for camera in cameras if camera.name == self.camera), cameras[0])
        moves = words(seen, base, ball_of(self.scene))
        read = dict.fromkeys(map.notes.get(READ, "") for map in self.maps.values())
        asked = [word for name, map in self.maps.items() if READ not in map.notes for word in ("-a", name)]
        asked += [word for words in read for word in shlex.split(words)]
        named = "" if base == cameras[0] else base.name
        size = (self.view.width, self.view.height)
        return "" if moves is None else explain(file, "X,Y", size, named, [*moves, *asked])

    def to_json(self) -> dict[str, Any]:
        """Return the study as JSON values, without the maps themselves."""
        return {
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
    store: Store | None = None,
    ahead: Ahead | None = None,
    given: Sequence[VisibilityMap] = (),
    each: Callable[[Study], None] | None = None,
) -> Study:
    """Run methods on one view of a scene and compare their maps with that of the reference.

    A method that cannot run here, or cannot handle the view, is skipped with its reason. No times hold
    the compiling or loading of kernels, and each method prepares the view for itself, so that its times
    do not depend on who came before.

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
        Called with a method's name before it runs, or with what is done for it first.
    store : Store, optional
        Where maps are looked up, and kept; those from there have the note :data:`RECALLED`.
    ahead : Ahead, optional
        Who compiles kernels meanwhile.
    given : sequence of VisibilityMap
        Of the same view by other programs, which stand after the methods, called by theirs.
    each : callable, optional
        Called after each method with the study as it is so far.

    Returns
    -------
    Study

    Raises
    ------
    MethodError
        If a method does not exist.
    ViewError
        If the view cannot be made.
    MapError
        If two of the methods and maps have one name.
    """
    chosen = [method_named(name) for name in dict.fromkeys([*methods, reference])]
    problem, outside = view(scene, size, camera), {map.method: map for map in given}
    if len({method.name for method in chosen} | outside.keys()) < len(chosen) + len(given):
        raise MapError(
            f"two of the methods and maps are called alike; name maps otherwise: {', '.join(outside)}"
        )
    maps: dict[str, VisibilityMap] = {}
    skipped: dict[str, str] = {}
    missing: set[str] = set()

    def so_far() -> Study:
        made = {method.name: maps[method.name] for method in chosen if method.name in maps} | outside
        truth = made.get(reference)
        others = {name: map for name, map in made.items() if truth and name != reference}
        return Study(
            name=name or scene.title or "scene",
            scene=scene,
            view=problem,
            camera=camera or scene.camera[0].name,
            methods=(*(method.name for method in chosen), *outside),
            reference=reference if truth else None,
            maps=made,
            skipped=skipped,
            missing=frozenset(missing),
            tessellating=(*(x.name for x in chosen if not x.curved), *outside) if problem.curved else (),
            differences={name: compare(map, truth) for name, map in others.items() if truth},
            causes={},
            agreement=_agreement(list(made.values())),
        )

    for method in ahead.order(chosen) if ahead else chosen:
        if progress is not None:
            progress(_doing(method))
        try:
            if ahead is not None:
                ahead.wait(method)
            maps[method.name] = _answer(method, problem, patient, store)
        except (MethodError, UnavailableError) as error:
            skipped[method.name] = str(error).removeprefix(f"{method.name}: ")
            if isinstance(error, UnavailableError):
                missing.add(method.name)
        if each is not None and maps:
            each(so_far())
    truth = maps.get(reference)
    if truth is not None and truth.admissible is not None:
        outside |= {name: put_down(problem, map, truth)[0] for name, map in outside.items()}
    return so_far()


def explained(found: Study, store: Store | None = None) -> Study:
    """Say of a study why the wrong samples of its maps are wrong, as far as the reference is exact.

    Parameters
    ----------
    found : Study
        What it says already stays.
    store : Store, optional
        Where causes are looked up, and kept.
    """
    truth = found.maps.get(found.reference or "")
    if truth is None or truth.admissible is None:
        return found
    known = found.causes
    why = {
        name: known.get(name) or _causes(found.view, found.maps[name], truth, store)
        for name in found.differences
    }
    return replace(found, causes=why)


def causes_of(studies: Sequence[Study], name: str) -> Counter[str]:
    """Count the wrong samples of a method by cause, over all studies that know why."""
    return sum((Counter(found.causes[name].counts) for found in studies if name in found.causes), Counter())


def _doing(method: Method) -> str:
    """Say what is done next: a method's kernels are compiled the first time that they are needed."""
    compiled = is_compiled(method.name) or not method.ours
    return method.name if compiled else f"{method.name}: compiling, once"


def _answer(method: Method, problem: View, patient: bool, store: Store | None) -> VisibilityMap:
    """Look up the map of a method, or have it made."""
    if store is None or not method.ours:
        return _run(method, problem, patient)
    parts = ("map", repr(method), driver_of(method), problem.hashes)
    found: VisibilityMap | None = store.get(*parts)
    if found is not None:
        return replace(found, notes=found.notes | {RECALLED: True})
    answer = _run(method, problem, patient)
    store.put(answer, *parts)
    return answer


def _causes(problem: View, answer: VisibilityMap, truth: VisibilityMap, store: Store | None) -> Causes:
    """Look up why samples of a map are wrong, or find out."""
    method = methods().get(answer.method)
    if method is None or not method.ours or MODEL in answer.notes:
        try:
            return causes(problem, answer, truth)
        except Exception:  # the models of another package may raise anything: it is as if there were none
            return causes_by(None, problem, answer, truth)
    if store is None:
        return causes(problem, answer, truth)
    parts = ("causes", answer.method, problem.hashes, answer.digest)
    found: Causes | None = store.get(*parts)
    if found is None:
        found = causes(problem, answer, truth)
        store.put(found, *parts)
    return found


def _run(method: Method, problem: View, patient: bool) -> VisibilityMap:
    if method.exhaustive and not patient and problem.faces * problem.width * problem.height > PATIENCE:
        why = f"tests each of {problem.faces:,} faces at each sample, which may take minutes"
        raise MethodError(f"{why}; name it to run it all the same")
    if method not in _begun:
        method.warm_up(problem)
        _begun.append(method)
    loaded = kernels_loaded()
    answer = method.render(_apart(problem))
    # Times are measured again if they hold kernels that this view is the first to need.
    return answer if kernels_loaded() == loaded else method.render(_apart(problem))


_begun: list[Method] = []
"""The methods that have been warmed up in this process: their kernels are loaded, and drivers opened."""


def _apart(problem: View) -> View:
    """Give a view a geometry of its own: no method profits from what another prepared."""
    return replace(problem, placements=tuple(problem.placements))


def _agreement(maps: Sequence[VisibilityMap]) -> Array:
    """Count the samples at which each pair of maps shows different faces."""
    differing = np.zeros((len(maps), len(maps)), dtype=np.int64)
    for i, first in enumerate(maps):
        for j, second in enumerate(maps[:i]):
            differing[i, j] = differing[j, i] = np.count_nonzero(first.face != second.face)
    return differing
