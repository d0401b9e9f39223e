"""The exact problem: a scene seen by one camera at one size, as plain arrays.

A sample is a pixel centre. Sample (row r, column c) of a W x H image, row 0 at the top, has

    x_ndc = (2 c + 1) / W - 1        y_ndc = 1 - (2 r + 1) / H

in normalised device coordinates (x right, y up, both from -1 to 1).
"""

from __future__ import annotations

import hashlib
import operator
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from hsr.base.arrays import Floats, Ints
from hsr.base.errors import ViewError
from hsr.scene.camera import Projection, projection_of
from hsr.scene.files import shape_of
from hsr.scene.model import Camera, Light, Scene, exact_determinant
from hsr.scene.shapes import MAX_FACES, Polygons, Shape, tessellated
from hsr.scene.transforms import copies, placed

MAX_SIDE = 16384
"""Largest image width and height: what OpenGL drivers take."""

CULL = {"none": 0, "back": 1, "front": 2}
"""The numbers by which kernels know what an object culls."""


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


@dataclass(frozen=True, eq=False)
class Rays:
    """The ray of every sample, affine in its normalised device coordinates.

    Ray (x, y) starts at ``origin @ (1, x, y)`` and runs along ``direction @ (1, x, y)``; the
    parameter t of a point on it *is* the point's depth. The columns for x and y vanish in
    ``origin`` under perspective (all rays leave the eye) and in ``direction`` for a parallel view.

    Attributes
    ----------
    origin, direction : (3, 3) float64, world space
    """

    origin: Floats
    direction: Floats


@dataclass(frozen=True, eq=False)
class View:
    """A scene seen by one camera at one size: all that a method gets to know.

    Attributes
    ----------
    clip_from_world : (4, 4) float64
        OpenGL clip space; exact by definition.
    depth_row : (4,) float64
        The depth of a world point p is ``depth_row @ (p, 1)``, in scene units along the view
        axis; exact by definition.
    near, far : float
        A point is visible only where ``near <= depth <= far``; far may be infinite.
    width, height : int
    placements : tuple of Placement
        The objects in file order, copies expanded.
    segments : int
        Sides that stand for a full circle in :meth:`tessellated`.
    lights, background
        For the picture a person looks at; no method reads them.
    """

    clip_from_world: Floats
    depth_row: Floats
    near: float
    far: float
    width: int
    height: int
    placements: tuple[Placement, ...]
    segments: int = 48
    lights: tuple[Light, ...] = ()
    background: tuple[float, float, float] = (1.0, 1.0, 1.0)

    # ------------------------------------------------------------ camera

    @property
    def perspective(self) -> bool:
        """Whether lines of sight meet in an eye (else they are parallel)."""
        return bool(self.clip_from_world[3, :3].any())

    @cached_property
    def rays(self) -> Rays:
        """The rays of the samples, in world space."""
        x_row, y_row, _, w_row = self.clip_from_world
        if self.perspective:
            inverse = np.linalg.inv(np.stack([x_row[:3], y_row[:3], w_row[:3]]))
            eye = -inverse @ [x_row[3], y_row[3], w_row[3]]
            scale = np.linalg.norm(w_row[:3])
            direction = scale * inverse[:, [2, 0, 1]]
            return Rays(np.outer(eye, [1.0, 0.0, 0.0]), direction)
        inverse = np.linalg.inv(np.stack([x_row[:3], y_row[:3], self.depth_row[:3]]))
        constants = np.array([x_row[3], y_row[3], self.depth_row[3]])
        origin = np.stack([-inverse @ constants, w_row[3] * inverse[:, 0], w_row[3] * inverse[:, 1]], 1)
        return Rays(origin, np.outer(inverse[:, 2], [1.0, 0.0, 0.0]))

    # ------------------------------------------------------------ faces

    @property
    def faces(self) -> int:
        """Number of faces of all objects."""
        last = self.placements[-1]
        return last.first + last.shape.faces

    @cached_property
    def first_faces(self) -> Ints:
        """First face id (objects,) of every object, ascending."""
        return np.array([placement.first for placement in self.placements], dtype=np.int32)

    def object_of(self, face: Ints) -> Ints:
        """Object index of each face id; -1 for the background."""
        return (np.searchsorted(self.first_faces, face, side="right") - 1).astype(np.int32)

    @cached_property
    def manifest(self) -> list[dict[str, Any]]:
        """One entry an object: its name, shape and face ids (see ``VisibilityMap.manifest``)."""
        return [_manifest_entry(placement) for placement in self.placements]

    @property
    def curved(self) -> bool:
        """Whether any object has faces that are not planar."""
        return any(placement.shape.curved for placement in self.placements)

    def tessellated(self) -> View:
        """Return this view with every curved shape replaced by its polygons."""
        return self._tessellated if self.curved else self

    @cached_property
    def _tessellated(self) -> View:
        placements = [_planar(placement, self.segments) for placement in self.placements]
        return replace(self, placements=tuple(placements))

    @cached_property
    def polygons(self) -> WorldPolygons:
        """All planar faces in world space (rounded), in order of face id.

        Raises
        ------
        ViewError
            If a shape is curved; use ``view.tessellated().polygons``. If a vertex overflows.
        """
        return _join([_in_world(placement) for placement in self.placements])

    @property
    def triangles(self) -> Floats:
        """Corners (n, 3, 3) of all triangles in world space (rounded)."""
        polygons = self.polygons
        return polygons.vertices[polygons.triangle_vertex]

    @property
    def triangle_face(self) -> Ints:
        """Face id (n,) of every triangle."""
        return self.polygons.triangle_face

    # ------------------------------------------------------------ identity

    @cached_property
    def hashes(self) -> dict[str, str]:
        """SHA-256 of what is seen (``scene``), by what (``camera``), at what ``size``."""
        camera = [self.clip_from_world, self.depth_row, np.array([self.near, self.far])]
        return {
            "scene": _digest(_scene_parts(self.placements, self.segments)),
            "camera": _digest(array.tobytes() for array in camera),
            "size": _digest([f"{self.width}x{self.height}".encode()]),
        }


# ---------------------------------------------------------------- making a view


def view(scene: Scene, size: tuple[int, int] = (512, 512), camera: str | None = None) -> View:
    """See a scene by one of its cameras.

    Parameters
    ----------
    scene : Scene
    size : (width, height)
        Image size in pixels.
    camera : str, optional
        Name of the camera; the scene's first by default.

    Returns
    -------
    View

    Raises
    ------
    ViewError
        If the size is not two whole numbers in range, the scene has no such camera, or too many faces.

    Examples
    --------
    >>> import hsr
    >>> view = hsr.view(hsr.load("scenes/cube.toml"), size=(10, 8))
    >>> view.width, view.height, view.faces
    (10, 8, 6)
    >>> view.manifest[0]["faces"]
    ['top', 'bottom', 'right', 'left', 'front', 'back']
    """
    width, height = _checked_size(size)
    projection = _projected(_camera_named(scene, camera), width / height)
    return View(
        *projection,
        width,
        height,
        tuple(_placements(scene, projection.mirrored)),
        scene.segments,
        scene.light,
        scene.background,
    )


def _checked_size(size: Sequence[int]) -> tuple[int, int]:
    try:
        width, height = (operator.index(side) for side in size)
    except (TypeError, ValueError):
        raise ViewError(f"size {size!r}: expected two whole numbers, (width, height)") from None
    if not (1 <= width <= MAX_SIDE and 1 <= height <= MAX_SIDE):
        raise ViewError(f"size {width}x{height}: width and height must be from 1 to {MAX_SIDE}")
    return width, height


def _camera_named(scene: Scene, name: str | None) -> Camera:
    for camera in scene.camera:
        if name is None or camera.name == name:
            return camera
    names = ", ".join(camera.name for camera in scene.camera)
    raise ViewError(f"no camera is named {name!r}; the scene has {names}")


def _projected(camera: Camera, aspect: float) -> Projection:
    try:
        return projection_of(camera, aspect)
    except ViewError as error:
        raise ViewError(f"camera {camera.name!r}: {error}") from None


# ---------------------------------------------------------------- objects


def _placements(scene: Scene, mirrored: bool) -> Iterable[Placement]:
    first = 0
    for thing in scene.object:
        shape = shape_of(thing, scene.folder)
        for name, world_from_object in copies(thing):
            if first + shape.faces > MAX_FACES:
                raise ViewError(f"object {name!r}: more than {MAX_FACES} faces in the scene")
            flips = exact_determinant(world_from_object[:3, :3]) < 0
            yield Placement(
                name, shape, world_from_object, first, CULL[thing.cull], flips != mirrored, thing.colour
            )
            first += shape.faces


def _manifest_entry(placement: Placement) -> dict[str, Any]:
    shape = placement.shape
    entry = {"name": placement.name, "shape": shape.label, "first": placement.first, "count": shape.faces}
    return entry | ({"faces": list(shape.face_names)} if shape.face_names else {})


# ---------------------------------------------------------------- world space


def _planar(placement: Placement, segments: int) -> Placement:
    return replace(placement, shape=tessellated(placement.shape, segments))


def _in_world(placement: Placement) -> WorldPolygons:
    polygons = placement.shape.polygons
    if polygons is None:
        raise ViewError(f"object {placement.name!r} is curved; use view.tessellated()")
    matrix = placement.world_from_object
    with np.errstate(over="ignore", invalid="ignore"):
        vertices = placed(polygons.vertices, matrix[:3])
    if not np.isfinite(vertices).all():
        raise ViewError(
            f"object {placement.name!r}: its vertices overflow float64 in world space; scale it down"
        )
    corner = reversed_loops(polygons) if placement.mirrored else polygons.corner
    cull = np.full(len(polygons), placement.cull, dtype=np.int8)
    return WorldPolygons(vertices, corner, polygons.start, polygons.face + np.int32(placement.first), cull)


def reversed_loops(polygons: Polygons) -> Ints:
    """Corners of every polygon in opposite order, the first corner kept first."""
    start, end = polygons.start[:-1], polygons.start[1:]
    sides = end - start
    place = np.arange(len(polygons.corner)) - np.repeat(start, sides)
    mirrored = np.where(place == 0, 0, np.repeat(sides, sides) - place)
    return polygons.corner[np.repeat(start, sides) + mirrored]


def _join(parts: list[WorldPolygons]) -> WorldPolygons:
    if len(parts) == 1:
        return parts[0]
    vertex_offset = np.cumsum([0, *(len(part.vertices) for part in parts)])
    corner_offset = np.cumsum([0, *(len(part.corner) for part in parts)])
    corner = [part.corner + offset for part, offset in zip(parts, vertex_offset[:-1], strict=True)]
    start = [part.start[:-1] + offset for part, offset in zip(parts, corner_offset[:-1], strict=True)]
    return WorldPolygons(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate(corner).astype(np.int32),
        np.concatenate([*start, corner_offset[-1:]]).astype(np.int32),
        np.concatenate([part.face for part in parts]),
        np.concatenate([part.cull for part in parts]),
    )


# ---------------------------------------------------------------- identity


def _digest(parts: Iterable[bytes]) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(len(part).to_bytes(8, "little"))
        digest.update(part)
    return digest.hexdigest()


def _scene_parts(placements: tuple[Placement, ...], segments: int) -> Iterable[bytes]:
    if any(placement.shape.curved for placement in placements):
        yield f"segments {segments}".encode()
    shape_digests: dict[int, bytes] = {}
    for placement in placements:
        shape = placement.shape
        if id(shape) not in shape_digests:
            shape_digests[id(shape)] = _shape_digest(shape).encode()
        yield shape_digests[id(shape)]
        yield placement.world_from_object.tobytes()
        yield f"{placement.name} {placement.cull}".encode()


def _shape_digest(shape: Shape) -> str:
    return _digest(shape.content)
