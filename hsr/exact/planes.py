"""Triangles in the frame of a view: half-planes of the image and planes of zeta, in integers.

With the corners a, b, c as (X, Y, W) the cross products b x c, c x a, a x b are the edge functions
and ``det = a . (b x c)`` twice the signed area (Olano & Greer, "Triangle scan conversion using 2D
homogeneous coordinates", 1997). For every sample s = (i, j, 1)

    (b x c . s) a + (c x a . s) b + (a x b . s) c = det s

so where all three edge functions have the sign of det, s lies in the triangle and in front of the
eye; no corner need be. Taking the fourth coordinate H in place of X, Y, W on the left gives
det zeta: an affine function of the sample as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import gcd

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.exact.decide import Piece
from hsr.exact.infinitesimals import NOTHING, Surd, affine, constant
from hsr.exact.numbers import Frame, points
from hsr.problem.view import Placement, View
from hsr.scene.shapes import Polygons

BACK, FRONT = 1, 2
"""What ``cull`` removes."""

HALVES = 5
"""Half-planes of a triangle: three edges, near and far."""

MARGIN = 2.0**-20
"""Pixels by which a bounding box is widened.

The coordinates of a corner on the image are rounded five times at most; those that matter are below
2**16, so that each rounding is at most 2**-37.
"""


@dataclass(frozen=True, eq=False)
class Triangles:
    """The triangles of a view that can be seen on its image at all.

    Attributes
    ----------
    half : (n, 5, 3) object
        Coefficients (a, b, c) of the affine functions a i + b j + c that are not negative at the
        samples of the triangle: the edges against its corners in turn, near, far.
    zeta : (n, 3) object
        Coefficients of ``det`` times zeta.
    det : (n,) object
        Positive.
    face : (n,) int32
    box : (n, 4) int32
        First row, first column, last row, last column of the samples it may cover.
    """

    half: Array
    zeta: Array
    det: Array
    face: Ints
    box: Ints

    def __len__(self) -> int:
        return len(self.face)

    def plane(self, triangle: int) -> tuple[int, ...]:
        """Name the plane of a triangle."""
        return plane_name([*self.zeta[triangle], -self.det[triangle]])

    def piece(self, triangle: int) -> Piece:
        """Return a triangle as a piece."""
        zeta = Surd(affine(self.zeta[triangle]), NOTHING, NOTHING, constant(self.det[triangle]))
        extent = tuple(affine(half) for half in self.half[triangle] if bounds(half))
        return Piece(int(self.face[triangle]), self.plane(triangle), zeta, extent, number=triangle)


def triangles_of(view: View, frame: Frame, samples: Array) -> Triangles:
    """Collect the triangles of all planar shapes of a view.

    Left out are those that cover none of the samples: culled, edge-on, behind the eye, not between near and
    far, or beside them on the image.
    """
    asked = np.zeros((view.height + 1, view.width + 1), dtype=np.int32)
    asked[1:, 1:].flat[samples] = 1
    above_left = asked.cumsum(axis=0).cumsum(axis=1)
    vertices: dict[int, Array] = {}
    parts = [_none()]
    for placement in view.placements:
        polygons = placement.shape.polygons
        if polygons is not None:
            if id(polygons) not in vertices:
                vertices[id(polygons)] = points(polygons.vertices)
            corners = vertices[id(polygons)] @ frame.placed(placement.world_from_object).T
            parts.append(_placed(view, frame, placement, polygons, corners, above_left))
    fields = zip(*(vars(part).values() for part in parts), strict=True)
    return Triangles(*map(np.concatenate, fields))


def _none() -> Triangles:
    empty = np.zeros(0, dtype=object)
    no_int = np.zeros(0, np.int32)
    return Triangles(empty.reshape(0, HALVES, 3), empty.reshape(0, 3), empty, no_int, no_int.reshape(0, 4))


def _placed(
    view: View, frame: Frame, placement: Placement, polygons: Polygons, corners: Array, above_left: Array
) -> Triangles:
    """Keep the triangles of one object that can be seen.

    ``above_left`` (H + 1, W + 1) counts the samples asked for in rows and columns before those given.
    """
    vertex = polygons.triangle_vertex
    inside: Bools = np.asarray(corners @ frame.limits.T >= 0, dtype=np.bool_)
    ahead: Bools = np.asarray(corners[:, 2] > 0, dtype=np.bool_)
    box = boxes(view, corners, vertex, ahead)
    # A limit that all corners are beyond leaves nothing, one that all are within cuts nothing.
    beyond = np.any(np.all(~inside[vertex], axis=1), axis=1)
    shown = np.any(ahead[vertex], axis=1) & ~beyond & np.all(box[:, :2] <= box[:, 2:], axis=1)
    number = np.flatnonzero(shown)
    top, left, bottom, right = (box[number] + [0, 0, 1, 1]).T
    above = above_left[top, right] - above_left[top, left]
    number = number[above_left[bottom, right] - above_left[bottom, left] > above]

    number, edges, det = _facing(placement, corners, vertex, number)
    zeta = (corners[vertex[number], 3][:, :, None] * edges).sum(axis=1)
    cut = ~np.all(inside[vertex[number]], axis=1)
    half = np.concatenate([edges, _within(frame, zeta, det, cut)], axis=1)
    face = polygons.triangle_face[number] + np.int32(placement.first)
    return Triangles(half, zeta, det, face, box[number])


def _facing(placement: Placement, corners: Array, vertex: Ints, number: Array) -> tuple[Array, Array, Array]:
    """Leave out what is culled or edge-on, and turn the rest to have a positive det.

    Each line through two corners is computed once, from the lower to the higher of the vertices.

    Returns
    -------
    number : (n,) int64
        Those of the given triangles that are left.
    edges : (n, 3, 3) object
        Edge functions against the corners in turn.
    det : (n,) object
    """
    vertex = vertex[number].astype(np.int64)
    tail, head = vertex[:, [1, 2, 0]], vertex[:, [2, 0, 1]]
    pair = np.minimum(tail, head) * len(corners) + np.maximum(tail, head)
    pairs, line = np.unique(pair, return_inverse=True)
    lines = cross(corners[pairs // len(corners)], corners[pairs % len(corners)])
    line, rising = line.reshape(vertex.shape), np.where(tail < head, 1, -1)
    det = (corners[vertex[:, 0], :3] * lines[line[:, 0]]).sum(axis=1) * rising[:, 0]

    front = (det < 0) if placement.mirrored else (det > 0)
    drawn = (det != 0) & (front if placement.cull == BACK else ~front if placement.cull == FRONT else True)
    side = np.where(det > 0, 1, -1)[:, None] * rising
    return number[drawn], lines[line[drawn]] * side[drawn][:, :, None], np.abs(det[drawn])


def cross(a: Array, b: Array) -> Array:
    """Cross product of the first three coordinates, (n, 3)."""
    ax, ay, aw = a[:, 0], a[:, 1], a[:, 2]
    bx, by, bw = b[:, 0], b[:, 1], b[:, 2]
    return np.stack([ay * bw - aw * by, aw * bx - ax * bw, ax * by - ay * bx], axis=1)


def _within(frame: Frame, zeta: Array, det: Array, cut: Bools) -> Array:
    """Half-planes (n, 2, 3) of near and far; (0, 0, 1), which says nothing, where they do not cut."""
    half = np.zeros((len(det), 2, 3), dtype=object)
    half[:, :, 2] = 1
    for side, limit in enumerate(frame.limits):
        which = cut[:, side]
        half[which, side] = on_planes(limit, zeta[which], det[which])
    return half


def bounds(half: Array) -> Array:
    """Tell of half-planes (..., 3) whether they leave anything out."""
    return np.asarray((half[..., 0] != 0) | (half[..., 1] != 0) | (half[..., 2] < 0), dtype=np.bool_)


def on_planes(form: Array, zeta: Array, det: Array) -> Array:
    """Coefficients (n, 3) of the affine functions that a form is on planes, times ``det``."""
    # Most forms are of zeta alone, or of the sample alone.
    of_zeta = form[3] * zeta if form[3] else 0
    return np.asarray(det[:, None] * form[:3] + of_zeta if form[:3].any() else of_zeta)


def boxes(view: View, corners: Array, vertex: Ints, ahead: Bools) -> Ints:
    """Rows and columns (n, 4) of the samples that figures of corners (n, k) may cover.

    A projection is the hull of its projected corners, if all of them are in front of the eye; the
    whole image otherwise. ``MARGIN`` more than makes up for rounding.
    """
    shown, size = np.where(ahead, corners[:, 2], 1), np.array([view.height, view.width])
    column = (ratio(corners[:, 0], shown) + view.width - 1) / 2
    row = (view.height - 1 - ratio(corners[:, 1], shown)) / 2
    place = np.clip(np.stack([row, column], axis=1), -2, size + 1)[vertex]
    first, last = np.ceil(place.min(axis=1) - MARGIN), np.floor(place.max(axis=1) + MARGIN)
    sure = np.all(ahead[vertex], axis=1)[:, None]
    first, last = (
        np.where(sure, np.maximum(first, 0), 0),
        np.where(sure, np.minimum(last, size - 1), size - 1),
    )
    return np.hstack([first, last]).astype(np.int32)


def plane_name(form: Sequence[int]) -> tuple[int, ...]:
    """Name the plane a i + b j + c + k zeta = 0, whatever the scale of its equation; k is not 0."""
    common = gcd(*form) * (1 if form[3] > 0 else -1)
    return tuple(coefficient // common for coefficient in form)


def ratio(numerator: Array, denominator: Array | int) -> Floats:
    """Divide integers to float64; both and their quotient are rounded, which is infinite if out of range."""
    try:
        return np.asarray(numerator.astype(np.float64) / np.asarray(denominator, dtype=np.float64))
    except OverflowError:
        return np.asarray(np.frompyfunc(_quotient, 2, 1)(numerator, denominator), dtype=np.float64)


def _quotient(numerator: int, denominator: int) -> float:
    try:
        return numerator / denominator
    except OverflowError:
        return float("inf") if (numerator > 0) == (denominator > 0) else float("-inf")
