"""Spheres, cylinders and cones as the rays of a picture meet them, with proven error bounds.

Nearness, scaled like key depth, is called v here: z = Z0 - v. Along a ray a quadric is met where

    K v^2 + 2 L v + M = 0        v = (-L + S) / K where the ray enters, (-L - S) / K where it leaves,

S = sqrt(R), R = L^2 - K M. The polynomial, negative inside, has the slope 2 S at the first: it grows toward
the eye, which is outside there, whatever the sign of K. K is constant, L affine, M and R are quadratic on the
screen: the quadric, in the frame of the screen, is a quadric again (J. Blinn, "How many ways can you draw a
circle?", IEEE Computer Graphics and Applications 7(8), 1987, draws all of them so). Their coefficients are
taken from exact integers and rounded once (:mod:`hsr.algorithms.prepare.quadrics`), R among them, so that the
difference it is does not cancel. The solid ends where P v + Q = 0 for each of up to two planes, P constant
and Q affine; inside P v + Q > 0. So much holds of every quadric; what the planes leave of it need not be met
in an order: of a cone with K < 0 a ray leaves one nappe before it enters the other, and one of these hits is
beyond an end.

A hit has a margin: 1 or more if it is certain that it counts, -1 or less if it is certain that it does not.
U is the relative error of one rounding; bounds are rounded up generously.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hsr.base.arrays import Array, Floats
from hsr.base.jit import jit
from hsr.kernels.culling import CULL_BACK, CULL_FRONT
from hsr.kernels.zbuffer.fill import TRIANGLES, Box, Tile, is_farther, key_of, write
from hsr.kernels.zbuffer.setup import ANYWHERE, FARTHEST, Eye, U, key_depth, nearness_error

QUADRIC = np.dtype(
    [
        ("ends", np.int64),
        ("cull", np.int64),
        ("piece", np.int64),
        ("left", np.int64),
        ("right", np.int64),
        ("top", np.int64),
        ("bottom", np.int64),
        ("k", np.float64),
        ("l", np.float64, 3),
        ("m", np.float64, 6),
        ("r", np.float64, 6),
        ("size_l", np.float64),
        ("size_m", np.float64),
        ("size_r", np.float64),
        ("p", np.float64, 2),
        ("q", np.float64, (2, 3)),
        ("shown", np.int8, 2),
    ]
)
"""A round solid.

ends : how many planes cut it off; two at most.
piece : number of its first piece, which is the quadric; those of the ends follow.
left, right, top, bottom : the first column and row that it may cover, and those after the last.
k, l, m, r : coefficients of K, L (of 1, x, y), M and R (of 1, x, y, x^2, x y, y^2), x columns and y rows from
    the first; those of K and L, of M, and of R are divided by a common number, by it, and by its square.
size_l, size_m, size_r : bounds of the sums of the magnitudes of the terms of L, M and R.
p, q : P and Q (of 1, x, y) of the ends; the terms of each add up to at most 1 in magnitude.
shown : 1 if an end is a face, and neither culled nor seen edge-on.
"""

FEW = 8.0 * U
"""Bound of the error of an affine or quadratic function, relative to the sum of the magnitudes of its terms:
a rounding of each coefficient, and at most five in the evaluation of each term."""


class Hit(NamedTuple):
    """A point of a surface on a ray: v, a bound of its error, and the margin by which it counts."""

    v: float
    error: float
    margin: float


MISS = Hit(0.0, 0.0, -1.0)

Hits = tuple[Hit, Hit, Hit, Hit]
"""Where a ray enters and leaves a quadric, and where it meets the two ends."""


@jit
def affine(c: Floats, x: float, y: float) -> float:
    """Return ``c . (1, x, y)``."""
    return float(c[0] + c[1] * x + c[2] * y)


@jit
def quadratic(c: Floats, x: float, y: float) -> float:
    """Return ``c . (1, x, y, x^2, x y, y^2)``."""
    return float(c[0] + (c[1] + c[3] * x + c[4] * y) * x + (c[2] + c[5] * y) * y)


@jit
def quotient(a: float, a_error: float, b: float, b_error: float) -> tuple[float, float]:
    """Divide, and bound the error.

    (a + da) / (b + db) is off by (|da| + |a / b| |db|) / |b|, at most twice that if |db| is at most half of
    |b|, and by anything beyond: more than any v that counts.
    """
    if b == 0.0 or b_error > 0.5 * abs(b):
        return 0.0, ANYWHERE
    value = a / b
    return value, 2.0 * (a_error + abs(value) * b_error) / abs(b) + 2.0 * U * abs(value)


# ---------------------------------------------------------------- hits


@jit
def meet_quadric(thing: Any, x: float, y: float) -> tuple[Hit, Hit]:
    """Return where a ray enters and leaves a quadric that has no end.

    If R is not above 0 it meets nothing: a tangent sees the surface edge-on. If K is 0, the eye is on the
    surface, and one of the two hits is the eye itself, which sees nothing there; or, in a parallel view, rays
    run along lines on a cone, and one of the two is infinitely far away.
    """
    # Each coefficient of R is off by U of itself, and the sum by FEW of its terms: |dR| <= r_error.
    r, r_error = quadratic(thing["r"], x, y), FEW * thing["size_r"]
    if r <= -r_error:
        return MISS, MISS
    # Two roots of numbers e apart differ by e over their sum, and by at most sqrt(e).
    s = np.sqrt(max(r, 0.0))
    s_error = 2.0 * r_error / max(s, np.sqrt(r_error)) + 2.0 * U * s
    margin = r / r_error

    # Add S and L so that they do not cancel: |q| = S + |L|. It is one root times K, and the other is M over
    # it, as their product is M / K. What q is off by is what S and L are, and its own rounding.
    k, l = thing["k"], affine(thing["l"], x, y)  # noqa: E741
    q = s - l if l <= 0.0 else -s - l
    q_error = s_error + FEW * thing["size_l"] + U * abs(q)
    over_k = Hit(*quotient(q, q_error, k, U * abs(k)), margin) if k != 0.0 else MISS
    m, m_error = quadratic(thing["m"], x, y), FEW * thing["size_m"]
    under_m = Hit(*quotient(m, m_error, q, q_error), margin)
    return (over_k, under_m) if l <= 0.0 else (under_m, over_k)


@jit
def between_ends(hit: Hit, thing: Any, x: float, y: float) -> Hit:
    """Return a hit of an endless quadric as one between its ends, closed.

    Where v is off by dv, P v + Q is off by |P| dv, and by FEW of its terms: of |P v| + 1 at most.
    """
    v, v_error, margin = hit
    if margin <= -1.0:
        return hit
    for end in range(thing["ends"]):
        p, q = thing["p"][end], affine(thing["q"][end], x, y)
        margin = min(margin, (p * v + q) / (abs(p) * v_error + FEW * (abs(p * v) + 1.0)))
    return Hit(v, v_error, margin)


@jit
def meet_end(end: int, thing: Any, x: float, y: float) -> Hit:
    """Return where a ray meets an end: in its plane, where K v^2 + 2 L v + M <= 0.

    Q is off by FEW of its terms, at most 1, and P by a rounding: so much for v. Where v is off by dv, the
    polynomial is off by (2 |K v + L| + |K| dv) dv, which is less than ``slope`` dv, and by FEW of its terms.
    """
    k, p = thing["k"], thing["p"][end]
    v, v_error = quotient(-affine(thing["q"][end], x, y), FEW, p, U * abs(p))
    outside = (k * v + 2.0 * affine(thing["l"], x, y)) * v + quadratic(thing["m"], x, y)
    size = abs(k * v) * abs(v) + 2.0 * thing["size_l"] * abs(v) + thing["size_m"]
    slope = 2.0 * (abs(k * v) + thing["size_l"]) + abs(k) * v_error
    return Hit(v, v_error, -outside / (slope * v_error + FEW * size))


@jit
def hits_of(thing: Any, x: float, y: float) -> Hits:
    """Return the hits of a ray, those on culled sides and on ends seen edge-on left out."""
    enter, leave = meet_quadric(thing, x, y)
    enter, leave = between_ends(enter, thing, x, y), between_ends(leave, thing, x, y)
    first = meet_end(0, thing, x, y) if thing["shown"][0] else MISS
    second = meet_end(1, thing, x, y) if thing["shown"][1] else MISS
    cull = thing["cull"]
    return enter if cull != CULL_FRONT else MISS, leave if cull != CULL_BACK else MISS, first, second


@jit
def piece_of(thing: Any, k: int) -> int:
    """Return the piece that hit k of a ray is on: the two of the quadric are on its first."""
    return int(thing["piece"] + max(k - 1, 0))


@jit
def key_hit(hit: Hit, eye: Eye) -> Hit:
    """Return a hit with its key depth in place of v, and the margin by which it lies between near and far.

    Nearness counts depth for w, see :func:`hsr.kernels.zbuffer.setup.nearness_error`; front and v are
    rounded when the one is taken from the other.
    """
    at_eye = key_depth(0.0, eye)
    z, slack = at_eye - hit.v, nearness_error(abs(hit.v) / eye.scale, eye) * eye.scale
    error = hit.error + slack + 8.0 * U * (abs(at_eye) + abs(hit.v))
    # What is less certain than a tie may be a hit, but not a certain one.
    margin = min(hit.margin, 0.5) if error > eye.tie else hit.margin
    error = max(error, eye.tie)
    return Hit(z, error, min(margin, min((z - eye.near) / error, (eye.far - z) / error)))


# ---------------------------------------------------------------- casting


@jit
def cast_into_quadric(thing: Any, tile: Tile, eye: Eye, doubts: Array | None, counts: Array) -> None:
    """Meet a round solid, a ``QUADRIC``, with every ray of a tile that it may cover.

    Parameters
    ----------
    thing : QUADRIC
    tile : Tile
    eye : Eye
    doubts : (room,) DOUBT or None
        None leaves doubts alone: what is undecided goes to the side it seems to be on.
    counts : (COUNTS,) int64
    """
    counts[TRIANGLES] += 1
    doubtful = fill(thing, tile, eye, None if doubts is None else True)
    if doubts is not None and doubtful:
        note(thing, tile, eye, doubts, counts)


@jit
def box_of(thing: Any, tile: Tile) -> Box:
    """Return the samples of the image that are in a tile and may be covered."""
    first_line, first_column = max(thing["top"], tile.line), max(thing["left"], tile.column)
    return first_line, min(thing["bottom"], tile.end_line), first_column, min(thing["right"], tile.end_column)


@jit
def fill(thing: Any, tile: Tile, eye: Eye, certify: bool | None) -> bool:
    """Take into the keys the hits that are certain, and certainly nearer; return whether there are doubts.

    Without certification, a hit counts if it seems to.
    """
    least_margin, gap = (0.0, 0) if certify is None else (1.0, tile.gap)
    keys, mask, doubtful = tile.keys, tile.mask, False
    first_line, end_line, first, end = box_of(thing, tile)
    for line in range(first_line, end_line):
        here = keys[line - tile.line]
        for column in range(first, end):
            hits = hits_of(thing, float(column - thing["left"]), float(line - thing["top"]))
            for k in range(4):
                if hits[k].margin <= -1.0:
                    continue
                z, _, margin = key_hit(hits[k], eye)
                if margin >= least_margin:
                    key, old = key_of(z, mask, piece_of(thing, k)), here[column - tile.column]
                    if old - key > gap:
                        here[column - tile.column] = key
                    else:
                        doubtful |= key != old and old - key >= -gap
                else:
                    doubtful |= not margin <= -1.0
    return doubtful


@jit
def note(thing: Any, tile: Tile, eye: Eye, doubts: Array, counts: Array) -> None:
    """Write down the doubts of a solid that has just been taken into the keys."""
    first_line, end_line, first, end = box_of(thing, tile)
    for line in range(first_line, end_line):
        for column in range(first, end):
            hits = hits_of(thing, float(column - thing["left"]), float(line - thing["top"]))
            sample, old = line * tile.width + column, tile.keys[line - tile.line, column - tile.column]
            for k in range(4):
                if hits[k].margin <= -1.0:
                    continue
                z, error, margin = key_hit(hits[k], eye)
                if margin >= 1.0:
                    key = key_of(z, tile.mask, piece_of(thing, k))
                    if key != old and abs(old - key) <= tile.gap:
                        write(doubts, counts, sample, key, True)
                elif not margin <= -1.0:
                    nearest = min(max(z - error, 1.0), FARTHEST)
                    key = key_of(nearest, tile.mask, piece_of(thing, k))
                    if not is_farther(key, old, tile.gap):
                        write(doubts, counts, sample, key, False)
