"""What float64 can prove: for every sample, the pieces that may be nearest there.

Every bound below is a forward analysis (Higham, "Accuracy and Stability of Numerical Algorithms",
section 3.1) with u = 2^-53; i and j are exact, and every coefficient is rounded three times at most. A sum
of n products, rounded m times in all on the way into each, is off by at most
(n + m) u / (1 - (n + m) u) times the sum of their absolute values. Here n + m <= 9, and ``ROUNDING``
is 16 u: that also covers the roundings of the bound itself and of what it is compared with. Against
underflow, coefficients are scaled to at most 1 and bounds are at least ``TINY``.

Depth is compared by a *key*, -zeta or zeta, so that the least key is nearest.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.base.jit import jit
from hsr.exact.decide import Piece
from hsr.exact.infinitesimals import Polynomial, Surd, coefficients
from hsr.exact.planes import Triangles, bounds, ratio

ROUNDING = 2.0**-49
TINY = 2.0**-1000
TINY_SLOPE = 2.0**-500


class Candidates(NamedTuple):
    """The pieces that may be nearest, sample after sample, row after row.

    Attributes
    ----------
    start : (H W + 1,) int64
        Those of sample k are ``piece[start[k]:start[k + 1]]``.
    piece : (n,) int32
        Triangles by their number, then rounds by theirs, ascending.
    sure : (n,) bool
        Whether the piece is at the sample for certain, and at all samples near by.
    """

    start: Array
    piece: Ints
    sure: Bools


def candidates(flat: TriangleTables, curved: RoundTables, height: int, width: int) -> Candidates:
    """List for every sample the pieces that may be nearest there.

    A sample without any shows the background, one with a single piece that is sure shows that;
    both for certain. No other sample is settled.
    """
    reach = np.full((height, width), np.inf)

    def visit(slot: Array, piece: Ints, sure: Bools) -> None:
        visit_triangles(flat, reach, slot, piece, sure)
        visit_rounds(curved, reach, slot, piece, sure, len(flat.key))

    nothing = np.zeros(0, np.int32), np.zeros(0, np.bool_)
    visit(np.zeros((0, 0), np.int64), *nothing)
    count = np.zeros((height, width), np.int64)
    visit(count, *nothing)
    start = np.concatenate([[0], np.cumsum(count)])
    piece, sure = np.zeros(start[-1], np.int32), np.zeros(start[-1], np.bool_)
    visit(start[:-1].reshape(height, width).copy(), piece, sure)
    return Candidates(start, piece, sure)


# ---------------------------------------------------------------- triangles


class TriangleTables(NamedTuple):
    """Triangles in float64.

    Attributes
    ----------
    half : (n, 5, 3) float64
        Half-planes, the greatest coefficient of each scaled to 1.
    slack : (n, 5) float64
        Bound of the error of their values.
    key : (n, 3) float64
    key_slack : (n,) float64
        Bound of the error of the key.
    box : (n, 4) int32
    """

    half: Floats
    slack: Floats
    key: Floats
    key_slack: Floats
    box: Ints


def triangle_tables(triangles: Triangles, nearer: int, width: int, height: int) -> TriangleTables:
    """Round the triangles to float64."""
    half = np.zeros(triangles.half.shape)
    half[:, :, 2] = 1.0
    told = bounds(triangles.half)
    half[told] = _proportions(triangles.half[told])
    # What is left out is far below the slack; it would overflow as a divisor.
    half[np.abs(half) < TINY_SLOPE] = 0.0
    key = -nearer * ratio(triangles.zeta, triangles.det[:, None])
    ends = np.array([width, height, 1.0])
    slack = ROUNDING * (np.abs(half) @ ends) + TINY
    with np.errstate(over="ignore"):
        key_slack = ROUNDING * (np.abs(key) @ ends) + TINY
    # A plane too steep for float64 may have any key.
    key[~np.isfinite(key_slack)] = 0.0
    return TriangleTables(half, slack, key, key_slack, triangles.box)


def _proportions(half: Array) -> Floats:
    """Scale the greatest coefficient of each row (n, 3) to 1; each is rounded twice."""
    try:
        rounded = half.astype(np.float64)
    except OverflowError:
        rounded = (half / np.abs(half).max(axis=1, keepdims=True)).astype(np.float64)
    return np.asarray(rounded / np.abs(rounded).max(axis=1, keepdims=True))


@jit
def narrowed(half: Floats, slack: float, j: int, width: int) -> tuple[int, int, int, int]:
    """Cut a row of the image by a half-plane a i + b j + c >= 0.

    Returns
    -------
    first, last : int
        Columns that may be inside.
    surely_first, surely_last : int
        Columns that are strictly inside.
    """
    a = half[0]
    at_middle = half[1] * j + half[2]
    if a == 0.0:
        possible, sure = at_middle >= -slack, at_middle > slack
        return 0, width - 1 if possible else -1, 0, width - 1 if sure else -1
    crossing = -at_middle / a
    # Proven where |a| |i - crossing| > slack; the rest is for the roundings of crossing and columns.
    margin = 2.0 * slack / abs(a) + ROUNDING * (abs(crossing) + width)
    low = min(max((crossing - margin + width - 1.0) / 2.0, -1.0), width + 0.0)
    high = min(max((crossing + margin + width - 1.0) / 2.0, -1.0), width + 0.0)
    if a > 0.0:
        return int(np.ceil(low)), width - 1, int(np.floor(high)) + 1, width - 1
    return 0, int(np.floor(high)), 0, int(np.ceil(low)) - 1


@jit
def span(half: Floats, slack: Floats, j: int, width: int, box: Ints) -> tuple[int, int, int, int]:
    """Cut a row by all half-planes of a triangle; returns columns as :func:`narrowed` does."""
    first, last = int(box[1]), int(box[3])
    surely_first, surely_last = first, last
    for k in range(len(half)):
        low, high, sure_low, sure_high = narrowed(half[k], slack[k], j, width)
        first, last = max(first, low), min(last, high)
        surely_first, surely_last = max(surely_first, sure_low), min(surely_last, sure_high)
    return first, last, surely_first, surely_last


@jit
def visit_triangles(flat: TriangleTables, reach: Floats, slot: Array, piece: Ints, sure: Bools) -> None:
    """Lower ``reach`` (H, W) to the greatest key that a triangle surely at the sample can have.

    Given slots (H, W), write instead what may be nearest at each sample from its slot on, which moves along.
    With empty ``piece`` and ``sure`` nothing is written: the slots count.
    """
    half, slack, key, key_slack, box = flat
    height, width = reach.shape
    for t in range(len(key)):
        for row in range(box[t, 0], box[t, 2] + 1):
            j = height - 1 - 2 * row
            first, last, surely_first, surely_last = span(half[t], slack[t], j, width, box[t])
            middle = key[t, 1] * j + key[t, 2]
            if len(slot) == 0:
                lower(reach[row], key[t, 0], middle + key_slack[t], surely_first, surely_last)
                continue
            nearest = middle - key_slack[t]
            for column in range(first, last + 1):
                if key[t, 0] * (2 * column + 1 - width) + nearest <= reach[row, column]:
                    if len(piece) > 0:
                        piece[slot[row, column]] = t
                        sure[slot[row, column]] = surely_first <= column <= surely_last
                    slot[row, column] += 1


@jit
def lower(reach: Floats, slope: float, middle: float, first: int, last: int) -> None:
    """Lower a row of reaches to a key that is affine, from a first to a last column."""
    for column in range(first, last + 1):
        reach[column] = min(reach[column], slope * (2 * column + 1 - len(reach)) + middle)


# ---------------------------------------------------------------- curved pieces


class RoundTables(NamedTuple):
    """Curved pieces in float64; a polynomial in (i, j) has six coefficients.

    Attributes
    ----------
    surd : (n, 4, 6) float64
        p, q, r and s of the key (p + q sqrt(r)) / s.
    extent : (n, 6) float64
    offset : (n, F, 6) float64
    slope : (n, F) float64
        Of the forms, for the key in place of zeta; F is the most of any piece, missing ones are 1.
    box : (n, 4) int32
    """

    surd: Floats
    extent: Floats
    offset: Floats
    slope: Floats
    box: Ints


def round_tables(rounds: Sequence[Piece], nearer: int) -> RoundTables:
    """Round the curved pieces to float64."""
    surd, extent = np.zeros((len(rounds), 4, 6)), np.zeros((len(rounds), 6))
    forms = max((len(piece.inside) for piece in rounds), default=0)
    offset, slope = np.zeros((len(rounds), forms, 6)), np.zeros((len(rounds), forms))
    offset[:, :, 5] = 1.0
    box = np.zeros((len(rounds), 4), dtype=np.int32)
    for n, piece in enumerate(rounds):
        box[n], (bound,) = piece.box, piece.extent
        surd[n] = _surd_table(piece.zeta, nearer)
        extent[n] = _scaled(bound, _greatest(bound))
        for k, (constant, factor) in enumerate(piece.inside):
            greatest = max(_greatest(constant), _greatest(factor))
            offset[n, k] = _scaled(constant, greatest)
            slope[n, k] = -nearer * _scaled(factor, greatest)[5]
    return RoundTables(surd, extent, offset, slope, box)


def _surd_table(zeta: Surd, nearer: int) -> Floats:
    greatest = max(_greatest(zeta.p), _greatest(zeta.s))
    # The root is scaled with r, and q, which is -1, 0 or 1, not at all.
    scales, parts = (greatest, 1, greatest**2, greatest), (-nearer * zeta.p, -nearer * zeta.q, zeta.r, zeta.s)
    return np.array([_scaled(part, scale) for part, scale in zip(parts, scales, strict=True)])


def _greatest(polynomial: Polynomial) -> int:
    return max((abs(int(value)) for value in polynomial.coeffs()), default=1)


def _scaled(polynomial: Polynomial, divisor: int) -> Floats:
    return ratio(coefficients(polynomial), divisor)


@jit
def conic(polynomial: Floats, i: int, j: int) -> tuple[float, float]:
    """Return bounds of a i^2 + b i j + c j^2 + d i + e j + f."""
    a, b, c = polynomial[0] * (i * i), polynomial[1] * (i * j), polynomial[2] * (j * j)
    d, e, f = polynomial[3] * i, polynomial[4] * j, polynomial[5]
    value = a + b + c + d + e + f
    error = ROUNDING * (abs(a) + abs(b) + abs(c) + abs(d) + abs(e) + abs(f)) + TINY
    return value - error, value + error


@jit
def key_between(surd: Floats, i: int, j: int) -> tuple[float, float]:
    """Return bounds of (p + q sqrt(r)) / s; infinite ones if s may be 0."""
    s_low, s_high = conic(surd[3], i, j)
    if s_low <= 0.0 <= s_high:
        return -np.inf, np.inf
    p_low, p_high = conic(surd[0], i, j)
    r_low, r_high = conic(surd[2], i, j)
    one, other = surd[1, 5] * np.sqrt(max(r_low, 0.0)), surd[1, 5] * np.sqrt(max(r_high, 0.0))
    low, high = p_low + min(one, other), p_high + max(one, other)
    least = min(min(low / s_low, low / s_high), min(high / s_low, high / s_high))
    greatest = max(max(low / s_low, low / s_high), max(high / s_low, high / s_high))
    # Root, sum and quotient round once each, the sum relative to its larger term.
    error = ROUNDING * (max(abs(p_low), abs(p_high)) + abs(other)) / min(abs(s_low), abs(s_high)) + TINY
    if error == np.inf:
        return -np.inf, np.inf
    return least - error, greatest + error


@jit
def round_at(curved: RoundTables, t: int, i: int, j: int) -> tuple[int, float, float]:
    """Judge a piece at a sample: 0 not there, 1 perhaps, 2 surely; and bounds of its key."""
    offset, slope = curved.offset[t], curved.slope[t]
    low, high = conic(curved.extent[t], i, j)
    if high < 0.0:
        return 0, 0.0, 0.0
    verdict = 2 if low > 0.0 else 1
    low, high = key_between(curved.surd[t], i, j)
    if high == np.inf:
        return 1, low, high
    for k in range(len(offset)):
        least, greatest = conic(offset[k], i, j)
        one, other = slope[k] * low, slope[k] * high
        error = ROUNDING * (abs(one) + abs(other) + abs(least) + abs(greatest))
        if greatest + max(one, other) + error < 0.0:
            return 0, 0.0, 0.0
        verdict = min(verdict, 2 if least + min(one, other) - error > 0.0 else 1)
    return verdict, low, high


@jit
def visit_rounds(
    curved: RoundTables, reach: Floats, slot: Array, piece: Ints, sure: Bools, number: int
) -> None:
    """Do as :func:`visit_triangles` does; the pieces are numbered from ``number``."""
    box = curved.box
    height, width = reach.shape
    for t in range(len(box)):
        for row in range(box[t, 0], box[t, 2] + 1):
            for column in range(box[t, 1], box[t, 3] + 1):
                i, j = 2 * column + 1 - width, height - 1 - 2 * row
                verdict, nearest, farthest = round_at(curved, t, i, j)
                if len(slot) == 0:
                    reach[row, column] = min(reach[row, column], farthest if verdict == 2 else np.inf)
                elif verdict > 0 and nearest <= reach[row, column]:
                    if len(piece) > 0:
                        piece[slot[row, column]], sure[slot[row, column]] = number + t, verdict == 2
                    slot[row, column] += 1
