"""Round solids made ready for rays: their coefficients on the screen, exact and rounded once.

See :mod:`hsr.kernels.raytiles.curved` for what they mean. The points of a line of sight are (O + t V) / s,
see :mod:`hsr.certify.curved`, or O + t V with O[3] = s and V[3] = 0, up to a factor. So the surface p . Q . p
= 0 is met where a t^2 + 2 b t + c = 0 with a = V . Q . V, b = O . Q . V and c = O . Q . O. Under perspective
t is w, and v = g / t: so c v^2 + 2 b g v + a g^2 = 0, and c is constant. In a parallel view t is depth, and v
= -t / g: so a g^2 v^2 - 2 b g v + c = 0, and a is constant.
"""

from __future__ import annotations

from fractions import Fraction
from math import isqrt
from typing import Any, NamedTuple, cast

import numpy as np

from hsr.algorithms.prepare.behind_eye import w_at_depth_1
from hsr.base.arrays import Array, Floats
from hsr.certify import sights_at
from hsr.kernels.culling import CULL_BACK, CULL_FRONT
from hsr.kernels.raytiles.curved import QUADRIC
from hsr.kernels.zbuffer.setup import ANYWHERE, SMALL, Eye
from hsr.problem.view import View
from hsr.scene.shapes import Quadric


def quadrics_of(view: View, things: Array, pieces: Array, extent: Floats, eye: Eye) -> Array:
    """Set up the round solids of a view.

    Parameters
    ----------
    view : View
    things : (n,) int64
        Their indices among the objects.
    pieces : (n,) int64
        Numbers of their first pieces, see :func:`hsr.certify.first_pieces`.
    extent : (n, 4) float64
        First and end column, first and end line that each may cover.
    eye : Eye

    Returns
    -------
    (n,) QUADRIC
    """
    made = np.zeros(len(things), QUADRIC)
    if not len(things):
        return made
    placements = [view.placements[thing] for thing in things]
    made["cull"] = [placement.cull for placement in placements]
    made["piece"] = pieces
    made["left"], made["right"], made["top"], made["bottom"] = extent.T
    frame, origin, step, scale = sights_at(view, things)
    # Count columns and lines from the first that an object may cover; the frame has two units to each.
    to_place = np.zeros((len(things), 3, 3), object)
    to_place[:, 0, 0], to_place[:, 1, 1], to_place[:, 2, 2] = 2, -2, 1
    to_place[:, 0, 2] = 2 * made["left"].astype(object) + 1 - view.width
    to_place[:, 1, 2] = view.height - 1 - 2 * made["top"].astype(object)
    g = Fraction(float(eye.scale)) * Fraction(w_at_depth_1(view)) * frame.unit
    if not view.perspective:
        g = frame.unit / Fraction(float(eye.scale))
    for one, placement, o, v, s in zip(
        made, placements, origin @ to_place, step @ to_place, scale, strict=True
    ):
        # As objects: NumPy would make a list with a number of 64 bits one of floats.
        last = np.array([[0, 0, s], [0, 0, 0]], object)
        line = _Sight(np.vstack([o, last[:1]]), np.vstack([v, last[1:]]), g, view.perspective)
        _set_up(one, line, cast(Quadric, placement.shape.quadric), placement.shape.faces - 1)
    return made


class _Sight(NamedTuple):
    """The lines of sight of an object, O and V (4, 3) as functions of (x, y, 1), and what makes v of t."""

    o: Array
    v: Array
    g: Fraction
    perspective: bool


def _set_up(one: Any, sight: _Sight, solid: Quadric, discs: int) -> None:
    """Fill in the coefficients of one ``QUADRIC``; the first ``discs`` of its ends are faces."""
    k, l, m = _equation(sight, solid.form)  # noqa: E741
    r = np.outer(l, l) - k * m
    width, height = int(one["right"] - one["left"]), int(one["bottom"] - one["top"])
    affine = np.array([1, width, height], object)
    square = np.array([1, width, height, width**2, width * height, height**2], object)
    size_l = abs(l[_AFFINE]) @ affine
    size_m, size_r = (abs(_coefficients(form)) @ square for form in (m, r))
    # L and the root of R are compared with each other: divide by the larger one.
    common = max(size_l, isqrt(size_r)) or size_m or 1
    if max(abs(k), size_m) < common << 400:
        one["k"], one["l"] = k / common, l[_AFFINE] / common
        one["m"], one["r"] = _coefficients(m) / common, _coefficients(r) / common**2
        one["size_l"], one["size_m"] = size_l / common, size_m / common
        # Only where R is 0 all over it counts as certain that nothing is met.
        one["size_r"] = max(size_r / common**2, SMALL) if size_r else 0.0
    else:
        # Float64 cannot compute with such numbers: a hit may be anywhere.
        one["k"], one["size_m"], one["size_r"] = 1.0, ANYWHERE**2, ANYWHERE**2
    one["ends"] = len(solid.ends)
    for end, plane in enumerate(solid.ends):
        p, q = _end(sight, plane)
        size = max(abs(p), abs(q[_AFFINE]) @ affine) or 1
        one["p"][end], one["q"][end] = p / size, q[_AFFINE] / size
        # A ray that meets an end from outside comes from beyond it, where P is negative.
        culled = one["cull"] == (CULL_FRONT if p < 0 else CULL_BACK)
        one["shown"][end] = end < discs and p != 0 and not culled


_AFFINE = [2, 0, 1]
"""From the order (x, y, 1) to (1, x, y)."""


def _coefficients(form: Array) -> Array:
    """Return the coefficients of 1, x, y, x^2, x y and y^2 of a quadratic form (3, 3) in (x, y, 1)."""
    twice = form + form.T
    constant, right, below = form[2, 2], twice[0, 2], twice[1, 2]
    return np.array([constant, right, below, form[0, 0], twice[0, 1], form[1, 1]], object)


def _equation(sight: _Sight, form: Array) -> tuple[int, Array, Array]:
    """Return K, L (3,) and M (3, 3), in whole numbers, of p . form . p."""
    o, v = sight.o, sight.v
    a, b, c = v.T @ form @ v, o.T @ form @ v, o.T @ form @ o
    above, below = sight.g.numerator, sight.g.denominator
    if sight.perspective:
        return c[2, 2] * below**2, b[2] * (above * below), a * above**2
    return a[2, 2] * above**2, -b[:, 2] * (above * below), c * below**2


def _end(sight: _Sight, plane: Array) -> tuple[int, Array]:
    """Return P and Q (3,), in whole numbers, of plane . p, up to a positive factor."""
    offset, slope = plane @ sight.o, plane @ sight.v
    above, below = sight.g.numerator, sight.g.denominator
    if sight.perspective:
        return offset[2] * below, slope * above
    return -slope[2] * above, offset * below
