"""Spheres, cylinders and cones in the frame of a view.

A quadric p Q p = 0 of object space is one of the frame: on the line of sight of the sample
s = (i, j, 1) it reads

    a zeta^2 + 2 b zeta + c = 0,      zeta = (-b +- sqrt(b^2 - a c)) / a

with a a number, b affine and c quadratic in the sample. Where ``+`` stands, p Q p grows with zeta, whatever
the sign of a: under perspective the line of sight enters there, for a parallel view it leaves. With a cone,
the first of the two may be on the other nappe; the planes that cut the solid off leave that out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, product
from math import gcd

import numpy as np

from hsr.base.arrays import Array
from hsr.exact.decide import Form, Piece
from hsr.exact.infinitesimals import NOTHING, I, J, Polynomial, Surd, affine, coefficients, constant
from hsr.exact.numbers import Frame, integers, inverse
from hsr.exact.planes import BACK, FRONT, boxes, plane_name
from hsr.problem.view import Placement, View
from hsr.scene.shapes import Quadric


def rounds_of(view: View, frame: Frame, number: int) -> list[Piece]:
    """Collect the pieces of all round solids of a view that can be seen on its image.

    They are numbered from ``number``.
    """
    found = chain.from_iterable(_placed(view, frame, placement) for placement in view.placements)
    return [replace(piece, number=number + k) for k, piece in enumerate(found)]


def _placed(view: View, frame: Frame, placement: Placement) -> Iterator[Piece]:
    solid = placement.shape.quadric
    if solid is None:
        return
    to_frame = frame.placed(placement.world_from_object)
    block = np.array([[*corner, 1.0] for corner in product(*solid.box.T)])
    corners = integers(block) @ to_frame.T
    ahead = np.asarray(corners[:, 2] > 0, dtype=np.bool_)
    box = boxes(view, corners, np.arange(8, dtype=np.int32)[None, :], ahead)[0]
    if box[0] > box[2] or box[1] > box[3]:
        return
    bounds = list(_bounds(frame, corners, bool(ahead.all())))
    for piece in _pieces(placement, solid, frame.nearer, inverse(to_frame)):
        yield replace(piece, inside=(*piece.inside, *bounds), box=box)


def _bounds(frame: Frame, corners: Array, ahead: bool) -> Iterator[Form]:
    """Yield what near, far and the eye cut off, as far as they cut the block around the shape."""
    if not ahead and frame.nearer > 0:
        yield NOTHING, constant(1)
    for limit in frame.limits:
        if (corners @ limit < 0).any():
            yield form(limit)


def form(coefficients: Array) -> Form:
    """Return the form a i + b j + c + k zeta."""
    return affine(coefficients[:3]), constant(coefficients[3])


def _pieces(placement: Placement, solid: Quadric, nearer: int, to_object: Array) -> Iterator[Piece]:
    """Yield the half where lines of sight enter, which is the front, that where they leave, and the discs."""
    surface, ends = Conic.of(solid.form, to_object), solid.ends @ to_object
    for entering in (True, False):
        if placement.cull != (FRONT if entering else BACK):
            side = nearer if entering else -nearer
            yield from surface.half(placement.first, side, tuple(form(end) for end in ends))
    for face, outward in zip(range(1, placement.shape.faces), -ends, strict=False):
        faces_eye = nearer * outward[3] > 0
        if outward[3] != 0 and placement.cull != (BACK if not faces_eye else FRONT):
            yield surface.disc(placement.first + face, form(outward))


@dataclass(frozen=True)
class Conic:
    """a zeta^2 + 2 b zeta + c, polynomials in the sample."""

    a: Polynomial
    b: Polynomial
    c: Polynomial

    @classmethod
    def of(cls, matrix: Array, to_object: Array) -> Conic:
        """Carry p Q p from object space into the frame."""
        q = to_object.T @ matrix @ to_object
        sample = (I, J, constant(1))
        c = sum((int(q[m, n]) * sample[m] * sample[n] for m in range(3) for n in range(3)), NOTHING)
        return cls(constant(q[3, 3]), affine(q[3, :3]), c)

    def half(self, face: int, side: int, inside: tuple[Form, ...]) -> Iterator[Piece]:
        """Yield the piece with the root (-b + side sqrt(b^2 - a c)) / a, if it can be seen.

        If a is 0, the eye lies on the surface, or lines of sight are parallel to the axis of a cylinder or a
        line on a cone. Then one root is the eye itself, or there is none; the other is -c / 2 b, on the side
        of the sign of b.
        """
        square = self.b * self.b - self.a * self.c
        if not self.a.is_zero():
            zeta = Surd(-self.b, constant(side), square, self.a)
            yield Piece(face, self._name(side), zeta, (square,), inside)
        elif not self.b.is_zero():
            zeta = Surd(-self.c, NOTHING, NOTHING, 2 * self.b)
            yield Piece(face, self._name(side), zeta, (side * self.b,), inside)

    def _name(self, side: int) -> tuple[int, ...]:
        """Name the surface, whatever the scale of its equation."""
        values = np.concatenate([coefficients(polynomial) for polynomial in (self.a, self.b, self.c)])
        return (side, *(values // gcd(*values)))

    def disc(self, face: int, plane: Form) -> Piece:
        """Return the part of a plane within the quadric: zeta = -l / k where its value is not positive."""
        offset, slope = plane
        value = self.a * offset * offset - 2 * self.b * offset * slope + self.c * slope * slope
        name = plane_name([*coefficients(offset)[3:], int(slope[0, 0])])
        return Piece(face, name, Surd(-offset, NOTHING, NOTHING, slope), (-value,))
