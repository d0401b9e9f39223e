"""Depths of owners: in doubled precision where that will do, else from integers of any length."""

from __future__ import annotations

from math import isqrt

import numpy as np

from hsr.base.arrays import Floats, Ints
from hsr.exact.decide import Piece
from hsr.exact.double_double import bits, depths, split
from hsr.exact.infinitesimals import at, beside, coefficients, sign
from hsr.exact.numbers import Frame
from hsr.exact.planes import on_planes
from hsr.exact.problem import Problem
from hsr.exact.quadrics import form

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
    with np.errstate(all="ignore"):  # of what overflows there is no number, and below it is had from integers
        depth[owned] = depths(*_quotients(problem, owners), which, *problem.frame.at(owned))
    unsure = np.flatnonzero(np.isnan(depth))
    for sample, i, j in zip(unsure, *problem.frame.exactly_at(unsure), strict=True):
        above, below = depth_quotient(problem.frame, problem.piece(int(owner[sample])), i, j)
        depth[sample] = above / below
    return depth


# ---------------------------------------------------------------- doubled precision


def _quotients(problem: Problem, owners: Ints) -> tuple[Floats, Floats]:
    """Return numerators and denominators of the depths of pieces (n,), as :func:`depths` takes them.

    Depth is a quotient of two forms. Both are scaled by one power of two, what is below roots by its square.
    """
    forms = problem.frame.depth, problem.frame.unit
    flats = int(np.searchsorted(owners, len(problem.triangles)))
    parts, signs = np.zeros((len(owners), 2, 2, 3, 6)), np.zeros((len(owners), 2))
    zeta, det = problem.triangles.zeta[owners[:flats]], problem.triangles.det[owners[:flats]]
    planes = np.stack([on_planes(each, zeta, det) for each in forms], axis=1)
    lengths = bits(planes)
    parts[:flats, :, 0, :, 3:] = split(planes, lengths.max(axis=1), lengths)
    if flats < len(owners):
        rounds = [problem.piece(int(number)).zeta for number in owners[flats:]]
        surds = [[zeta.affine(*form(each)[::-1]) for each in forms] for zeta in rounds]
        p = np.array([[coefficients(surd.p) for surd in pair] for pair in surds])
        r = np.array([[coefficients(surd.q**2 * surd.r) for surd in pair] for pair in surds])
        lengths = bits(p)
        scale = lengths.max(axis=1)
        parts[flats:, :, 0], parts[flats:, :, 1] = split(p, scale, lengths), split(r, 2 * scale, bits(r))
        signs[flats:] = [[sign(surd.q) for surd in pair] for pair in surds]
    return parts, signs


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
