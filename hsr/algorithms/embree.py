"""Embree as a method: the rays of a view traced through embreex's own API.

embreex hands Embree one float32 ray after another, on one thread. Embree counts distances in
units of the direction as given, so that t is a depth. A ray starts at its point at near: embreex
has no other way to begin later than at its origin.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from types import ModuleType
from typing import Any

import numpy as np

from hsr.arrays import Array, Floats, Ints
from hsr.errors import MethodError, UnavailableError
from hsr.viewing import CULL, View, WorldPolygons
from hsr.visibility import BACKGROUND, Clock, VisibilityMap, depth_format

RAYS_AT_ONCE = 2**16
"""How many rays are handed to embreex at once: few enough to stay in the processor's cache."""

RELATIVE_STEP = 2.0**-23
"""Distance of neighbouring float32 numbers, relative to them, at most."""


@dataclass(frozen=True)
class Options:
    """Embree has no options: its scene is always the robust one, the fairest to compare with."""


def render(view: View, options: Options) -> VisibilityMap:  # noqa: ARG001
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
        its hierarchy, ``render`` makes the rays and traces them. ``work``: ``rays``, ``triangles``.

    Raises
    ------
    UnavailableError
        If embreex is not installed.
    MethodError
        If a coordinate is beyond float32.
    """
    rtcore_scene, mesh_construction = _embreex()
    clock = Clock()
    with clock("prepare"):
        vertices, corner, face = handed_over(view)
        face_of = np.append(face, np.int32(BACKGROUND))
    with clock("build"):
        scene = rtcore_scene.EmbreeScene(robust=True)
        mesh_construction.TriangleMesh(scene, vertices, corner)
        _commit(scene)
    with clock("render"):
        triangle, depth = _trace(scene, view)
        face = face_of[triangle]  # Embree numbers a miss -1: the last entry
    work = {"rays": view.width * view.height, "triangles": len(corner)}
    return VisibilityMap(face, depth, "embree", work, clock.seconds, _notes(view))


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
    polygons = view.tessellated().polygons
    kept = _facing_the_right_way(view, polygons)
    corner = np.ascontiguousarray(polygons.triangle_vertex[kept])
    return _as_float32(polygons.vertices), corner, polygons.triangle_face[kept]


def _embreex() -> tuple[ModuleType, ModuleType]:
    try:
        from embreex import mesh_construction, rtcore_scene
    except ImportError as error:
        raise UnavailableError(
            f"embreex cannot be loaded ({error}); pip install 'hsr-lab[embree]'"
        ) from error
    return rtcore_scene, mesh_construction


def _facing_the_right_way(view: View, polygons: WorldPolygons) -> Array:
    """Return the indices of the triangles that culling leaves.

    A triangle turns counter-clockwise on the screen, its front to the eye, if the determinant of
    its corners' (x, y, w) is positive (Olano and Greer 1997, *Triangle Scan Conversion using 2D
    Homogeneous Coordinates*). One seen edge-on shows neither side.
    """
    cull = polygons.cull[polygons.triangle_polygon]
    if not cull.any():
        return np.arange(len(cull))
    rows = view.clip_from_world[[0, 1, 3]]
    projected = polygons.vertices @ rows[:, :3].T + rows[:, 3]
    facing = np.linalg.det(projected[polygons.triangle_vertex])
    shown = {CULL["none"]: np.ones(len(cull), bool), CULL["back"]: facing > 0, CULL["front"]: facing < 0}
    return np.flatnonzero(np.choose(cull, [shown[k] for k in range(3)]))


def _as_float32(numbers: Floats) -> Array:
    with np.errstate(over="ignore"):
        rounded = numbers.astype(np.float32)
    if not np.isfinite(rounded).all():
        raise MethodError("embree: the scene has coordinates beyond float32 (3.4e38); scale it down")
    return rounded


def _commit(scene: Any) -> None:
    """Have the hierarchy built now: embreex does so at the first ray it is given."""
    ray = np.ones((1, 3), dtype=np.float32)
    scene.run(ray, ray)


def _trace(scene: Any, view: View) -> tuple[Ints, Floats]:
    """Triangle (H, W) and depth (H, W) of the nearest hit of each sample's ray; -1 and +inf for a miss."""
    triangle = np.empty((view.height, view.width), dtype=np.int32)
    depth = np.empty((view.height, view.width))
    for rows, origins, directions in rays(view):
        hits = scene.run(origins, directions, dists=view.far - view.near, output=True)
        triangle[rows] = hits["primID"].reshape(-1, view.width)
        depth[rows] = view.near + hits["tfar"].reshape(-1, view.width).astype(np.float64)
    depth[triangle < 0] = np.inf
    return triangle, depth


def rays(view: View) -> Iterator[tuple[slice, Array, Array]]:
    """Yield bands of rows with their rays: origins at near and directions, (n, 3) float32 each."""
    sight = view.rays
    at_near = sight.origin + view.near * sight.direction
    x = (2.0 * np.arange(view.width) + 1.0) / view.width - 1.0
    band = max(RAYS_AT_ONCE // view.width, 1)
    for top in range(0, view.height, band):
        y = 1.0 - (2.0 * np.arange(top, min(top + band, view.height)) + 1.0) / view.height
        yield slice(top, top + band), _at_samples(at_near, x, y), _at_samples(sight.direction, x, y)


def _at_samples(vectors: Floats, x: Floats, y: Floats) -> Array:
    """Evaluate ``vectors @ (1, x, y)`` at every y and x: (len(y) * len(x), 3) float32."""
    of_row = vectors[:, 0] + y[:, None] * vectors[:, 2]
    of_column = x[:, None] * vectors[:, 1]
    return _as_float32(of_row[:, None] + of_column).reshape(-1, 3)


def _notes(view: View) -> dict[str, Any]:
    return {
        "driver": f"embreex {version('embreex')}",
        "threads": 1,
        "depth_format": depth_format("distance", RELATIVE_STEP, view.near, view.far, view.perspective),
    }
