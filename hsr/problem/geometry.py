"""The objects of a scene in world space, prepared once for all views of them.

What does not depend on the camera is made when first asked for, kept here, and freed with the scene and its
views: the polygons in world space, the hash of the scene, and what methods prepare for themselves, such as
clusters, hierarchies, buffers of OpenGL. A second camera pays for its picture only.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from hsr.base.arrays import Array, Floats, Ints, ranges
from hsr.base.errors import MethodError, ViewError
from hsr.base.files import digest_of
from hsr.scene.files import shape_of
from hsr.scene.model import Scene
from hsr.scene.shapes import MAX_FACES, Polygons, Shape, tessellated
from hsr.scene.transforms import copies, placed
from hsr.scene.values import exact_determinant

CULL = {"none": 0, "back": 1, "front": 2}
"""The numbers by which kernels know what an object culls."""

Made = TypeVar("Made")


@dataclass(frozen=True, eq=False)
class Placement:
    """One object of a view.

    Attributes
    ----------
    name : str
    shape : Shape
        Geometry in object space, one object shared by all instances.
    world_from_object : (4, 4) float64
        Exact by definition.
    first : int
        Id of its first face; the faces of an object are consecutive.
    cull : int
        0 none, 1 back, 2 front.
    mirrored : bool
        Whether the transform and the camera together turn counter-clockwise into clockwise, so
        that the front of a face is the side from which its corners run clockwise on the screen.
    colour : tuple of 3 float
    """

    name: str
    shape: Shape
    world_from_object: Floats
    first: int
    cull: int
    mirrored: bool
    colour: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class WorldPolygons(Polygons):
    """The polygons of a view in world space, counter-clockwise on the screen when front-facing.

    Attributes
    ----------
    cull : (P,) int8
        What each polygon's object culls: 0 none, 1 back, 2 front.
    """

    cull: np.ndarray[Any, np.dtype[np.int8]] = field(default_factory=lambda: np.zeros(0, np.int8))


class Geometry(tuple[Placement, ...]):
    """The objects of a scene in file order, copies expanded, and all that was ever made of them.

    Of a scene it is ``scene.geometry``, which serves all cameras that do not mirror what they see; those that
    do have :attr:`mirror_image`.
    """

    def __init__(self, placements: Iterable[Placement] = ()) -> None:  # noqa: ARG002 - taken by tuple
        self._made: dict[Hashable, Any] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        return Geometry, (tuple(self),)  # a copy makes its own

    def once(self, what: Hashable, make: Callable[[], Made]) -> Made:
        """Return what has been made under a name, or make it.

        Parameters
        ----------
        what : hashable
            A name that nobody else uses, such as that of the method.
        make : callable
            Its answer must depend on nothing but these objects and ``what``.
        """
        if what not in self._made:
            self._made[what] = make()
        made: Made = self._made[what]
        return made

    @property
    def mirror_image(self) -> Geometry:
        """The same objects, for cameras of the other handedness: fronts run the other way round."""
        turned = (replace(one, mirrored=not one.mirrored) for one in self)
        return self.once("mirror image", lambda: Geometry(turned))

    def tessellated(self, segments: int) -> Geometry:
        """Return the same objects with polygons in place of curved shapes, ``segments`` to a full circle."""
        if not self.curved:
            return self
        cut = (replace(one, shape=tessellated(one.shape, segments)) for one in self)
        return self.once(("tessellated", segments), lambda: Geometry(cut))

    @cached_property
    def curved(self) -> bool:
        """Whether any object has faces that are not planar."""
        return any(one.shape.curved for one in self)

    @cached_property
    def matrices(self) -> Floats:
        """What carries the points of each object to world space (objects, 4, 4)."""
        return np.array([one.world_from_object for one in self])

    @cached_property
    def first_faces(self) -> Ints:
        """First face id (objects,) of every object, ascending."""
        return np.array([one.first for one in self], dtype=np.int32)

    @cached_property
    def manifest(self) -> list[dict[str, Any]]:
        """One entry an object: its name, shape and face ids (see ``VisibilityMap.manifest``)."""
        return [_manifest_entry(one) for one in self]

    @cached_property
    def polygons(self) -> WorldPolygons:
        """All planar faces in world space (rounded), in order of face id.

        Raises
        ------
        ViewError
            If a shape is curved, or a vertex overflows.
        """
        return _join([_in_world(one) for one in self])

    @cached_property
    def triangles(self) -> Floats:
        """Corners (n, 3, 3) of all triangles in world space (rounded)."""
        return self.polygons.vertices[self.polygons.triangle_vertex]

    def digest(self, segments: int) -> str:
        """Return the SHA-256 of the objects, curved ones with ``segments`` to a full circle."""
        return self.once(("digest", segments), lambda: digest_of(_parts(self, segments)))


def geometry_of(scene: Scene) -> Geometry:
    """Return the geometry of a scene; the scene keeps it.

    Mesh files are read once: load the scene again to see what has changed in them.

    Raises
    ------
    ViewError
        If there are too many faces.
    """
    # A copy of the scene, which may have other objects, has been given what its original kept.
    *source, geometry = vars(scene).get("_geometry", (None, None, None))
    if geometry is None or source[0] is not scene.object or source[1] != scene.folder:
        geometry = Geometry(_placements(scene))
        vars(scene)["_geometry"] = scene.object, scene.folder, geometry
    assert isinstance(geometry, Geometry)
    return geometry


# A scene is a description and knows nothing of what is made of it.
Scene.geometry = property(geometry_of)


# ---------------------------------------------------------------- objects


def _placements(scene: Scene) -> Iterator[Placement]:
    first = 0
    for thing in scene.object:
        shape = shape_of(thing, scene.folder)
        for name, matrix in copies(thing):
            if first + shape.faces > MAX_FACES:
                raise ViewError(f"object {name!r}: more than {MAX_FACES} faces in the scene")
            mirrored = exact_determinant(matrix[:3, :3]) < 0
            yield Placement(name, shape, matrix, first, CULL[thing.cull], mirrored, thing.colour)
            first += shape.faces


def _manifest_entry(placement: Placement) -> dict[str, Any]:
    shape = placement.shape
    entry = {"name": placement.name, "shape": shape.label, "first": placement.first, "count": shape.faces}
    return entry | ({"faces": list(shape.face_names)} if shape.face_names else {})


def _parts(geometry: Geometry, segments: int) -> Iterator[bytes]:
    """Yield what the hash of a scene is of."""
    if geometry.curved:
        yield f"segments {segments}".encode()
    for one in geometry:
        yield one.shape.digest.encode()
        yield one.world_from_object.tobytes()
        yield f"{one.name} {one.cull}".encode()


# ---------------------------------------------------------------- world space


def _in_world(placement: Placement) -> WorldPolygons:
    polygons = placement.shape.polygons
    if polygons is None:
        raise ViewError(f"object {placement.name!r} is curved; use view.tessellated()")
    with np.errstate(over="ignore", invalid="ignore"):
        vertices = placed(polygons.vertices, placement.world_from_object[:3])
    if not np.isfinite(vertices).all():
        told = "its vertices overflow float64 in world space; scale it down"
        raise ViewError(f"object {placement.name!r}: {told}")
    corner = reversed_loops(polygons) if placement.mirrored else polygons.corner
    cull = np.full(len(polygons), placement.cull, dtype=np.int8)
    return WorldPolygons(vertices, corner, polygons.start, polygons.face + np.int32(placement.first), cull)


def reversed_loops(polygons: Polygons) -> Ints:
    """Corners of every polygon in opposite order, the first corner kept first."""
    which, place = ranges(polygons.start[:-1], polygons.start[1:])
    first, end = polygons.start[which], polygons.start[which + 1]
    return polygons.corner[np.where(place == first, first, first + end - place)]


def _join(parts: list[WorldPolygons]) -> WorldPolygons:
    if len(parts) == 1:
        return parts[0]

    def joined(name: str) -> Array:
        return np.concatenate([getattr(part, name) for part in parts])

    first = np.cumsum([0, *(len(part.vertices) for part in parts)])
    corner = np.concatenate([part.corner + vertex for part, vertex in zip(parts, first, strict=False)])
    start = np.cumsum(np.concatenate([[0], *(np.diff(part.start) for part in parts)]))
    ends = corner.astype(np.int32), start.astype(np.int32)
    return WorldPolygons(joined("vertices"), *ends, joined("face"), joined("cull"))


def as_float32(numbers: Floats, method: str, remedy: str = "scale it down") -> Array:
    """Round to float32.

    Raises
    ------
    MethodError
        If a number is beyond float32; the text names the method, and what to do.
    """
    with np.errstate(over="ignore"):
        rounded = numbers.astype(np.float32)
    if not np.isfinite(rounded).all():
        raise MethodError(f"{method}: the scene has coordinates beyond float32 (3.4e38); {remedy}")
    return rounded
