"""Clipping of convex polygons in clip space, before the divide.

The method of Sutherland & Hodgman, *Reentrant Polygon Clipping* (Communications of the ACM 17, 1974):
the polygon is cut by one plane of the view volume after the other. The volume is closed: a corner on a
plane is inside. Planes act on the points (x, y, d, 1) of clip space, see
:mod:`hsr.kernels.projection`.

Two neighbours must cut the edge they share at the same point, or a crack opens between them. So an
edge is always cut from its inside corner toward its outside corner, and a polygon that needs any plane
is cut by all of them in the same order: what happens to an edge depends on its two corners alone.
"""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.base.jit import jit, parallel_jit, prange
from hsr.kernels.vectors import copy

GUARD = 2.0
"""Half-width of the guard band, in halves of the image: polygons are cut where ``|x|, |y| > GUARD w``.

The scan conversion clamps its spans to the image at no cost, so the sides serve only to keep
coordinates small, and few polygons reach them. A power of two, so that ``GUARD * w`` is exact.
"""


def view_volume(near: float, far: float, perspective: bool) -> Floats:
    """Return the planes of the view volume with its guard band.

    Returns
    -------
    (6, 4) float64
        near, far, left, right, bottom, top; (x, y, d) is inside where ``plane @ (x, y, d, 1) >= 0``.
        The plane of an infinite far has the constant ``+inf``: everything is inside.
    """
    w = [GUARD, 0.0] if perspective else [0.0, GUARD]
    sides = [[x, y, *w] for x, y in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))]
    return np.array([[0.0, 0.0, 1.0, -near], [0.0, 0.0, -1.0, far], *sides])


AXES = np.array([2, 2, 0, 0, 1, 1])
"""The coordinate that each plane of :func:`view_volume` bounds: d, d, x, x, y, y."""


@parallel_jit
def outcodes(clip: Floats, planes: Floats) -> Array:
    """Return for each point (V,) the planes it is outside of: bit k for plane k, as uint8."""
    codes = np.empty(len(clip), np.uint8)
    for i in prange(len(clip)):
        code = 0
        for k in range(len(planes)):
            code |= (not _distance(clip[i], planes[k]) >= 0.0) << k  # NaN is outside
        codes[i] = code
    return codes


@jit
def _distance(point: Floats, plane: Floats) -> float:
    distance: float = plane[0] * point[0] + plane[1] * point[1] + plane[2] * point[2] + plane[3]
    return distance


def clip_polygons(clip: Floats, corner: Ints, start: Ints, planes: Floats) -> tuple[Floats, Ints, Ints]:
    """Cut convex polygons to the inside of planes.

    Parameters
    ----------
    clip : (V, 3) float64, clip space
    corner, start : (K,), (P + 1,) int32
        Polygons over the vertices, as in :class:`hsr.scene.shapes.Polygons`.
    planes : (k, 4) float64
        The first k of :func:`view_volume`.

    Returns
    -------
    clip, corner, start
        The same polygons, those that were cut with vertices of their own at the end of ``clip``. A
        polygon outside of one plane altogether keeps its place, with no corners. Without anything to
        cut, the arrays that came in.
    """
    codes = outcodes(clip, planes)
    if not codes.any():
        return clip, corner, start
    sides, cut = _measure(clip, corner, start, planes, codes)
    new_start = np.concatenate([[0], np.cumsum(sides)]).astype(np.int32)
    first = len(clip) + np.concatenate([[0], np.cumsum(np.where(cut, sides, 0))])
    new_clip, new_corner = np.empty((first[-1], 3)), np.empty(new_start[-1], np.int32)
    new_clip[: len(clip)] = clip
    _fill((corner, start), planes, cut, first, new_clip, new_corner, new_start)
    return new_clip, new_corner, new_start


@parallel_jit
def _measure(clip: Floats, corner: Ints, start: Ints, planes: Floats, codes: Array) -> tuple[Ints, Array]:
    """Count the corners that each polygon has left, and tell which polygons are cut."""
    sides, cut = np.empty(len(start) - 1, np.int32), np.empty(len(start) - 1, np.bool_)
    for i in prange(len(sides)):
        any_outside, all_outside = 0, 255
        for k in range(start[i], start[i + 1]):
            any_outside |= codes[corner[k]]
            all_outside &= codes[corner[k]]
        cut[i] = any_outside != 0 and all_outside == 0
        sides[i] = 0 if all_outside != 0 else start[i + 1] - start[i]
        if cut[i]:
            sides[i] = len(clip_polygon(clip, corner[start[i] : start[i + 1]], planes))
    return sides, cut


@parallel_jit
def _fill(
    old: tuple[Ints, Ints], planes: Floats, cut: Array, first: Array, clip: Floats, corner: Ints, start: Ints
) -> None:
    """Write the corners that are left, and after the old vertices those of the cut polygons."""
    old_corner, old_start = old
    for i in prange(len(cut)):
        loop = old_corner[old_start[i] : old_start[i + 1]]
        for k in range(start[i + 1] - start[i]):
            corner[start[i] + k] = first[i] + k if cut[i] else loop[k]
        if cut[i]:
            left = clip_polygon(clip, loop, planes)
            for k in range(len(left)):
                copy(left[k], clip[first[i] + k])


@jit
def clip_polygon(clip: Floats, corner: Ints, planes: Floats) -> Floats:
    """Return the corners (m, 3) of one polygon inside of all planes; m = 0 if nothing is left."""
    loop = clip[corner]
    for k in range(len(planes)):
        loop = clip_to_plane(loop, planes[k], AXES[k])
    return loop


@jit
def clip_to_plane(loop: Floats, plane: Floats, axis: int) -> Floats:
    """Keep the corners inside a plane, and cut each side that crosses it.

    Of n sides at most n are cut, so at most 2 n corners result. (A convex polygon is cut twice; but
    where rounding decides the sides of corners that lie in the plane, it may be more.)
    """
    kept, count = np.empty((2 * len(loop), 3)), 0
    for k in range(len(loop)):
        here, after = loop[k], loop[(k + 1) % len(loop)]
        here_inside = _distance(here, plane) >= 0.0
        after_inside = _distance(after, plane) >= 0.0
        if here_inside:
            copy(here, kept[count])
            count += 1
        if here_inside != after_inside:
            inside, outside = (here, after) if here_inside else (after, here)
            _cut(inside, outside, plane, axis, kept[count])
            count += 1
    return kept[:count]


@jit
def _cut(inside: Floats, outside: Floats, plane: Floats, axis: int, point: Floats) -> None:
    """Write the point where an edge crosses a plane.

    On an edge that is long beside its inside part, rounding could carry the point far off: past the
    ends of the edge, or off the plane. Neither is let happen.
    """
    distance = _distance(inside, plane)
    t = distance / (distance - _distance(outside, plane))
    for k in range(3):
        along = inside[k] + t * (outside[k] - inside[k])
        point[k] = min(max(along, min(inside[k], outside[k])), max(inside[k], outside[k]))
    point[axis] = 0.0
    point[axis] = -_distance(point, plane) / plane[axis]
