"""Which triangles the line of a ray may meet: all but those that float64 proves it passes by."""

from __future__ import annotations

import math

import numpy as np

from hsr.base.arrays import Array, Bools
from hsr.base.jit import jit

ROUNDING = 2.0**-48
"""Bound of the error of an edge value in float64, relative to the lengths of edge and direction and to the
sum of the distances of its corners.

Each of the six products has three factors: two differences, one of them of corners, and a sum of two that are
rounded themselves. With the sums of the products fewer than ten roundings of 2^-53. The sum of the magnitudes
of the products is at most twice the product of the lengths.
"""


@jit
def may_meet(corners: Array, origin: Array, direction: Array) -> Bools:
    """Tell which triangles (n,) may be met: those with no edges for certain on both sides.

    Parameters
    ----------
    corners : (n, 3, 3) float32
    origin, direction : (3,) float32
    """
    found = np.zeros(len(corners), np.bool_)
    # To a kernel, float() of a float32 is one.
    d0, d1, d2 = np.float64(direction[0]), np.float64(direction[1]), np.float64(direction[2])
    reach = ROUNDING * math.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
    c, v, far = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    for n in range(len(corners)):
        left, right = False, False
        for k in range(3):
            for axis in range(3):
                c[k, axis] = np.float64(corners[n, k, axis])
                v[k, axis] = c[k, axis] - np.float64(origin[axis])
            far[k] = math.sqrt(v[k, 0] * v[k, 0] + v[k, 1] * v[k, 1] + v[k, 2] * v[k, 2])
        for k in range(3):
            p, q = v[k - 1], v[k]
            # Of the corners themselves: their places from the origin may be rounded by more than they differ.
            a0, a1, a2 = c[k - 1, 0] - c[k, 0], c[k - 1, 1] - c[k, 1], c[k - 1, 2] - c[k, 2]
            b0, b1, b2 = p[0] + q[0], p[1] + q[1], p[2] + q[2]
            side = (a1 * b2 - a2 * b1) * d0 + (a2 * b0 - a0 * b2) * d1 + (a0 * b1 - a1 * b0) * d2
            slack = reach * math.sqrt(a0 * a0 + a1 * a1 + a2 * a2) * (far[k - 1] + far[k])
            left |= side < -slack
            right |= side > slack
        found[n] = not (left and right)
    return found
