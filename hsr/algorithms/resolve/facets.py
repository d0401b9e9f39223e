"""Planar pieces in integers: which cover a sample, and which of those is nearest.

Homogeneous points a, b, c = (i w, j w, w) of a triangle's corners span the point p = (i, j, 1) of a sample:
p = (A a + B b + C c) / det[a b c], where A = (b x c) . p, B = (c x a) . p and C = (a x b) . p. The line of
sight meets the triangle, in front of the eye, where none of the three edge functions has the sign opposite to
the determinant's. Other affine functions on the triangle are combinations of the corners' by A, B and C.
"""

from __future__ import annotations

from math import gcd
from operator import mul
from typing import NamedTuple

from hsr.algorithms.resolve.frame import Frame, Matrix, integers
from hsr.viewing import Placement

Affine = list[int]
"""An affine function (A, B, C) of a sample's place: A i + B j + C."""

Corner = tuple[int, int, int, int, int]
"""A corner (i w, j w, w, depth, 1) in integers, the first four times ``Frame.unit``."""


class Facet(NamedTuple):
    """A planar piece.

    Attributes
    ----------
    face : int
    drawn : bool
        Whether it takes part: it is neither culled nor seen edge-on.
    inside : list of 4 or 5 Affine
        Not negative where it takes part: its edges, near, and far unless that is infinite.
    plane : list of 4 int
        (A, B, C, S) in lowest terms, S > 0: along a line of sight (A i + B j + C) / S grows with depth, to
        which it is equal (times ``Frame.unit``) in a parallel view; under perspective it is -1 / w.
    depth : tuple of 2 Affine
        Numerator and denominator of the depth.
    """

    face: int
    drawn: bool
    inside: list[Affine]
    plane: list[int]
    depth: tuple[Affine, Affine]

    def covers(self, i: int, j: int) -> bool:
        """Tell whether it takes part at a place in the limit."""
        for right, up, constant in self.inside:
            value = right * i + up * j + constant
            # A function that is 0 here has the sign of its growth to the right and then down.
            if value < 0 or (value == 0 and (right < 0 or (right == 0 and up > 0))):
                return False
        return self.drawn

    def hides(self, other: Facet, i: int, j: int) -> bool:
        """Tell whether of the two, at a place in the limit, this one is nearer, or of the lower face."""
        if self.plane == other.plane:
            return self.face < other.face
        right, up, constant, scale = self.plane
        other_right, other_up, other_constant, other_scale = other.plane
        right, up = right * other_scale - other_right * scale, up * other_scale - other_up * scale
        order = right * i + up * j + constant * other_scale - other_constant * scale
        return order < 0 or (order == 0 and (right < 0 or (right == 0 and up > 0)))

    def depth_at(self, i: int, j: int) -> float:
        """Return the depth at a place, correctly rounded as integer division is."""
        (a, b, c), (right, up, constant) = self.depth
        return (a * i + b * j + c) / (right * i + up * j + constant)


# ---------------------------------------------------------------- setting up


def corner_of(matrix: Matrix, point: list[float]) -> Corner:
    """Carry a point (x, y, z) of an object to the screen by its matrix."""
    (x, y, z), h = integers(point)
    i, j, w, depth = (a * x + b * y + c * z + d * h for a, b, c, d in matrix)
    return i, j, w, depth, h


def facet_of(frame: Frame, placement: Placement, face: int, corners: list[Corner]) -> Facet:
    """Set up a triangle of a fan.

    Parameters
    ----------
    frame : Frame
    placement : Placement
        Its object.
    face : int
    corners : list of 3 Corner
        In the order of the fan, so clockwise on the screen if the front is seen of a mirrored object.
    """
    a, b, c = corners
    edges = [_cross(b, c), _cross(c, a), _cross(a, b)]
    turn = sum(map(mul, a, edges[0]))
    sign = (turn > 0) - (turn < 0)
    edges = [[sign * number for number in edge] for edge in edges]
    front = (turn > 0) != placement.mirrored
    drawn = turn != 0 and placement.cull != (2 if front else 1)

    *_, depths, ones = zip(*corners, strict=True)
    depth, one = _combined(depths, edges), _combined(ones, edges)
    between = [
        [way * (d - limit * o) for d, o in zip(depth, one, strict=True)]
        for way, limit in zip((1, -1), frame.limits, strict=False)
    ]
    plane = _plane(frame, abs(turn), depth, one)
    return Facet(face, drawn, edges + between, plane, (depth, [frame.unit * o for o in one]))


def _cross(a: Corner, b: Corner) -> Affine:
    (ax, ay, az, *_), (bx, by, bz, *_) = a, b
    return [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]


def _combined(numbers: tuple[int, ...], edges: list[Affine]) -> Affine:
    """Return the affine function that has these values at the corners, times the determinant."""
    a, b, c = numbers
    return [a * x + b * y + c * z for x, y, z in zip(*edges, strict=True)]


def _plane(frame: Frame, turn: int, depth: Affine, one: Affine) -> list[int]:
    """Return the affine function by which pieces are ordered along lines of sight, in lowest terms."""
    # The corners' combination of w is the determinant, as p has w = 1; so 1 / w is one / turn. In a
    # parallel view w is constant, and so is the combination of ones.
    plane = [*(-o for o in one), turn] if frame.perspective else [*depth, one[2]]
    common = gcd(*plane) or 1
    return [number // common for number in plane]
