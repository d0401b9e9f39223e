"""Planar pieces in integers: which cover a sample, and which of those is nearest.

Homogeneous points a, b, c = (i w, j w, w) of a triangle's corners span the point p = (i, j, 1) of a sample:
p = (A a + B b + C c) / det[a b c], where A = (b x c) . p, B = (c x a) . p and C = (a x b) . p. The line of
sight meets the triangle, in front of the eye, where none of the three edge functions has the sign opposite to
the determinant's. Other affine functions on the triangle are combinations of the corners' by A, B and C.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import gcd
from typing import NamedTuple

from hsr.certify.frame import Frame, Matrix, integers
from hsr.problem.view import Placement

Affine = tuple[int, int, int]
"""An affine function (A, B, C) of a sample's place: A i + B j + C."""

Corner = tuple[int, int, int, int, int]
"""A corner (i w, j w, w, depth, 1), the first four times ``Frame.unit``, and all times a power of two."""


class Facet(NamedTuple):
    """A planar piece.

    Attributes
    ----------
    face : int
    drawn : bool
        Whether it takes part: it is neither culled nor seen edge-on.
    inside : tuple of 4 or 5 Affine
        Not negative where it takes part: its edges, near, and far unless that is infinite.
    plane : tuple of 4 int
        (A, B, C, S) in lowest terms, S > 0: along a line of sight (A i + B j + C) / S grows with depth, to
        which it is equal (times ``Frame.unit``) in a parallel view; under perspective it is -1 / w.
    depth : tuple of 2 Affine
        Numerator and denominator of the depth.
    """

    face: int
    drawn: bool
    inside: tuple[Affine, ...]
    plane: tuple[int, int, int, int]
    depth: tuple[Affine, Affine]

    def covers(self, i: int, j: int) -> bool:
        """Tell whether it takes part at a place in the limit."""
        for right, up, constant in self.inside:
            # A function that is 0 here has the sign of its growth to the right and then down.
            if (right * i + up * j + constant or right or -up) < 0:
                return False
        return self.drawn

    def hides(self, other: Facet, i: int, j: int) -> bool:
        """Tell whether of the two, at a place in the limit, this one is nearer, or of the lower face."""
        if self.plane == other.plane:
            return self.face < other.face
        (a, b, c, s), (right, up, constant, scale) = self.plane, other.plane
        order = (a * i + b * j + c) * scale - (right * i + up * j + constant) * s
        return (order or a * scale - right * s or up * s - b * scale) < 0

    def depths(self, i: int, j: int, count: int) -> Iterator[float]:
        """Yield the depths from a place on to the right, correctly rounded as integer division is."""
        (a, b, c), (right, up, constant) = self.depth
        above, below = a * i + b * j + c, right * i + up * j + constant
        for _ in range(count):
            yield above / below
            above, below = above + 2 * a, below + 2 * right


# ---------------------------------------------------------------- setting up


def corner_of(matrix: Matrix, point: list[float]) -> Corner:
    """Carry a point (x, y, z) of an object to the screen by its matrix, see :meth:`Frame.matrix`."""
    (x, y, z), h = integers(point)
    i, j, w, depth, one = [a * x + b * y + c * z + d * h for a, b, c, d in matrix]
    return i, j, w, depth, one


def facet_of(frame: Frame, placement: Placement, face: int, corners: Sequence[Corner]) -> Facet:
    """Set up a triangle of a fan.

    Parameters
    ----------
    frame : Frame
    placement : Placement
        Its object.
    face : int
    corners : 3 Corner
        In the order of the fan, so clockwise on the screen if the front is seen of a mirrored object.
    """
    a, b, c = corners
    edges: tuple[Affine, ...] = _cross(b, c), _cross(c, a), _cross(a, b)
    turn = a[0] * edges[0][0] + a[1] * edges[0][1] + a[2] * edges[0][2]
    front = (turn > 0) != placement.mirrored
    drawn = turn != 0 and placement.cull != (2 if front else 1)
    if turn < 0:
        turn, edges = -turn, tuple((-x, -y, -z) for x, y, z in edges)

    depth, one = (_combined(a[k], b[k], c[k], edges) for k in (3, 4))
    near, *far = frame.limits
    inside = (*edges, _sum(1, depth, -near, one), *(_sum(-1, depth, limit, one) for limit in far))
    (x, y, z), unit = one, frame.unit
    below = (unit * x, unit * y, unit * z)
    return Facet(face, drawn, inside, _plane(frame, turn, depth, one), (depth, below))


def _cross(a: Corner, b: Corner) -> Affine:
    ax, ay, az, _, _ = a
    bx, by, bz, _, _ = b
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


def _combined(p: int, q: int, r: int, edges: Sequence[Affine]) -> Affine:
    """Return the affine function that has these values at the corners, times the determinant."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = edges
    return p * ax + q * bx + r * cx, p * ay + q * by + r * cy, p * az + q * bz + r * cz


def _sum(p: int, one: Affine, q: int, other: Affine) -> Affine:
    (ax, ay, az), (bx, by, bz) = one, other
    return p * ax + q * bx, p * ay + q * by, p * az + q * bz


def _plane(frame: Frame, turn: int, depth: Affine, one: Affine) -> tuple[int, int, int, int]:
    """Return the affine function by which pieces are ordered along lines of sight, in lowest terms."""
    # The corners' combination of w is the determinant, as p has w = 1; so 1 / w is one / turn. In a
    # parallel view w is constant, and so is the combination of ones.
    x, y, z = one
    a, b, c, s = (-x, -y, -z, turn) if frame.perspective else (*depth, z)
    common = gcd(a, b, c, s) or 1
    return a // common, b // common, c // common, s // common
