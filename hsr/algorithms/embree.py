"""Embree as a method: the float32 rays of a view traced through one of three interfaces.

``embreex`` is that package's own: it hands over one ray after another, on one thread. ``single`` and
``packets`` call the library inside it, one ray or 4 x 4 coherent ones at a time, on Numba's threads; see
:mod:`hsr.embree.library`. The rays are the same. Embree counts distances in units of the
direction as given, so that t is a depth. A ray starts at its point at near: embreex has no other way to
begin later than at its origin.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, TypeVar

import numpy as np

from hsr.algorithms.prepare import choices
from hsr.base.arrays import Array, Floats, Ints
from hsr.base.errors import UnavailableError
from hsr.base.jit import thread_count
from hsr.embree import library
from hsr.embree.packets import PACKET_SIDE, Sight
from hsr.problem.geometry import as_float32
from hsr.problem.map import BACKGROUND, Clock, VisibilityMap, depth_format
from hsr.problem.view import CULL, View, WorldPolygons
from hsr.scene.transforms import placed

INTERFACES = ("embreex", "single", "packets")

Made = TypeVar("Made")

RAYS_AT_ONCE = 2**16
"""How many rays are handed to embreex at once: few enough to stay in the processor's cache."""

RELATIVE_STEP = 2.0**-23
"""Distance of neighbouring float32 numbers, relative to them, at most."""


@dataclass(frozen=True)
class Options:
    """How Embree is asked. Its scene is always the robust one, the fairest to compare with.

    Attributes
    ----------
    interface : {"embreex", "single", "packets"}
        embreex's own API, the library's ``rtcIntersect1``, or its ``rtcIntersect16``.
    """

    interface: str = "embreex"

    def __post_init__(self) -> None:
        choices.check("embree", self, {"interface": INTERFACES})


def render(view: View, options: Options) -> VisibilityMap:
    """Trace the ray of every sample with Embree.

    Near and far are closed, as the view has them. Where two faces are equally deep, the owner is
    whichever Embree finds.

    Parameters
    ----------
    view : View
        Curved shapes are tessellated. Embree culls nothing: culled triangles are left out.
    options : Options

    Returns
    -------
    VisibilityMap
        ``seconds``: ``prepare`` rounds the triangles to float32, ``build`` has Embree sort them into
        its hierarchy, both once a scene unless something is culled, ``render`` makes the rays, traces them
        and notes what they hit. ``work``: ``rays``, ``triangles``.

    Raises
    ------
    UnavailableError
        If embreex is not installed, or holds another version of the library than is known.
    MethodError
        If a coordinate is beyond float32.
    """
    interface = _Embreex() if options.interface == "embreex" else _Library(options.interface == "packets")
    clock = Clock()
    with clock("prepare"):
        vertices, corner, face = handed_over(view)
        face_of = np.append(face, np.int32(BACKGROUND))  # Embree numbers a miss -1: the last entry
    with clock("build"):
        scene = _once(view, (type(interface), interface.threads), lambda: interface.build(vertices, corner))
    with clock("render"):
        face, depth = interface.trace(scene, view, face_of)
    work = {"rays": view.width * view.height, "triangles": len(corner)}
    return VisibilityMap(face, depth, "embree", work, clock.seconds, _notes(view, interface))


def handed_over(view: View) -> tuple[Array, Ints, Ints]:
    """Return the triangles that Embree gets.

    Parameters
    ----------
    view : View

    Returns
    -------
    vertices : (V, 3) float32, world space
    corner : (n, 3) int32
    face : (n,) int32

    Raises
    ------
    MethodError
        If a coordinate is beyond float32.
    """
    return _once(view, "handed over", lambda: _handed_over(view, view.tessellated().polygons))


def _once(view: View, what: Hashable, make: Callable[[], Made]) -> Made:
    """Make something of the triangles once a scene; for each picture where the camera says what is culled."""
    geometry = view.tessellated().geometry
    return make() if geometry.polygons.cull.any() else geometry.once(("embree", what), make)


def _handed_over(view: View, polygons: WorldPolygons) -> tuple[Array, Ints, Ints]:
    kept = _facing_the_right_way(view, polygons)
    corner = np.ascontiguousarray(polygons.triangle_vertex[kept])
    return as_float32(polygons.vertices, "embree"), corner, polygons.triangle_face[kept]


def _facing_the_right_way(view: View, polygons: WorldPolygons) -> Array:
    """Return the indices of the triangles that culling leaves.

    A triangle turns counter-clockwise on the screen, its front to the eye, if the determinant of
    its corners' (x, y, w) is positive (Olano and Greer 1997, *Triangle Scan Conversion using 2D
    Homogeneous Coordinates*). One seen edge-on shows neither side.
    """
    cull = polygons.cull[polygons.triangle_polygon]
    if not cull.any():
        return np.arange(len(cull))
    projected = placed(polygons.vertices, view.clip_from_world[[0, 1, 3]])
    facing = np.linalg.det(projected[polygons.triangle_vertex])
    shown = {CULL["none"]: np.ones(len(cull), bool), CULL["back"]: facing > 0, CULL["front"]: facing < 0}
    return np.flatnonzero(np.choose(cull, [shown[k] for k in range(3)]))


def rays(view: View) -> Iterator[tuple[slice, Array, Array]]:
    """Yield bands of rows with their rays: origins at near and directions, (n, 3) float32 each."""
    sight, band = _sight(view), max(RAYS_AT_ONCE // view.width, 1)
    for top in range(0, view.height, band):
        rows = slice(top, min(top + band, view.height))
        whole = sight.of_row.T[rows, None] + sight.of_column.T[: view.width]
        whole = as_float32(whole.reshape(-1, 6), "embree")
        yield rows, np.ascontiguousarray(whole[:, :3]), np.ascontiguousarray(whole[:, 3:])


def _sight(view: View) -> Sight:
    """Return the rays of a view, from near on; there are rows and columns for whole packets."""
    x = (2.0 * np.arange(view.width + PACKET_SIDE) + 1.0) / view.width - 1.0
    y = 1.0 - (2.0 * np.arange(view.height + PACKET_SIDE) + 1.0) / view.height
    origin, direction = view.rays.origin + view.near * view.rays.direction, view.rays.direction
    whole = np.concatenate([origin, direction])
    of_row, of_column = whole[:, :1] + whole[:, 2:] * y, whole[:, 1:2] * x
    return Sight(of_row, of_column, view.near, np.float32(view.far - view.near))


# ---------------------------------------------------------------- interfaces


class _Embreex:
    """embreex's own API."""

    threads = 1

    def __init__(self) -> None:
        try:
            from embreex import mesh_construction, rtcore_scene
        except ImportError as error:
            raise UnavailableError(
                f"embreex cannot be loaded ({error}); pip install 'hsr-lab[embree]'"
            ) from error
        self.rtcore_scene, self.mesh_construction = rtcore_scene, mesh_construction
        self.driver = f"embreex {version('embreex')}"

    def build(self, vertices: Array, corner: Ints) -> Any:
        """Have the hierarchy built now: embreex does so at the first ray it is given."""
        scene, ray = self.rtcore_scene.EmbreeScene(robust=True), np.ones((1, 3), dtype=np.float32)
        self.mesh_construction.TriangleMesh(scene, vertices, corner)
        scene.run(ray, ray)
        return scene

    def trace(self, scene: Any, view: View, face_of: Ints) -> tuple[Ints, Floats]:
        """Return face and depth (H, W) of the nearest hit of each sample's ray."""
        triangle = np.empty((view.height, view.width), dtype=np.int32)
        depth = np.empty((view.height, view.width))
        for rows, origins, directions in rays(view):
            hits = scene.run(origins, directions, dists=view.far - view.near, output=True)
            triangle[rows] = hits["primID"].reshape(-1, view.width)
            depth[rows] = view.near + hits["tfar"].reshape(-1, view.width).astype(np.float64)
        depth[triangle < 0] = np.inf
        return face_of[triangle], depth


class _Library:
    """The library's own interface, for single rays or packets of them."""

    def __init__(self, packets: bool) -> None:
        self.packets, self.threads = packets, thread_count()
        self.device = library.device(self.threads)
        self.driver = f"Embree {library.version(self.device)}"

    def build(self, vertices: Array, corner: Ints) -> library.Scene:
        """Have the hierarchy built."""
        return library.Scene(self.device, vertices, corner)

    def trace(self, scene: library.Scene, view: View, face_of: Ints) -> tuple[Ints, Floats]:
        """Return face and depth (H, W) of the nearest hit of each sample's ray."""
        return scene.trace(_sight(view), self.packets, face_of, (view.height, view.width))


def _notes(view: View, interface: _Embreex | _Library) -> dict[str, Any]:
    return {
        "driver": interface.driver,
        "threads": interface.threads,
        "depth_format": depth_format("distance", RELATIVE_STEP, view.near, view.far, view.perspective),
    }
