"""From a visibility map to the pictures a person looks at, by one code for every method."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints, Pixels
from hsr.base.errors import HsrError
from hsr.pages.outlines import sides
from hsr.pictures.palette import to_bytes
from hsr.problem.map import BACKGROUND, VisibilityMap
from hsr.problem.view import Placement, View
from hsr.scene.model import Ambient, Directional, Light
from hsr.scene.shapes import Polygons


def shade(map: VisibilityMap, view: View) -> Pixels:
    """Paint what a map shows: Lambert's law for the scene's lights, no shadows.

    Every sample lies on its ray at the depth of the map. Normals are those of the scene's own
    shapes, exact on spheres and cylinders whatever the method put in their place, and turned toward
    the eye. The light that reaches the eye is ``c (sum of ambient + sum of light max(0, n . l))``
    with l the unit vector toward a directional or point light, which distance does not weaken.
    A scene without lights is painted by the facing ratio: ``c (n . v)``, v toward the eye.

    Object and background colours are taken as sRGB, as a person writes them; light is summed in
    linear intensities and encoded as sRGB. Light 1 on a face gives its colour as written. Only what
    occurs in the map is computed, so a million hidden faces cost nothing.

    Parameters
    ----------
    view : View
        The view that was rendered, with its curved shapes (not its tessellation).

    Returns
    -------
    (H, W, 3) uint8
        sRGB, row 0 at the top.

    Raises
    ------
    HsrError
        If map and view differ in size.
    """
    if map.face.shape != (view.height, view.width):
        raise HsrError(f"cannot shade a {map.width}x{map.height} map with a {view.width}x{view.height} view")
    picture = np.full((view.height, view.width, 3), view.background, dtype=np.float64)
    covered = map.face != BACKGROUND
    point, sight, normal, colour = _surface(map, view, covered)
    normal[np.vecdot(normal, sight) > 0.0] *= -1.0
    picture[covered] = _encode(_decode(colour) * _light(view.lights, point, normal, sight))
    return to_bytes(picture)


def facing(map: VisibilityMap, view: View) -> Array:
    """Tell whether each sample shows the front or the back of its face.

    The front is the side that the outward normal points to, taken where the face is seen: of spheres and
    cylinders both sides can be. Computed with rounding, for pictures.

    Parameters
    ----------
    view : View
        The view that was rendered, with its curved shapes.

    Returns
    -------
    (H, W) int8
        1 for the front, -1 for the back, 0 for the background.
    """
    facing = np.zeros(map.face.shape, dtype=np.int8)
    covered = map.face != BACKGROUND
    _, sight, normal, _ = _surface(map, view, covered)
    facing[covered] = np.where(np.vecdot(normal, sight) < 0.0, 1, -1)
    return facing


def _surface(map: VisibilityMap, view: View, covered: Bools) -> tuple[Floats, Floats, Floats, Floats]:
    """Return what the covered samples show, in world space, each (n, 3).

    That is the point, the unit direction in which the eye sees it, the outward unit normal, and the colour.
    """
    rows, columns = np.nonzero(covered)
    x, y = (2 * columns + 1) / view.width - 1.0, 1.0 - (2 * rows + 1) / view.height
    ndc = np.stack([np.ones_like(x), x, y], axis=1)
    sight = ndc @ view.rays.direction.T
    point = ndc @ view.rays.origin.T + map.depth[covered][:, None] * sight
    normal, colour = np.empty_like(point), np.empty_like(point)
    face = map.face[covered]
    owner = view.object_of(face)
    by_owner = np.argsort(owner, kind="stable")
    owners, first = np.unique(owner[by_owner], return_index=True)
    for number, samples in zip(owners, np.split(by_owner, first[1:]), strict=False):  # none if all is empty
        placement = view.placements[number]
        normal[samples] = _normals(placement, face[samples] - placement.first, point[samples])
        colour[samples] = placement.colour
    return point, _unit(sight), normal, colour


def _normals(placement: Placement, face: Ints, point: Floats) -> Floats:
    """Return outward unit normals (n, 3) in world space, carried there by the inverse transpose."""
    inverse = np.linalg.inv(placement.world_from_object[:3, :3])
    shape = placement.shape
    if shape.quadric is None:
        polygons = cast(Polygons, shape.polygons)
        seen, which = np.unique(face, return_inverse=True)
        polygon = np.searchsorted(polygons.face, seen)
        return _unit(_newell(polygons, polygon) @ inverse)[which]
    local = (point - placement.world_from_object[:3, 3]) @ inverse.T
    # A quadratic form grows along its gradient, and what an end is of falls outward.
    form, ends = shape.quadric.rounded[:3], shape.quadric.ends[:, :3].astype(np.float64)
    normal = local @ form[:, :3] + form[:, 3]
    normal[face > 0] = -ends[face[face > 0] - 1]
    return _unit(normal @ inverse)


def _newell(polygons: Polygons, chosen: Array) -> Floats:
    """Return normals (n, 3) of some polygons by Newell's method, in object space, of any length."""
    place, following, polygon = sides(polygons.start, chosen)
    vertices, corner = polygons.vertices, polygons.corner
    origin = vertices[corner[polygons.start[chosen]]][polygon]  # far polygons would lose digits without
    crosses = np.cross(vertices[corner[place]] - origin, vertices[corner[following]] - origin)
    return np.add.reduceat(crosses, np.flatnonzero(np.diff(polygon, prepend=-1)))


def _light(lights: Sequence[Light], point: Floats, normal: Floats, sight: Floats) -> Floats:
    """Linear intensity (n, 3) that each sample sends to the eye, for a white surface."""
    if not lights:
        return np.repeat(-np.vecdot(normal, sight)[:, None], 3, axis=1)
    total = np.zeros_like(point)
    for light in lights:
        if isinstance(light, Ambient):
            total += light.colour
            continue
        if isinstance(light, Directional):
            toward = -_unit(np.array([light.direction]))
        else:
            toward = _unit(np.array(light.position) - point)
        total += np.maximum(np.vecdot(normal, toward), 0.0)[:, None] * light.colour
    return total


def _unit(vectors: Floats) -> Floats:
    """Vectors of length 1; a vector of length 0 (a degenerate face) stays as it is."""
    # Scaled to about 1 first: the squares of large and small numbers leave the range of float64.
    least = np.nextafter(0.0, 1.0)
    scaled = vectors / np.maximum(np.abs(vectors).max(axis=-1, keepdims=True), least)
    unit: Floats = scaled / np.maximum(np.linalg.norm(scaled, axis=-1, keepdims=True), least)
    return unit


def _decode(srgb: Floats) -> Floats:
    """Linear intensities of sRGB values (IEC 61966-2-1)."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def _encode(linear: Floats) -> Floats:
    """Return the sRGB values of linear intensities, those above 1 cut off (IEC 61966-2-1)."""
    linear = np.minimum(linear, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
