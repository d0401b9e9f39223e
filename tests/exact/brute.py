"""Truth from the definitions alone: every face at every sample, in fractions.

No filter, nothing shared with the oracle it judges, and no cleverness. A sample that sits exactly
on an edge, or where two surfaces cross, is decided by moving it: by e to the right and by d down,
where d is positive and smaller than every power of e. A third infinitesimal t, greater than every
power of both, moves it first in any other direction: that gives the admissible owners.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import gcd
from typing import Any

from hsr.problem.view import Placement, View

Vector = Sequence[Any]
Matrix = Sequence[Sequence[Any]]


class Germ:
    """A polynomial in three infinitesimals: ``{(power of d, power of e, power of t): coefficient}``."""

    def __init__(self, terms: dict[tuple[int, int, int], Fraction]) -> None:
        self.terms = {powers: value for powers, value in terms.items() if value}

    @staticmethod
    def of(number: Any) -> Germ:
        return number if isinstance(number, Germ) else Germ({(0, 0, 0): Fraction(number)})

    def __add__(self, other: Any) -> Germ:
        terms = dict(self.terms)
        for powers, value in Germ.of(other).terms.items():
            terms[powers] = terms.get(powers, Fraction(0)) + value
        return Germ(terms)

    def __mul__(self, other: Any) -> Germ:
        terms: dict[tuple[int, int, int], Fraction] = {}
        for (d, e, t), value in self.terms.items():
            for (dd, ee, tt), factor in Germ.of(other).terms.items():
                powers = (d + dd, e + ee, t + tt)
                terms[powers] = terms.get(powers, Fraction(0)) + value * factor
        return Germ(terms)

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> Germ:
        return self * -1

    def __sub__(self, other: Any) -> Germ:
        return self + -Germ.of(other)

    def __rsub__(self, other: Any) -> Germ:
        return Germ.of(other) - self

    def sign(self) -> int:
        """The sign of the term that outweighs all others."""
        if not self.terms:
            return 0
        return 1 if self.terms[min(self.terms)] > 0 else -1


@dataclass
class Surd:
    """The number (p + q sqrt(r)) / s of four germs; r is not negative."""

    p: Any
    q: Any
    r: Any
    s: Any

    def affine(self, slope: Any, offset: Any) -> Surd:
        """Return slope * self + offset."""
        return Surd(slope * self.p + offset * self.s, slope * self.q, self.r, self.s)

    def sign(self) -> int:
        return Germ.of(self.s).sign() * sign_with_root(self.p, self.q, self.r)

    def minus(self, other: Surd) -> int:
        """Return the sign of self - other."""
        scale = Germ.of(self.s).sign() * Germ.of(other.s).sign()
        rational = self.p * other.s - other.p * self.s
        return scale * sign_with_roots(rational, self.q * other.s, self.r, -(other.q * self.s), other.r)


def sign_with_root(u: Any, v: Any, r: Any) -> int:
    """The sign of u + v sqrt(r)."""
    u, v, r = Germ.of(u), Germ.of(v), Germ.of(r)
    of_u, of_root = u.sign(), v.sign() * abs(r.sign())
    if of_u * of_root >= 0:
        return of_u or of_root
    return of_u * (u * u - v * v * r).sign()


def sign_with_roots(u: Any, v: Any, r: Any, w: Any, s: Any) -> int:
    """The sign of (u + v sqrt(r)) + w sqrt(s)."""
    u, v, r, w, s = (Germ.of(x) for x in (u, v, r, w, s))
    of_first, of_second = sign_with_root(u, v, r), w.sign() * abs(s.sign())
    if of_first * of_second >= 0:
        return of_first or of_second
    return of_first * sign_with_root(u * u + v * v * r - w * w * s, 2 * u * v, r)


# ---------------------------------------------------------------- linear algebra


def dot(a: Vector, b: Vector) -> Any:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def cross(a: Vector, b: Vector) -> list[Any]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def times(matrix: Matrix, vector: Vector) -> list[Any]:
    return [dot(row, vector) for row in matrix]


def fractions(array: Any) -> Any:
    return [Fraction(x) for x in array] if array.ndim == 1 else [fractions(row) for row in array]


def inverse_and_scale(matrix: Matrix) -> tuple[list[list[Any]], Any]:
    """The adjugate of a 3x3 matrix, and its determinant."""
    a, b, c = matrix
    rows = [cross(b, c), cross(c, a), cross(a, b)]
    return [list(column) for column in zip(*rows, strict=True)], dot(a, cross(b, c))


# ---------------------------------------------------------------- one line of sight


@dataclass
class Line:
    """The points ``(base + depth * step) / scale`` of one line of sight, by their depth."""

    base: Vector
    step: Vector
    scale: Any

    def at(self, row: Vector) -> tuple[Any, Any]:
        """Slope and offset of the world function ``row @ (p, 1)`` over depth, times ``scale``."""
        return dot(row[:3], self.step), dot(row[:3], self.base) + row[3] * self.scale


def line_of_sight(view: View, x: Any, y: Any) -> Line:
    x_row, y_row, _, w_row = fractions(view.clip_from_world)
    depth_row = fractions(view.depth_row)
    planes = [
        [a - x * w for a, w in zip(x_row, w_row, strict=True)],
        [b - y * w for b, w in zip(y_row, w_row, strict=True)],
        depth_row,
    ]
    adjugate, scale = inverse_and_scale([plane[:3] for plane in planes])
    base = times(adjugate, [-planes[0][3], -planes[1][3], -depth_row[3]])
    return Line(base, [row[2] for row in adjugate], scale)


def displaced(view: View, row: int, column: int, toward: tuple[int, int]) -> tuple[Germ, Germ]:
    """The sample moved by t along ``toward``, then by e to the right and d down."""
    x = Fraction(2 * column + 1, view.width) - 1
    y = 1 - Fraction(2 * row + 1, view.height)
    d, e, t = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    return (
        Germ({(0, 0, 0): x, t: Fraction(toward[0]), e: Fraction(1)}),
        Germ({(0, 0, 0): y, t: Fraction(toward[1]), d: Fraction(-1)}),
    )


# ---------------------------------------------------------------- the faces on it

Hit = tuple[int, Surd]
"""Face id, depth."""


def hits(view: View, line: Line) -> Iterator[Hit]:
    """Every point of every face on the line of sight that takes part."""
    in_front = fractions(view.clip_from_world)[3]
    for placement in view.placements:
        for face, depth in hits_of(view, placement, line):
            inside_near = depth.affine(1, -Fraction(view.near)).sign() >= 0
            inside_far = view.far == float("inf") or depth.affine(-1, Fraction(view.far)).sign() >= 0
            if inside_near and inside_far and value_at(line, in_front, depth).sign() > 0:
                yield placement.first + face, depth


def value_at(line: Line, row: Vector, depth: Surd) -> Surd:
    """The world function ``row @ (p, 1)`` at a depth of the line."""
    slope, offset = line.at(row)
    value = depth.affine(slope, offset)
    return Surd(value.p, value.q, value.r, value.s * line.scale)


def hits_of(view: View, placement: Placement, line: Line) -> Iterable[Hit]:
    if placement.shape.polygons is not None:
        return polygon_hits(view, placement, line)
    return (sphere_hits if placement.shape.label == "sphere" else cylinder_hits)(placement, line)


def culled(placement: Placement, front: bool) -> bool:
    return placement.cull == (1 if not front else 2)


def polygon_hits(view: View, placement: Placement, line: Line) -> Iterator[Hit]:
    polygons = placement.shape.polygons
    assert polygons is not None
    matrix = fractions(placement.world_from_object)
    world = [times(matrix, [*vertex, Fraction(1)])[:3] for vertex in fractions(polygons.vertices)]
    for corners, face in zip(polygons.triangle_vertex, polygons.triangle_face, strict=True):
        a, b, c = (world[k] for k in corners)
        depth = triangle_depth(view, placement, line, a, b, c)
        if depth is not None:
            yield int(face), depth


def triangle_depth(
    view: View, placement: Placement, line: Line, a: Vector, b: Vector, c: Vector
) -> Surd | None:
    """Depth where the line meets the triangle, None where it does not."""
    turn = orientation(view, a, b, c)
    if turn == 0 or culled(placement, (turn > 0) != placement.mirrored):
        return None
    normal = cross(minus(b, a), minus(c, a))
    slope, offset = line.at([*normal, -dot(normal, a)])
    depth = Surd(-offset, Germ.of(0), Germ.of(0), slope)
    for p, q in ((a, b), (b, c), (c, a)):
        inward = cross(normal, minus(q, p))
        if value_at(line, [*inward, -dot(inward, p)], depth).sign() < 0:
            return None
    return depth


def orientation(view: View, a: Vector, b: Vector, c: Vector) -> int:
    """The turn of three points on the screen: 1 counter-clockwise, 0 edge-on."""
    x_row, y_row, _, w_row = fractions(view.clip_from_world)
    rows = [[dot(row, [*p, Fraction(1)]) for row in (x_row, y_row, w_row)] for p in (a, b, c)]
    return Germ.of(dot(rows[0], cross(rows[1], rows[2]))).sign()


def minus(a: Vector, b: Vector) -> list[Any]:
    return [x - y for x, y in zip(a, b, strict=True)]


def object_line(placement: Placement, line: Line) -> Line:
    """The line in object space; only its scale differs."""
    matrix = fractions(placement.world_from_object)
    adjugate, determinant = inverse_and_scale([row[:3] for row in matrix[:3]])
    moved = [base - row[3] * line.scale for base, row in zip(line.base, matrix, strict=False)]
    return Line(times(adjugate, moved), times(adjugate, line.step), line.scale * determinant)


def roots(a: Germ, b: Germ, c: Germ) -> list[tuple[Surd, bool]]:
    """Roots of ``a z^2 + 2 b z + c``; with each, whether the quadratic falls there as z grows."""
    if a.sign() == 0:
        return [(Surd(-c, Germ.of(0), Germ.of(0), 2 * b), b.sign() < 0)] if b.sign() else []
    square = b * b - a * c
    if square.sign() <= 0:
        return []
    # The slope of the quadratic at the root with +sqrt is +2 sqrt, at the other -2 sqrt.
    return [(Surd(-b, Germ.of(q), square, a), q < 0) for q in (1, -1)]


def sphere_hits(placement: Placement, line: Line) -> Iterator[Hit]:
    ray = object_line(placement, line)
    a, b = dot(ray.step, ray.step), dot(ray.base, ray.step)
    c = dot(ray.base, ray.base) - ray.scale * ray.scale
    for depth, entering in roots(Germ.of(a), Germ.of(b), Germ.of(c)):
        if not culled(placement, entering):
            yield 0, depth


def top_of(placement: Placement) -> Fraction:
    """The radius of a cylinder at z = 1, out of the terms -1 and -2 (top - 1) z of its equation."""
    assert placement.shape.quadric is not None
    *_, axis, constant = placement.shape.quadric.form[3].tolist()
    return 1 + Fraction(axis, constant)


def cylinder_hits(placement: Placement, line: Line) -> Iterator[Hit]:
    ray, top = object_line(placement, line), top_of(placement)
    # The radius is 1 + (top - 1) z: like x, y and z, an offset and a slope.
    slope, offset = ray.at([0, 0, top - 1, 1])
    a = ray.step[0] * ray.step[0] + ray.step[1] * ray.step[1] - slope * slope
    b = ray.base[0] * ray.step[0] + ray.base[1] * ray.step[1] - offset * slope
    c = ray.base[0] * ray.base[0] + ray.base[1] * ray.base[1] - offset * offset
    for depth, entering in roots(Germ.of(a), Germ.of(b), Germ.of(c)):
        above = value_at(ray, [0, 0, 1, 0], depth).sign() >= 0
        below = value_at(ray, [0, 0, -1, 1], depth).sign() >= 0
        if above and below and not culled(placement, entering):
            yield 0, depth
    for face, height in ((1, 0), (2, 1)) if top else ((1, 0),):
        slope, offset = ray.at([0, 0, 1, -height])
        if Germ.of(slope).sign() == 0:
            continue
        depth = Surd(-offset, Germ.of(0), Germ.of(0), slope)
        # c + 2 b z + a z^2 <= 0 with z = -offset / slope
        inside = c * slope * slope - 2 * b * offset * slope + a * offset * offset
        # Along the line z_object grows by slope / scale: from below it meets the base from outside.
        rises = Germ.of(slope).sign() * Germ.of(ray.scale).sign() > 0
        if Germ.of(inside).sign() <= 0 and not culled(placement, rises == (face == 1)):
            yield face, depth


# ---------------------------------------------------------------- the answer


def nearest(view: View, row: int, column: int, toward: tuple[int, int] = (0, 0)) -> list[Hit]:
    """The faces that share the least depth just beside the sample, by face id; empty: background."""
    best: list[Hit] = []
    for hit in hits(view, line_of_sight(view, *displaced(view, row, column, toward))):
        order = hit[1].minus(best[0][1]) if best else -1
        best = [hit] if order < 0 else [*best, hit] if order == 0 else best
    return sorted(best, key=lambda hit: hit[0])


def owner(view: View, row: int, column: int) -> int:
    """The face that owns a sample, -1 for the background."""
    return next((face for face, _ in nearest(view, row, column)), -1)


def admissible(view: View, row: int, column: int, reach: int = 3) -> set[int]:
    """Every owner in the limit from a direction of small whole numbers, and what coincides with it."""
    found: set[int] = set()
    for toward in directions(reach):
        found |= {face for face, _ in nearest(view, row, column, toward)} or {-1}
    return found


def directions(reach: int) -> list[tuple[int, int]]:
    steps = range(-reach, reach + 1)
    return [(x, y) for x, y in product(steps, steps) if gcd(x, y) == 1]


def over_all(view: View, decide: Callable[[View, int, int], Any]) -> list[list[Any]]:
    """Apply ``decide(view, row, column)`` to every sample."""
    return [[decide(view, r, c) for c in range(view.width)] for r in range(view.height)]
