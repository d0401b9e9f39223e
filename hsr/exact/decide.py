"""The owner of one sample, and everyone who might own it, decided in the limit.

A *piece* is a part of a face that meets a line of sight at most once: a triangle, the near or the
far half of a sphere. Where it does, its zeta is a number (p + q sqrt(r)) / s of polynomials in the
sample, and what bounds it are forms that must not be negative there.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain, combinations, pairwise
from math import gcd
from operator import attrgetter
from typing import Any

from flint import fmpz_poly

from hsr.base.arrays import Ints
from hsr.exact.infinitesimals import IMAGE, I, J, Polynomial, Spot, Surd, at, beside, sign
from hsr.problem.map import BACKGROUND

Form = tuple[Polynomial, Polynomial]
"""(l, k): the value l + k zeta, l and k polynomials in i and j."""

Direction = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Piece:
    """A part of a face.

    Attributes
    ----------
    face : int
    surface : tuple
        Pieces of equal surface coincide wherever both are.
    zeta : Surd
        Of polynomials in i and j.
    extent : tuple of Polynomial
        Not negative at the samples where the piece may be, r among them; asked before zeta.
    inside : tuple of Form
        Not negative on the piece.
    number : int
        By which :func:`decide` names it.
    box : sequence of 4 int
        First row, first column, last row, last column of the samples that a curved piece may cover.
    """

    face: int
    surface: tuple[int, ...]
    zeta: Surd
    extent: tuple[Polynomial, ...] = ()
    inside: tuple[Form, ...] = ()
    number: int = BACKGROUND
    box: Sequence[int] | Ints = ()

    def depth_at(self, spot: Spot) -> Surd | None:
        """Return zeta of the piece just beside a sample, None where it is not."""
        if any(sign(at(polynomial, spot)) < 0 for polynomial in self.extent):
            return None
        zeta = self.zeta.at(spot)
        if sign(zeta.s) == 0:
            return None
        for offset, slope in self.inside:
            if zeta.affine(at(slope, spot), at(offset, spot)).sign() < 0:
                return None
        return zeta

    def critical(self) -> Iterator[Polynomial]:
        """Yield polynomials among whose zeros are all places where the piece begins or ends."""
        yield from self.extent
        yield self.zeta.s
        for offset, slope in self.inside:
            value = self.zeta.affine(slope, offset)
            yield value.p if self.zeta.q.is_zero() else value.norm()


Answer = tuple[int, frozenset[int]]
"""The number of the piece that owns a sample, -1 for the background; all admissible faces."""


def nearest(pieces: Iterable[Piece], spot: Spot, nearer: int) -> list[Piece]:
    """Return the pieces that share the least depth just beside a sample."""
    least: Surd | None = None
    found: list[Piece] = []
    for piece in pieces:
        zeta = piece.depth_at(spot)
        if zeta is None:
            continue
        order = -1 if least is None else -nearer * zeta.compared(least)
        if order < 0:
            least, found = zeta, [piece]
        elif order == 0:
            found.append(piece)
    return found


def decide(pieces: Sequence[Piece], i: int, j: int, nearer: int) -> Answer:
    """Decide one sample.

    Parameters
    ----------
    pieces : sequence of Piece
        All that may be visible there.
    i, j : int
        The sample.
    nearer : int
        1 if greater zeta is nearer, else -1.

    Returns
    -------
    owner : int
        Number of the piece of least depth in the limit from the right and below, of the lowest
        face if several coincide; -1 if there is none.
    admissible : frozenset of int
        The faces that own the sample in the limits from all directions, and those that coincide
        with them; -1 is the background.
    """
    spots = [beside(i, j), *(beside(i, j, toward) for toward in directions(pieces, i, j))]
    found, *limits = (nearest(pieces, spot, nearer) for spot in spots)
    admissible = {piece.face for limit in (found, *limits) for piece in limit}
    owner = min(found, key=attrgetter("face")).number if found else BACKGROUND
    return owner, frozenset(admissible if all([found, *limits]) else admissible | {BACKGROUND})


# ---------------------------------------------------------------- directions


def directions(pieces: Sequence[Piece], i: int, j: int) -> Iterator[Direction]:
    """Yield directions from a sample, at least one for every limit the answer has there.

    The answer changes only across curves on which a critical polynomial vanishes. Those through
    the sample leave it along the zeros of their terms of lowest degree; between two neighbouring
    such directions the limit is one and the same. Along them it may be a third one if curves
    touch, which lines do not.
    """
    rays: set[Direction] = set()
    curved = False
    critical = chain.from_iterable(piece.critical() for piece in pieces)
    meeting = (one.zeta.norm_of_difference(other.zeta) for one, other in combinations(pieces, 2))
    for polynomial in chain(critical, meeting):
        if sign(polynomial) and polynomial(i, j) == 0:
            local = polynomial.compose(I + i, J + j, ctx=IMAGE)
            rays.update(tangents(local))
            curved = curved or local.total_degree() > 1
    around = sorted(rays, key=turn)
    if curved:
        yield from around
    for one, other in pairwise([*around, *around[:1]]):
        yield between(one, other)


def tangents(local: Polynomial) -> Iterator[Direction]:
    """Yield both ways along every tangent of a curve at the origin, where its polynomial vanishes.

    A slope that is no fraction, which only a singular point of the curve can have, is rounded to
    float64: it serves to separate directions.
    """
    terms = local.to_dict()
    degree = min(sum(powers) for powers in terms)
    lowest = {powers: value for powers, value in terms.items() if sum(powers) == degree}
    slopes = fmpz_poly([lowest.get((degree - power, power), 0) for power in range(degree + 1)])
    lines = [(0, 1)] if slopes.degree() < degree else []
    if slopes.degree() > 0:
        for factor, _ in slopes.factor()[1]:
            lines += _roots(factor)
    for x, y in lines:
        common = gcd(x, y)
        yield x // common, y // common
        yield -x // common, -y // common


def _roots(factor: fmpz_poly) -> list[Direction]:
    """Real roots dy / dx of an irreducible polynomial, as (dx, dy)."""
    if factor.degree() == 1:
        return [(int(factor[1]), -int(factor[0]))]
    roots: Any = factor.complex_roots()
    slopes = [float(root.real.mid()).as_integer_ratio() for root, _ in roots if root.imag == 0]
    return [(dx, dy) for dy, dx in slopes]


def turn(direction: Direction) -> Fraction:
    """Return what grows with the angle: 0 to the right, 1 upwards, 2 to the left, 3 downwards."""
    x, y = direction
    share = Fraction(x, abs(x) + abs(y))
    return 1 - share if y >= 0 else 3 + share


def between(one: Direction, other: Direction) -> Direction:
    """Return a direction after ``one`` and before ``other``, at most half a turn on."""
    if one[0] * other[1] == one[1] * other[0]:
        return -one[1], one[0]
    return one[0] + other[0], one[1] + other[1]
