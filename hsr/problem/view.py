"""The exact problem: a scene seen by one camera at one size, as plain arrays.

A sample is a pixel centre. Sample (row r, column c) of a W x H image, row 0 at the top, has

    x_ndc = (2 c + 1) / W - 1        y_ndc = 1 - (2 r + 1) / H

in normalised device coordinates (x right, y up, both from -1 to 1).
"""

from __future__ import annotations

import operator
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from hsr.base.arrays import Floats, Ints
from hsr.base.errors import ViewError, named
from hsr.base.files import digest_of
from hsr.problem.geometry import CULL, Geometry, Placement, WorldPolygons, geometry_of
from hsr.scene.camera import named_projection
from hsr.scene.files import load
from hsr.scene.model import Camera, Light, MatrixCamera, Orthographic, Perspective, Scene

__all__ = [
    "CULL",
    "MatrixCamera",
    "Orthographic",
    "Perspective",
    "Placement",
    "Rays",
    "Scene",
    "View",
    "WorldPolygons",
    "load",
    "view",
]

MAX_SIDE = 16384
"""Largest image width and height: what OpenGL drivers take."""


class Rays(NamedTuple):
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

    def __post_init__(self) -> None:
        if not isinstance(self.placements, Geometry):
            object.__setattr__(self, "placements", Geometry(self.placements))

    # ------------------------------------------------------------ camera

    @property
    def perspective(self) -> bool:
        """Whether lines of sight meet in an eye (else they are parallel)."""
        return bool(self.clip_from_world[3, :3].any())

    @cached_property
    def rays(self) -> Rays:
        """The rays of the samples, in world space."""
        x_row, y_row, _, w_row = self.clip_from_world
        rows = np.stack([x_row, y_row, w_row if self.perspective else self.depth_row])
        inverse = np.linalg.inv(rows[:, :3])
        start = -inverse @ rows[:, 3].copy()
        if self.perspective:
            scale = np.linalg.norm(w_row[:3])
            return Rays(np.outer(start, [1.0, 0.0, 0.0]), scale * inverse[:, [2, 0, 1]])
        origin = np.stack([start, w_row[3] * inverse[:, 0], w_row[3] * inverse[:, 1]], 1)
        return Rays(origin, np.outer(inverse[:, 2], [1.0, 0.0, 0.0]))

    # ------------------------------------------------------------ faces

    @property
    def geometry(self) -> Geometry:
        """The objects, with all that was made of them once for all views."""
        assert isinstance(self.placements, Geometry), "made one from the start"
        return self.placements

    @property
    def faces(self) -> int:
        """Number of faces of all objects."""
        last = self.placements[-1]
        return last.first + last.shape.faces

    @property
    def first_faces(self) -> Ints:
        """First face id (objects,) of every object, ascending."""
        return self.geometry.first_faces

    def object_of(self, face: Ints) -> Ints:
        """Object index of each face id; -1 for the background."""
        return (np.searchsorted(self.first_faces, face, side="right") - 1).astype(np.int32)

    @property
    def manifest(self) -> list[dict[str, Any]]:
        """One entry an object: its name, shape and face ids (see ``VisibilityMap.manifest``)."""
        return self.geometry.manifest

    @property
    def curved(self) -> bool:
        """Whether any object has faces that are not planar."""
        return self.geometry.curved

    def tessellated(self) -> View:
        """Return this view with every curved shape replaced by its polygons."""
        return self._tessellated if self.curved else self

    @cached_property
    def _tessellated(self) -> View:
        return replace(self, placements=self.geometry.tessellated(self.segments))

    @cached_property
    def polygons(self) -> WorldPolygons:
        """All planar faces in world space (rounded), in order of face id.

        Raises
        ------
        ViewError
            If a shape is curved; use ``view.tessellated().polygons``. If a vertex overflows.
        """
        return self.geometry.polygons

    @property
    def triangles(self) -> Floats:
        """Corners (n, 3, 3) of all triangles in world space (rounded)."""
        return self.geometry.triangles

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
            "scene": self.geometry.digest(self.segments),
            "camera": digest_of(array.tobytes() for array in camera),
            "size": digest_of([f"{self.width}x{self.height}".encode()]),
        }


# ---------------------------------------------------------------- making a view


def view(scene: Scene, size: tuple[int, int] = (512, 512), camera: str | Camera | None = None) -> View:
    """See a scene by a camera. All views of a scene share its geometry.

    Parameters
    ----------
    scene : Scene
    size : (width, height)
        Image size in pixels.
    camera : str, Perspective, Orthographic or MatrixCamera, optional
        One of the scene's by its name, or any other; the scene's first by default.

    Raises
    ------
    ViewError
        If the size is not two whole numbers in range, the scene has no such camera, or too many faces.

    Examples
    --------
    >>> import hsr
    >>> scene = hsr.load("scenes/cube.toml")
    >>> view = hsr.view(scene, size=(10, 8))
    >>> view.width, view.height, view.faces
    (10, 8, 6)
    >>> view.manifest[0]["faces"]
    ['top', 'bottom', 'right', 'left', 'front', 'back']
    >>> hsr.view(scene, (10, 8), hsr.Perspective(eye=(2, 2, 4))).geometry is view.geometry
    True
    """
    width, height = _checked_size(size)
    seen_by = camera_named(scene, camera) if camera is None or isinstance(camera, str) else camera
    projection, geometry = named_projection(seen_by, width / height), geometry_of(scene)
    if projection.mirrored:
        geometry = geometry.mirror_image
    return View(*projection, width, height, geometry, scene.segments, scene.light, scene.background)


def _checked_size(size: Sequence[int]) -> tuple[int, int]:
    try:
        width, height = (operator.index(side) for side in size)
    except (TypeError, ValueError):
        raise ViewError(f"size {size!r}: expected two whole numbers, (width, height)") from None
    if not (1 <= width <= MAX_SIDE and 1 <= height <= MAX_SIDE):
        raise ViewError(f"size {width}x{height}: width and height must be from 1 to {MAX_SIDE}")
    return width, height


def camera_named(scene: Scene, name: str | None = None) -> Camera:
    """Return a camera of a scene, its first without a name.

    Raises
    ------
    ViewError
        If there is none.
    """
    if not scene.camera:
        raise ViewError("the scene has no camera; give one: camera=hsr.Perspective(eye=(2, 2, 4))")
    cameras = {camera.name: camera for camera in scene.camera}
    first = scene.camera[0]
    return first if name is None else named(name, cameras, "no camera is named", ViewError, "the scene has")
