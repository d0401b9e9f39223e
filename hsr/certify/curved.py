"""Curved pieces in integers: where a line of sight meets quadrics and discs, and in which order.

In object space the line of sight of a sample is (O + t V) / s, with integers s > 0 and O, V affine in the
sample's place; t is the depth in a parallel view and w under perspective, times ``Frame.unit``, and so grows
away from the eye. The surface p . Q . p = 0 is met where a t^2 + 2 b t + c = 0, at t = (-b -+ sqrt(r)) / a
with r = b^2 - a c. There p . Q . p has the slope -+ 2 sqrt(r), whatever the sign of a: with the minus sign
the line enters, and so sees the outside. A disc is met at one t.

At (x + e, y + d) all these numbers are polynomials in d and e, here called germs. As d is smaller than every
power of e, the sign of a germ is that of its term of least power of d and, among those, of e. Signs of
u + v sqrt(r) follow by squaring. Where r is 0 the line touches the surface; where it is so in the limit, too,
there is no hit, as the surface is seen edge-on. So the limit decides at outlines and rims without any case of
its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import count
from math import isqrt

import numpy as np
from flint import Ordering, fmpz_mpoly, fmpz_mpoly_ctx

from hsr.base.arrays import Array
from hsr.certify.frame import Frame, Matrix
from hsr.problem.view import Placement
from hsr.scene.shapes import Quadric

GERMS = fmpz_mpoly_ctx.get(("d", "e"), Ordering.lex)
ZERO = GERMS.constant(0)


def germ(function: Sequence[int] | Array, i: int, j: int) -> fmpz_mpoly:
    """Return the affine function A i + B j + C (of whole numbers) to the right and down of a place."""
    right, up, constant = function
    return GERMS.from_dict({(0, 0): right * i + up * j + constant, (0, 1): right, (1, 0): -up})


def sign(value: fmpz_mpoly) -> int:
    """Return the sign of a germ: of its last term, in lexicographic order."""
    if not value:
        return 0
    return 1 if value.coefficient(len(value) - 1) > 0 else -1


def sign_with_root(u: fmpz_mpoly, v: fmpz_mpoly, r: fmpz_mpoly) -> int:
    """Return the sign of u + v sqrt(r), r not negative."""
    of_u, of_root = sign(u), sign(v) * sign(r)
    if of_u * of_root >= 0:
        return of_u or of_root
    return of_u * sign(u * u - v * v * r)


# ---------------------------------------------------------------- hits


@dataclass(frozen=True, eq=False)
class Root:
    """The parameter t = (p + q sqrt(r)) / s of a hit, of germs; q is -1, 0 or 1, r >= 0 and s > 0."""

    p: fmpz_mpoly
    q: int
    r: fmpz_mpoly
    s: fmpz_mpoly

    def sign_of(self, slope: fmpz_mpoly, offset: fmpz_mpoly) -> int:
        """Return the sign of slope t + offset."""
        return sign_with_root(slope * self.p + offset * self.s, slope * self.q, self.r)

    def minus(self, other: Root) -> int:
        """Return the sign of the difference of two parameters."""
        # Times the denominators it is (u + v sqrt(r)) - w sqrt(other.r).
        u = self.p * other.s - other.p * self.s
        v, w = other.s * self.q, self.s * other.q
        of_first, of_second = sign_with_root(u, v, self.r), sign(w) * sign(other.r)
        if of_first * of_second <= 0:
            return of_first or -of_second
        squared = u * u + v * v * self.r - w * w * other.r
        return of_first * sign_with_root(squared, 2 * u * v, self.r)

    def at_sample(self) -> tuple[int, int, int, int]:
        """Return p, q, r and s > 0 of what a finite parameter is at the sample itself.

        If s vanishes there, which is a or, if a is 0, 2 b, the line of sight is parallel to one on the
        surface. Then r tends to p^2 as s to 0, and (p + q sqrt(r)) / s to (p^2 - r) / 2 p s if p and q differ
        in sign, and else to 2 p / s: quotients of germs whose leading terms are alike.
        """
        if self.s[0, 0]:
            return _constant(self.p), self.q, _constant(self.r), _constant(self.s)
        p, s = self.p, self.s
        if sign(p) * self.q < 0:
            p, s = p * p - self.r, 2 * p * s
        elif self.q:
            p = 2 * p
        above, below = (int(value.coefficient(len(value) - 1)) for value in (p, s))
        way = 1 if below > 0 else -1
        return way * above, 0, 0, way * below


def root_on_plane(plane: tuple[int, int, int, int], perspective: bool, i: int, j: int) -> Root:
    """Return the parameter where a line of sight meets a plane (A, B, C, S), see ``Facet.plane``."""
    function, scale = germ(plane[:3], i, j), GERMS.constant(plane[3])
    p, s = (scale, -function) if perspective else (function, scale)
    return Root(p, 0, ZERO, s)


@dataclass(frozen=True, eq=False)
class Line:
    """A line of sight in object space: the points (origin + t step) / scale.

    Attributes
    ----------
    origin, step : list of 3 germs
    scale : int
        Positive.
    matrix : Matrix
        See :meth:`Frame.matrix`.
    """

    origin: list[fmpz_mpoly]
    step: list[fmpz_mpoly]
    scale: int
    matrix: Matrix

    def along(self, row: list[int]) -> tuple[fmpz_mpoly, fmpz_mpoly]:
        """Return slope and offset, over t, of row . (p, 1) times the scale."""
        *linear, constant = row
        return _dot(self.step, linear), _dot(self.origin, linear) + constant * self.scale

    def quadratic(self, form: Array) -> tuple[fmpz_mpoly, fmpz_mpoly, fmpz_mpoly]:
        """Return a, b, c of (p, 1) . form . (p, 1), times scale^2."""
        slopes, offsets = zip(*map(self.along, form.tolist()), strict=True)
        c = _dot(self.origin, offsets[:3]) + self.scale * offsets[3]
        return _dot(self.step, slopes[:3]), _dot(self.step, offsets[:3]), c

    @cached_property
    def depth(self) -> tuple[fmpz_mpoly, fmpz_mpoly, int]:
        """Slope and offset, over t, of depth times a positive scale and ``Frame.unit``; and that scale."""
        return *self.along(self.matrix[3]), self.scale * self.matrix[4][3]

    def between(self, limits: Sequence[int], t: Root) -> bool:
        """Tell whether a point is between near and far, both closed; then it is in front of the eye."""
        slope, offset, scale = self.depth
        ways = zip((1, -1), limits, strict=False)
        return all(t.sign_of(way * slope, way * (offset - limit * scale)) >= 0 for way, limit in ways)


def _dot(a: Sequence[fmpz_mpoly], b: Sequence[fmpz_mpoly | int]) -> fmpz_mpoly:
    return sum((x * y for x, y in zip(a, b, strict=True) if y), ZERO)


# ---------------------------------------------------------------- surfaces

Points = Iterator[tuple[Root, bool]]
"""Where a line meets a surface, and whether from outside."""


def _roots(a: fmpz_mpoly, b: fmpz_mpoly, c: fmpz_mpoly) -> Points:
    """Solve a t^2 + 2 b t + c = 0."""
    r, way = b * b - a * c, sign(a)
    if way and sign(r) > 0:
        yield Root(-way * b, -way, r, way * a), True
        yield Root(-way * b, way, r, way * a), False
    elif sign(b) and not way:
        # All lines of sight are parallel to one on the surface, and meet it once.
        yield Root(-sign(b) * c, 0, ZERO, 2 * sign(b) * b), sign(b) < 0


def _meet_surface(solid: Quadric, line: Line) -> Points:
    """Meet (p, 1) . form . (p, 1) = 0 between the ends."""
    ends = [line.along(end) for end in solid.ends.tolist()]
    for t, outside in _roots(*line.quadratic(solid.form)):
        if all(t.sign_of(slope, offset) >= 0 for slope, offset in ends):
            yield t, outside


def _meet_disc(solid: Quadric, end: Array, line: Line) -> Points:
    """Meet the plane of an end where (p, 1) . form . (p, 1) <= 0."""
    slope, offset = line.along(end.tolist())
    way = sign(slope)
    if way:
        p, s = -way * offset, way * slope
        a, b, c = line.quadratic(solid.form)
        if sign(a * p * p + 2 * b * p * s + c * s * s) <= 0:
            yield Root(p, 0, ZERO, s), way > 0


# ---------------------------------------------------------------- pieces


def rounded(p: int, q: int, r: int, s: int) -> float:
    """Return (p + q sqrt(r)) / s, s > 0, correctly rounded: bracket it until both ends round to one float."""
    for bits in count(64, 64):
        square = q * q * r << 2 * bits
        low = isqrt(square)
        high = low + (low * low < square)
        ends = {((p << bits) + (root if q > 0 else -root)) / (s << bits) for root in (low, high)}
        if len(ends) == 1:
            break
    return ends.pop()


def _constant(value: fmpz_mpoly) -> int:
    """Return what a germ is at the sample itself."""
    return int(value[0, 0])


@dataclass(frozen=True, eq=False)
class Hit:
    """A point of a face on a line of sight.

    Attributes
    ----------
    face : int
    t : Root
    line : Line or None
        In the frame of a curved piece; None for planar ones.
    """

    face: int
    t: Root
    line: Line | None = None

    def depth(self, unit: int) -> float:
        """Return the depth at the sample itself, correctly rounded; ``unit`` is that of the frame.

        A hit is near the bounded solid; so where the denominator vanishes there, t has a limit all the same.
        """
        assert self.line is not None, "the depth on a planar piece is that of its facet"
        p, q, r, s = self.t.at_sample()
        slope, offset, scale = self.line.depth
        step = _constant(slope)
        return rounded(_constant(offset) * s + step * p, step * q, r, s * scale * unit)

    def __lt__(self, other: Hit) -> bool:
        """Tell whether this hit hides the other, or coincides with it and is of the lower face."""
        order = self.t.minus(other.t)
        return order < 0 or (order == 0 and self.face < other.face)


class CurvedPiece:
    """One face of a round solid, and the lines of sight in its object's space.

    Parameters
    ----------
    frame : Frame
    placement : Placement
        The solid.
    part : int
        Index of the face within it.
    """

    def __init__(self, frame: Frame, placement: Placement, part: int) -> None:
        solid = placement.shape.quadric
        assert solid is not None, "a planar piece is a facet"
        self.limits, self.face, self.cull = frame.limits, placement.first + part, placement.cull
        self.matrix = frame.matrix(placement)
        self.sight = [numbers[0] for numbers in sights_of(frame, np.array([self.matrix], object))]
        self.meet = (
            partial(_meet_disc, solid, solid.ends[part - 1]) if part else partial(_meet_surface, solid)
        )

    def hits(self, i: int, j: int) -> Iterator[Hit]:
        """Yield the hits in the limit that are visible but for other faces."""
        *rows, scale = self.sight
        origin, step = ([germ(row, i, j) for row in part] for part in rows)
        line = Line(origin, step, scale, self.matrix)
        for t, outside in self.meet(line):
            culled = self.cull == (2 if outside else 1)
            if not culled and line.between(self.limits, t):
                yield Hit(self.face, t, line)


def sights_of(frame: Frame, matrix: Array) -> tuple[Array, Array, Array]:
    """Carry the lines of sight into the spaces of objects of some matrices (n, 5, 4), see ``Frame.matrix``.

    Returns
    -------
    origin, step : (n, 3, 3) object
        Affine functions (A, B, C) of a sample's place; see :class:`Line`.
    scale : (n,) object
        Positive.
    """
    rows = matrix[:, [0, 1, 2 if frame.perspective else 3]]
    x, y, z = np.moveaxis(rows[..., :3], 1, 0)
    adjugate = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)], axis=2)
    scale = (x * adjugate[..., 0]).sum(axis=1)
    # The point p of the line has rows . (p, 1) = (i, j, 1) w or, in a parallel view, (i w, j w, depth); t is
    # w or depth but for the object's own power of two.
    fixed, none = -(adjugate @ rows[..., 3:])[..., 0], np.zeros((len(matrix), 3), object)
    w, along = matrix[:, 2, 3:], adjugate * matrix[:, 4, 3:, None]
    if frame.perspective:
        origin, step = np.stack([none, none, fixed], axis=2), along
    else:
        origin = np.stack([w * adjugate[..., 0], w * adjugate[..., 1], fixed], axis=2)
        step = np.stack([none, none, along[..., 2]], axis=2)
    way = np.where(scale > 0, 1, -1).astype(object)
    return way[:, None, None] * origin, way[:, None, None] * step, way * scale
