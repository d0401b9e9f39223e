"""Depths of owners: in doubled precision where that will do, else from integers of any length."""

from __future__ import annotations

from math import isqrt

import numpy as np

from hsr.base.arrays import Floats, Ints
from hsr.exact.decide import Piece
from hsr.exact.double_double import bits, depths, split
from hsr.exact.infinitesimals import at, beside, coefficients
from hsr.exact.numbers import Frame
from hsr.exact.problem import Problem

GUARD = 70
"""Bits beyond those that the subtraction in p + q sqrt(r) can cancel."""


def depths_of(problem: Problem, owner: Ints) -> Floats:
    """Return the depth (H W,) of the piece ``owner`` of every sample, infinite for the background.

    Each is rounded from a number within 2^-60 of the true depth, relative to it: the error is less
    than 0.51 ulp.
    """
    depth = np.full(len(owner), np.inf)
    owned = np.flatnonzero(owner >= 0)
    owners, which = np.unique(owner[owned], return_inverse=True)
    surds = np.concatenate([_flat_surds(problem, owners), _curved_surds(problem, owners)])
    depth[owned] = depths(surds, _forms(problem.frame), which, *problem.at(owned))
    unsure = np.flatnonzero(np.isnan(depth))
    for sample, i, j in zip(unsure, *problem.exactly_at(unsure), strict=True):
        above, below = depth_quotient(problem.frame, problem.piece(int(owner[sample])), i, j)
        depth[sample] = above / below
    return depth


# ---------------------------------------------------------------- doubled precision


def _forms(frame: Frame) -> Floats:
    """Turn the forms of a depth into four polynomials for :func:`hsr.exact.double_double.depths`."""
    forms = np.array([frame.depth, frame.unit])
    scale = np.repeat(bits(forms).max(), 2)
    table = np.zeros((4, 3, 6))
    table[::2, :, 3:] = split(forms[:, :3], scale)
    table[1::2, :, 5:] = split(forms[:, 3:], scale)
    return table


def _flat_surds(problem: Problem, owners: Ints) -> Floats:
    flat = owners[owners < len(problem.triangles)]
    table = np.zeros((len(flat), 4, 3, 6))
    if len(flat):
        zeta, det = problem.triangles.zeta[flat], problem.triangles.det[flat, None]
        scale = bits(np.hstack([zeta, det]))
        table[:, 0, :, 3:], table[:, 3, :, 5:] = split(zeta, scale), split(det, scale)
    return table


def _curved_surds(problem: Problem, owners: Ints) -> Floats:
    """Scale p and s by one power of two, and r by its square."""
    curved = owners[owners >= len(problem.triangles)]
    table = np.zeros((len(curved), 4, 3, 6))
    if len(curved):
        zetas = [problem.piece(int(number)).zeta for number in curved]
        p, q, r, s = (np.array([coefficients(getattr(zeta, k)) for zeta in zetas]) for k in "pqrs")
        scale = bits(np.hstack([p, s]))
        table[:, 0], table[:, 2], table[:, 3] = split(p, scale), split(r, 2 * scale), split(s, scale)
        table[:, 1, 0] = q.astype(np.float64)
    return table


# ---------------------------------------------------------------- integers


def depth_quotient(frame: Frame, piece: Piece, i: int, j: int) -> tuple[int, int]:
    """Return the depth of a piece at a sample where it is, exact on a plane, else to within 2^-69 of it.

    Unless p + q sqrt(r) is 0, its product with p - q sqrt(r) is an integer other than 0; so it is
    at least 1 / (|p| + sqrt(r)). A root with as many bits after the point as that has before it,
    and ``GUARD`` more, leaves a relative error of 2^-GUARD at most.
    """
    p, q, r, s = (int(x(i, j)) for x in (piece.zeta.p, piece.zeta.q, piece.zeta.r, piece.zeta.s))
    if s == 0:
        # The line of sight runs along a line on a cone; beside it, every one there is meets the apex.
        p, s = (int(at(x, beside(i, j)).coeffs()[-1]) for x in (piece.zeta.p, piece.zeta.s))
    after = GUARD + max(p.bit_length(), r.bit_length()) if q else 0
    zeta, unit = (p << after) + q * isqrt(max(r, 0) << 2 * after), s << after
    above, below = ((a * i + b * j + c) * unit + k * zeta for a, b, c, k in (frame.depth, frame.unit))
    return above, below
