"""From a visibility map to the pictures a person looks at, by one code for every method."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np

from hsr.base.arrays import Array, Floats, Ints, Pixels
from hsr.base.errors import HsrError
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
    map : VisibilityMap
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
    picture = np.empty((view.height, view.width, 3), dtype=np.float64)
    picture[:] = view.background
    rows, columns = np.nonzero(map.face != BACKGROUND)
    if len(rows):
        face = map.face[rows, columns]
        point, sight = _points(view, rows, columns, map.depth[rows, columns])
        normal, colour = _surface(view, face, point)
        normal[_dot(normal, sight) > 0.0] *= -1.0
        intensity = _light(view.lights, point, normal, sight)
        picture[rows, columns] = _encode(_decode(colour) * intensity)
    return to_bytes(picture)


def facing(map: VisibilityMap, view: View) -> Array:
    """Tell whether each sample shows the front or the back of its face.

    The front is the side that the outward normal points to, taken where the face is seen: of spheres and
    cylinders both sides can be. Computed with rounding, for pictures.

    Parameters
    ----------
    map : VisibilityMap
    view : View
        The view that was rendered, with its curved shapes.

    Returns
    -------
    (H, W) int8
        1 for the front, -1 for the back, 0 for the background.
    """
    facing = np.zeros(map.face.shape, dtype=np.int8)
    rows, columns = np.nonzero(map.face != BACKGROUND)
    if len(rows):
        point, sight = _points(view, rows, columns, map.depth[rows, columns])
        normal, _ = _surface(view, map.face[rows, columns], point)
        facing[rows, columns] = np.where(_dot(normal, sight) < 0.0, 1, -1)
    return facing


def _points(view: View, rows: Array, columns: Array, depth: Floats) -> tuple[Floats, Floats]:
    """World point (n, 3) of each sample, and the unit direction (n, 3) in which the eye sees it."""
    x = (2 * columns + 1) / view.width - 1.0
    y = 1.0 - (2 * rows + 1) / view.height
    ndc = np.stack([np.ones_like(x), x, y], axis=1)
    origin, direction = ndc @ view.rays.origin.T, ndc @ view.rays.direction.T
    return origin + depth[:, None] * direction, _unit(direction)


def _surface(view: View, face: Ints, point: Floats) -> tuple[Floats, Floats]:
    """Return outward unit normals (n, 3) in world space, and colours (n, 3)."""
    normal, colour = np.empty_like(point), np.empty_like(point)
    owner = view.object_of(face)
    by_object = np.argsort(owner, kind="stable")
    starts = np.flatnonzero(np.diff(owner[by_object])) + 1
    for samples in np.split(by_object, starts):
        placement = view.placements[owner[samples[0]]]
        normal[samples] = _normals(placement, face[samples] - placement.first, point[samples])
        colour[samples] = placement.colour
    return normal, colour


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
    start = polygons.start[chosen]
    sides = polygons.start[chosen + 1] - start
    first = np.cumsum(sides) - sides  # where each polygon's corners begin among all those chosen
    side = np.arange(sides.sum()) - np.repeat(first, sides)
    following = (side + 1) % np.repeat(sides, sides)

    def corners(k: Array) -> Floats:
        return polygons.vertices[polygons.corner[np.repeat(start, sides) + k]]

    origin = corners(np.zeros_like(side))  # relative to a corner, or far polygons would lose digits
    return np.add.reduceat(np.cross(corners(side) - origin, corners(following) - origin), first)


def _light(lights: Sequence[Light], point: Floats, normal: Floats, sight: Floats) -> Floats:
    """Linear intensity (n, 3) that each sample sends to the eye, for a white surface."""
    if not lights:
        return np.repeat(-_dot(normal, sight)[:, None], 3, axis=1)
    total = np.zeros_like(point)
    for light in lights:
        if isinstance(light, Ambient):
            total += light.colour
            continue
        if isinstance(light, Directional):
            toward = -_unit(np.array([light.direction]))
        else:
            toward = _unit(np.array(light.position) - point)
        total += np.maximum(_dot(normal, toward), 0.0)[:, None] * light.colour
    return total


def _dot(a: Floats, b: Floats) -> Floats:
    product: Floats = np.sum(a * b, axis=-1)
    return product


def _unit(vectors: Floats) -> Floats:
    """Vectors of length 1; a vector of length 0 (a degenerate face) stays as it is."""
    # Scaled to about 1 first: the squares of large and small numbers leave the range of float64.
    largest = np.abs(vectors).max(axis=-1, keepdims=True)
    scaled = np.divide(vectors, largest, out=np.zeros_like(vectors), where=largest > 0.0)
    length = np.linalg.norm(scaled, axis=-1, keepdims=True)
    unit: Floats = np.divide(scaled, length, out=scaled, where=length > 0.0)
    return unit


def _decode(srgb: Floats) -> Floats:
    """Linear intensities of sRGB values (IEC 61966-2-1)."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def _encode(linear: Floats) -> Floats:
    """Return the sRGB values of linear intensities, those above 1 cut off (IEC 61966-2-1)."""
    linear = np.minimum(linear, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
