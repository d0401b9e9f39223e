"""The edges of faces as they lie on the image, for a drawing on top of its samples.

Screen coordinates are those of the image: x to the right and y down, in pixels from its top left corner,
so that sample (row r, column c) lies at ``(c + 0.5, r + 0.5)``. They are rounded, and decide nothing.
"""

from __future__ import annotations

from typing import cast

import numpy as np

from hsr.base.arrays import Array, Floats, Ints, ranges
from hsr.problem.view import Placement, View
from hsr.scene.shapes import Polygons

NONE = np.zeros((0, 2, 3))
"""No segments."""


def outlines(view: View, faces: Ints) -> tuple[Array, Array]:
    """Project the edges of faces.

    A polygon has its sides. What bounds a curved face on the image is its outline, where lines of sight
    touch it, and the rims of its discs. What lies in front of the near plane is cut off.

    Parameters
    ----------
    view : View
        With its curved shapes.
    faces : (n,) int32
        Face ids, ascending.

    Returns
    -------
    points : (p, 2) float32
        Screen coordinates, each point once.
    ends : (m, 2) uint32
        The points that each edge joins, each edge once.
    """
    segments = np.concatenate([NONE, *(_of_object(view, placement, faces) for placement in view.placements)])
    ends = _on_screen(view, segments).astype(np.float32)
    points, place = np.unique(ends.view(np.complex64), return_inverse=True)
    edges = np.unique(np.sort(place.reshape(-1, 2), axis=1), axis=0).astype(np.uint32)
    return points.view(np.float32).reshape(-1, 2), edges


def _of_object(view: View, placement: Placement, faces: Ints) -> Floats:
    """Return the edges (n, 2, 3) of some of an object's faces in world space."""
    first, last = np.searchsorted(faces, [placement.first, placement.first + placement.shape.faces])
    chosen = faces[first:last] - placement.first
    if not len(chosen):
        return NONE
    shape = placement.shape
    if shape.quadric is not None:
        eye = np.asarray(np.linalg.solve(placement.world_from_object, _eye(view)), np.float64)
        seen = set(chosen.tolist())
        local = np.concatenate([NONE, *(curve for of, curve in shape.quadric.outline(eye) if of & seen)])
    else:
        local = _sides(cast(Polygons, shape.polygons), chosen)
    matrix = placement.world_from_object
    return local @ matrix[:3, :3].T + matrix[:3, 3]


def _sides(polygons: Polygons, chosen: Ints) -> Floats:
    """Return the sides (n, 2, 3) of the polygons of some faces."""
    place, following, _ = sides(polygons.start, np.flatnonzero(np.isin(polygons.face, chosen)))
    ends: Floats = polygons.vertices[polygons.corner[np.stack([place, following], axis=1)]]
    return ends


def sides(start: Array, chosen: Array) -> tuple[Array, Array, Array]:
    """Go round some polygons.

    Parameters
    ----------
    start : (P + 1,) int
        Where the corners of each polygon begin in a list of all corners, and end.
    chosen : (p,) int
        Numbers of polygons.

    Returns
    -------
    place, following : (n,) int64
        Places in that list of each side's two corners, in the order of the polygon.
    polygon : (n,) int64
        Place of its polygon in ``chosen``.
    """
    polygon, place = ranges(start[chosen], start[chosen + 1])
    first, end = start[chosen][polygon], start[chosen + 1][polygon]
    return place, np.where(place + 1 < end, place + 1, first), polygon


# ---------------------------------------------------------------- curved faces


def _eye(view: View) -> Floats:
    """Return where the lines of sight meet (x, y, z, w), in world space: x_clip = y_clip = w_clip = 0.

    That is a direction, with w = 0, for a parallel view.
    """
    eye: Floats = np.linalg.svd(view.clip_from_world[[0, 1, 3]])[2][3]
    return eye


# ---------------------------------------------------------------- projection


def _on_screen(view: View, segments: Floats) -> Floats:
    """Carry segments (n, 2, 3) of world space to the screen (m, 2, 2), less what lies before near."""
    beyond = segments @ view.depth_row[:3] + view.depth_row[3] - view.near
    kept = (beyond > 0.0).any(axis=1)
    a, b, before, after = segments[kept, 0], segments[kept, 1], beyond[kept, :1], beyond[kept, 1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = a + before / (before - after) * (b - a)
    cut = np.stack([np.where(before < 0.0, crossing, a), np.where(after < 0.0, crossing, b)], axis=1)
    x, y, _, w = np.moveaxis(cut @ view.clip_from_world[:, :3].T + view.clip_from_world[:, 3], -1, 0)
    return np.stack([(x / w + 1.0) * view.width / 2.0, (1.0 - y / w) * view.height / 2.0], axis=-1)
