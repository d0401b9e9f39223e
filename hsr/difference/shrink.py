"""The smallest scene in which two methods still disagree at a sample.

Faces far from the line of sight go first. What is left is cut down by delta debugging (Zeller &
Hildebrandt, "Simplifying and isolating failure-inducing input", IEEE Transactions on Software
Engineering, 2002): parts are dropped as long as the two methods show at the sample what they show there
in the whole scene.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import groupby, pairwise
from operator import itemgetter
from typing import Any, NamedTuple, TypeVar

import numpy as np

from hsr.algorithms.registry import render
from hsr.base.arrays import Floats, Ints
from hsr.base.deprecated import sample_by_name
from hsr.base.errors import MethodError
from hsr.difference.nearby import check_sample, faces_nearby
from hsr.problem.map import BACKGROUND, name_in
from hsr.problem.view import View, view
from hsr.scene.model import Mesh, Object, Scene, Step
from hsr.scene.names import unique
from hsr.scene.transforms import copies

Item = TypeVar("Item")

Size = tuple[int, int]
"""Width and height, in pixels."""

Part = tuple[int, int]
"""What is kept or dropped as one: a triangle of an object, by their numbers, or with ``WHOLE`` all of it."""

WHOLE = -1


class Shrunk(NamedTuple):
    """A small scene in which two methods disagree at a sample.

    Attributes
    ----------
    scene : Scene
        It has one camera, the one asked for; meshes are written out in object space.
    faces : tuple of str
        What each of its faces was called in the scene it came from; a face of which several
        triangles are left is named as often.
    shown : tuple of 2 str
        The faces that the two methods show at the sample, by those names.
    """

    scene: Scene
    faces: tuple[str, ...]
    shown: tuple[str, str]


@sample_by_name
def shrink(
    scene: Scene, a: str, b: str, size: Size = (512, 512), camera: str | None = None, *, x: int, y: int
) -> Shrunk:
    """Find a smallest scene in which two methods still disagree at a sample, and by the same faces.

    It is one from which no part can be dropped: no triangle, no sphere or cylinder. Other shapes are
    taken apart into the triangles that their faces are fans of, unless the methods agree on those.

    Parameters
    ----------
    scene : Scene
    a, b : str
        Names that ``hsr algos`` lists.
    size : (width, height)
        In pixels; kept.
    camera : str, optional
        Name of the camera, the scene's first by default; kept.
    x, y : int
        Column and row of the sample, counted from 0 at the top left.

    Returns
    -------
    Shrunk

    Raises
    ------
    ViewError
        If there is no such camera or sample.
    MethodError
        If a method does not exist, or both show the same face at the sample.
    UnavailableError
        If a method needs what this machine lacks.
    """
    whole = view(scene, size, camera)
    check_sample(whole, x, y)
    seen_by = next(one for one in scene.camera if camera in (None, one.name))
    bench = _Bench(scene.model_copy(update={"camera": (seen_by,)}), whole, (y, x), (a, b))
    sample = np.array([y * whole.width + x])
    nearby, everything = faces_nearby(whole, sample).origin, np.arange(whole.faces, dtype=np.int32)
    shown = bench.shown(whole, everything)
    if shown[0] == shown[1]:
        name = name_in(whole.manifest, shown[0])
        raise MethodError(f"{a} and {b} agree at column {x}, row {y}: both show {name}")

    def as_before(parts: Sequence[Part]) -> bool:
        small, origin = bench.scene_of(parts)
        return bench.shown(bench.view_of(small), origin) == shown

    starts = [bench.parts(nearby, True), bench.parts(nearby, False)]
    parts = next(filter(as_before, filter(None, starts)), bench.parts(everything, False))
    least, origin = bench.scene_of(minimised(parts, as_before))
    faces = tuple(name_in(whole.manifest, int(face)) for face in origin)
    one, other = (name_in(whole.manifest, face) for face in shown)
    return Shrunk(bench.titled(least, faces), faces, (one, other))


def minimised(items: Sequence[Item], holds: Callable[[Sequence[Item]], bool]) -> list[Item]:
    """Drop items while a property holds: the algorithm ddmin of Zeller & Hildebrandt.

    Parameters
    ----------
    items : sequence
        The property holds of all of them.
    holds : callable
        Never asked about no items at all.

    Returns
    -------
    list
        Items of which the property holds, and no longer without any single one of them.
    """
    kept, granularity = list(items), 2
    while len(kept) >= 2:
        ends = np.linspace(0, len(kept), granularity + 1).astype(int)
        parts = [(kept[start:end], kept[:start] + kept[end:]) for start, end in pairwise(ends)]
        smaller = [(part, 2) for part, _ in parts]
        if granularity > 2:  # of two parts, each is what is left without the other
            smaller += [(rest, granularity - 1) for _, rest in parts]
        found = next((one for one in smaller if holds(one[0])), None)
        if found is not None:
            kept, granularity = found
        elif granularity < len(kept):
            granularity = min(2 * granularity, len(kept))
        else:
            break
    return kept


class _Bench:
    """Where small scenes are put together from parts of a scene, and tried."""

    def __init__(self, scene: Scene, view: View, sample: tuple[int, int], methods: tuple[str, str]) -> None:
        self.scene, self.view, self.sample, self.methods = scene, view, sample, methods
        self.things = [thing for thing in scene.object for _ in copies(thing)]

    def parts(self, faces: Ints, apart: bool) -> list[Part]:
        """Return the parts that these faces belong to; shapes of more than triangles ``apart`` or whole."""
        found = []
        for number, placement in enumerate(self.view.placements):
            polygons = placement.shape.polygons
            if polygons is not None and (apart or len(polygons.corner) == 3 * len(polygons)):
                chosen = np.flatnonzero(np.isin(placement.first + polygons.triangle_face, faces))
                found += [(number, int(triangle)) for triangle in chosen]
            elif placement.first in faces:
                found.append((number, WHOLE))
        return found

    def view_of(self, small: Scene) -> View:
        return view(small, (self.view.width, self.view.height))

    def shown(self, seen: View, origin: Ints) -> tuple[int, int]:
        """Return what the methods show at the sample, as faces of the whole scene."""
        one, other = (int(render(seen, method).face[self.sample]) for method in self.methods)
        name = [*map(int, origin), BACKGROUND]
        return name[one], name[other]

    def scene_of(self, parts: Sequence[Part]) -> tuple[Scene, Ints]:
        """Put parts together; return also the face of the whole scene that each face of theirs is."""
        groups = groupby(parts, key=itemgetter(0))
        made = [self._object_of(number, [triangle for _, triangle in group]) for number, group in groups]
        names = unique([thing.name for thing, _ in made])
        named = (one.model_copy(update={"name": name}) for (one, _), name in zip(made, names, strict=True))
        whole = self.scene.model_copy(update={"object": tuple(named)})
        return whole, np.concatenate([face for _, face in made])

    def _object_of(self, number: int, triangles: list[int]) -> tuple[Object, Ints]:
        thing, placement = self.things[number], self.view.placements[number]
        steps, polygons = _steps(placement.world_from_object), placement.shape.polygons
        if triangles == [WHOLE] or polygons is None:
            whole = thing.model_copy(update={"name": placement.name, "transform": steps, "scatter": None})
            return whole, np.arange(placement.shape.faces, dtype=np.int32) + np.int32(placement.first)
        used, corner = np.unique(polygons.triangle_vertex[triangles], return_inverse=True)
        faces: Any = corner.reshape(-1, 3).tolist()
        vertices = polygons.vertices[used].tolist()
        mesh = Mesh(name=placement.name, shape="mesh", vertices=vertices, faces=faces)
        placed = {"transform": steps, "cull": thing.cull, "colour": thing.colour}
        mesh = mesh.model_copy(update={key: value for key, value in placed.items() if value})
        return mesh, polygons.triangle_face[triangles] + np.int32(placement.first)

    def titled(self, small: Scene, faces: Sequence[str]) -> Scene:
        """Write into a scene what it shows, and what its faces were called."""
        (row, column), size = self.sample, f"{self.view.width}x{self.view.height}"
        title = f"{' and '.join(self.methods)} differ at column {column}, row {row} of {size}"
        names = [name_in(self.view_of(small).manifest, face) for face in range(len(faces))]
        was = [f"{new} was {old}" for new, old in zip(names, faces, strict=True) if new != old]
        about = "Shrunk from a larger scene" + (f", in which {', '.join(was)}." if was else ".")
        return small.model_copy(update={"title": title, "about": about})


def _steps(matrix: Floats) -> tuple[Step, ...]:
    return () if np.array_equal(matrix, np.eye(4)) else (Step.model_validate({"matrix": matrix.tolist()}),)
