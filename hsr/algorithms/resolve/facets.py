"""Planar pieces in integers: which cover a sample, and which of those is nearest.

Homogeneous points a, b, c = (i w, j w, w) of a triangle's corners span the point p = (i, j, 1) of a sample:
p = (A a + B b + C c) / det[a b c], where A = (b x c) . p, B = (c x a) . p and C = (a x b) . p. The line of
sight meets the triangle, in front of the eye, where none of the three edge functions has the sign opposite to
the determinant's. Other affine functions on the triangle are combinations of the corners' by A, B and C.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from hsr.algorithms.resolve.frame import Frame, integers
from hsr.arrays import Array, Bools, Ints
from hsr.scene.shapes import Polygons
from hsr.viewing import Placement


@dataclass(frozen=True, eq=False)
class Facets:
    """Planar pieces by affine functions (A, B, C) of a sample's place, A i + B j + C.

    Attributes
    ----------
    face : (n,) int32
    drawn : (n,) bool
        Whether a piece takes part: it is neither culled nor seen edge-on.
    inside : (n, 4 or 5, 3) object
        Not negative where a piece takes part: its edges, near, and far unless that is infinite.
    plane : (n, 4) object
        (A, B, C, S) in lowest terms, S > 0: along a line of sight (A i + B j + C) / S grows with depth, to
        which it is equal (times ``Frame.unit``) in a parallel view; under perspective it is -1 / w.
    depth : (n, 2, 3) object
        Numerator and denominator of the depth.
    """

    face: Ints
    drawn: Bools
    inside: Array
    plane: Array
    depth: Array

    @cached_property
    def grows(self) -> Bools:
        """Tell which of ``inside`` (n, 4 or 5) do not fall to the right and then down."""
        right, up = self.inside[..., 0], self.inside[..., 1]
        grows: Bools = (right > 0) | ((right == 0) & (up <= 0))
        return grows

    @cached_property
    def plane_id(self) -> Array:
        """Numbers (n,) int64 that are equal for pieces of equal planes."""
        known: dict[tuple[int, ...], int] = {}
        return np.array([known.setdefault(tuple(row), len(known)) for row in self.plane])

    def covers(self, which: Array, i: Array, j: Array, sure: Bools) -> Bools:
        """Tell which pieces cover which samples in the limit.

        Parameters
        ----------
        which : (m,) int64
            Indices of pieces.
        i, j : (m,) object
            Places of samples.
        sure : (m,) bool
            Whether that is known to be so.

        Returns
        -------
        (m,) bool
        """
        covered = self.drawn[which]
        asked = np.flatnonzero(covered & ~sure)
        for k in range(self.inside.shape[1]):
            piece = which[asked]
            value = _at(self.inside[piece, k], i[asked], j[asked])
            positive = (value > 0) | ((value == 0) & self.grows[piece, k])
            covered[asked[~positive]] = False
            asked = asked[positive]
        return covered

    def nearest(self, which: Array, i: Array, j: Array, first: Array) -> Array:
        """Return the entry (samples,) of the nearest piece in the limit at each sample.

        Parameters
        ----------
        which : (m,) int64
            Indices of pieces that cover the samples, sample after sample.
        i, j : (m,) object
            Places of the samples.
        first : (samples,) int64
            First entry of each sample, ascending.
        """
        value = _at(self.plane[which], i, j)
        best, count = first.copy(), np.diff(first, append=len(which))
        for rank in range(1, count.max(initial=0)):
            contested = np.flatnonzero(count > rank)
            new, old = first[contested] + rank, best[contested]
            nearer = self._nearer(which[new], value[new], which[old], value[old])
            best[contested[nearer]] = new[nearer]
        return best

    def _nearer(self, one: Array, value: Array, other: Array, other_value: Array) -> Bools:
        """Tell where the first piece owns the sample rather than the second: nearer, or the lower face."""
        p, q = self.plane[one], self.plane[other]
        order = value * q[:, 3] - other_value * p[:, 3]
        nearer: Bools = order < 0
        tied = np.flatnonzero(order == 0)
        p, q = p[tied], q[tied]
        right, up = (p[:, :2] * q[:, 3:] - q[:, :2] * p[:, 3:]).T
        lower = self.face[one[tied]] < self.face[other[tied]]
        nearer[tied] = (right < 0) | ((right == 0) & ((up > 0) | ((up == 0) & lower)))
        return nearer

    def depth_at(self, which: Array, i: Array, j: Array) -> Array:
        """Return the depths (m,) float64 of pieces at samples, correctly rounded as integer division is."""
        above, below = (_at(self.depth[which, k], i, j) for k in (0, 1))
        return (above / below).astype(np.float64)


def _at(function: Array, i: Array, j: Array) -> Array:
    """Return the values (m,) of affine functions (m, 3) at places."""
    value: Array = function[:, 0] * i + function[:, 1] * j + function[:, 2]
    return value


# ---------------------------------------------------------------- setting up


def facets_of(frame: Frame, thing: int, placement: Placement, triangle: Array) -> Facets:
    """Set up some triangles of the fans of one object.

    Parameters
    ----------
    frame : Frame
    thing : int
        Index of the object.
    placement : Placement
    triangle : (n,) int64
        Indices into ``placement.shape.polygons.triangle_vertex``; each fan the other way round if the object
        is mirrored, for so ``view.polygons`` has them.
    """
    polygons = placement.shape.polygons
    assert polygons is not None, "spheres and cylinders have no facets"
    triangle = _turned(polygons, triangle) if placement.mirrored else triangle
    used, corner = np.unique(polygons.triangle_vertex[triangle], return_inverse=True)
    vertices, h = integers(polygons.vertices[used])
    homogeneous = np.insert(vertices, 3, h, axis=1) @ frame.matrices[thing].T
    corners = homogeneous[corner]
    a, b, c = (corners[:, k, :3] for k in range(3))
    edges = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)], axis=1)
    turn = (a * edges[:, 0]).sum(axis=1)
    sign = np.sign(turn)
    # The corners' depths carry the factor h; so does the function that is 1 at all corners.
    depth = (corners[..., 3:] * edges).sum(axis=1) * sign[:, None]
    one = edges.sum(axis=1) * h * sign[:, None]
    between = [way * (depth - limit * one) for way, limit in zip((1, -1), frame.limits, strict=False)]
    inside = np.concatenate([edges * sign[:, None, None], np.stack(between, axis=1)], axis=1)
    return Facets(
        (polygons.triangle_face[triangle] + placement.first).astype(np.int32),
        _drawn(placement, turn),
        inside,
        _planes(frame, np.abs(turn), depth, one),
        np.stack([depth, one * frame.unit], axis=1),
    )


def _cross(a: Array, b: Array) -> Array:
    """Return the cross products of vectors (n, 3), which NumPy does not hurry to find for a few integers."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=1)


def _turned(polygons: Polygons, triangle: Array) -> Array:
    """Return the triangles in the same places of the fans if these run the other way round."""
    polygon = polygons.triangle_polygon
    first, end = (np.searchsorted(polygon, polygon[triangle], side) for side in ("left", "right"))
    return np.asarray(first + end - 1 - triangle)


def joined(parts: list[Facets]) -> Facets:
    """Return the facets of several objects as one."""
    names = [field.name for field in fields(Facets)]
    return Facets(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def _drawn(placement: Placement, turn: Array) -> Bools:
    """Tell by the turn of the corners on the screen which triangles take part."""
    front = (turn > 0) != placement.mirrored
    culled = (front & (placement.cull == 2)) | (~front & (placement.cull == 1))
    drawn: Bools = (turn != 0) & ~culled
    return drawn


def _planes(frame: Frame, turn: Array, depth: Array, one: Array) -> Array:
    """Return (n, 4) affine functions by which pieces are ordered along lines of sight, in lowest terms."""
    # The corners' combination of w is the determinant, as p has w = 1; so 1 / w is one / turn. In a
    # parallel view w is constant, and so is the combination of ones.
    plane = np.insert(-one, 3, turn, axis=1) if frame.perspective else np.insert(depth, 3, one[:, 2], axis=1)
    common = np.maximum(np.gcd.reduce(plane, axis=1), 1)
    lowest: Array = plane // common[:, None]
    return lowest
