"""The edges of faces as they lie on the image, for a drawing on top of its samples.

Screen coordinates are those of the image: x to the right and y down, in pixels from its top left corner,
so that sample (row r, column c) lies at ``(c + 0.5, r + 0.5)``. They are rounded, and decide nothing.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.problem.view import Placement, View
from hsr.scene.shapes import Kind, Polygons

ARCS = 180
"""Straight pieces in which a circle is drawn; they leave it by 1 - cos(pi / 180) = 0.00015 of its radius."""

NONE = np.zeros((0, 2, 3))
"""No segments."""

SIDE, BASE, CAP = range(3)
"""The faces of a cylinder."""


def outlines(view: View, faces: Ints) -> tuple[Array, Array]:
    """Project the edges of faces.

    A polygon has its sides. What bounds a curved face on the image is its outline, where lines of sight
    touch it, and the rims of a cylinder. What lies in front of the near plane is cut off.

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
    if placement.shape.polygons is not None:
        local = _sides(placement.shape.polygons, chosen)
    else:
        local = np.concatenate([NONE, *_curves(placement, _eye(view), chosen)])
    matrix = placement.world_from_object
    return local @ matrix[:3, :3].T + matrix[:3, 3]


def _sides(polygons: Polygons, chosen: Ints) -> Floats:
    """Return the sides (n, 2, 3) of the polygons of some faces."""
    corner, start = polygons.corner, polygons.start
    after = np.arange(1, len(corner) + 1)
    after[start[1:] - 1] = start[:-1]
    used = np.repeat(np.isin(polygons.face, chosen), np.diff(start))
    return polygons.vertices[np.stack([corner, corner[after]], axis=1)[used]]


# ---------------------------------------------------------------- curved faces


def _eye(view: View) -> Floats:
    """Return where the lines of sight meet (x, y, z, w), in world space: x_clip = y_clip = w_clip = 0.

    That is a direction, with w = 0, for a parallel view.
    """
    eye: Floats = np.linalg.svd(view.clip_from_world[[0, 1, 3]])[2][3]
    return eye


def _curves(placement: Placement, eye: Floats, chosen: Ints) -> Iterator[Floats]:
    """Yield the curves that bound curved faces on the image, as segments (n, 2, 3) in object space."""
    x, y, z, w = np.linalg.solve(placement.world_from_object, eye)
    if placement.shape.kind == Kind.SPHERE:
        yield from _horizon(np.array([x, y, z]), w)
        return
    if SIDE in chosen:
        yield from _generators(x, y, w)
    if SIDE in chosen or BASE in chosen:
        yield _circle(np.zeros(3), np.eye(3)[0], np.eye(3)[1])
    if SIDE in chosen or CAP in chosen:
        yield _circle(np.eye(3)[2], np.eye(3)[0], np.eye(3)[1])


def _horizon(e: Floats, w: float) -> Iterator[Floats]:
    """Yield the circle in which lines of sight touch the unit sphere: p . e = w and |p| = 1.

    None from inside.
    """
    distance = np.linalg.norm(e)
    if abs(w) >= distance:
        return
    axis, height = e / distance, w / distance
    u = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    u *= np.sqrt(1.0 - height**2) / np.linalg.norm(u)
    yield _circle(height * axis, u, np.cross(axis, u))


def _generators(x: float, y: float, w: float) -> Iterator[Floats]:
    """Yield the two lines in which lines of sight touch the unit cylinder: x_p x + y_p y = w.

    None from within the infinite cylinder, or along its axis.
    """
    distance = np.hypot(x, y)
    if abs(w) >= distance:
        return
    for angle in np.arctan2(y, x) + np.arccos(w / distance) * np.array([1.0, -1.0]):
        foot = np.array([np.cos(angle), np.sin(angle), 0.0])
        yield np.array([[foot, foot + np.eye(3)[2]]])


def _circle(centre: Floats, u: Floats, v: Floats) -> Floats:
    """Return the pieces (ARCS, 2, 3) of a circle with two perpendicular radii."""
    angle = np.linspace(0.0, 2.0 * np.pi, ARCS + 1)[:, None]
    points = centre + np.cos(angle) * u + np.sin(angle) * v
    return np.stack([points[:-1], points[1:]], axis=1)


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
