"""Which triangles the line of a ray may meet: all but those that float64 proves it passes by."""

from __future__ import annotations

import math

import numpy as np

from hsr.base.arrays import Array, Bools
from hsr.base.jit import jit

ROUNDING = 2.0**-48
"""Bound of the error of an edge value in float64, relative to the lengths of its three factors.

Each of the six products has three factors, two of them sums: with the sums of the products fewer than
twenty roundings of 2^-53. The sum of the magnitudes of the products is at most twice the product of the
lengths.
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
    d0, d1, d2 = float(direction[0]), float(direction[1]), float(direction[2])
    reach = ROUNDING * math.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
    v = np.empty((3, 3))
    for n in range(len(corners)):
        left, right = False, False
        for k in range(3):
            for axis in range(3):
                v[k, axis] = float(corners[n, k, axis]) - float(origin[axis])
        for k in range(3):
            p, q = v[k - 1], v[k]
            a0, a1, a2 = p[0] - q[0], p[1] - q[1], p[2] - q[2]
            b0, b1, b2 = p[0] + q[0], p[1] + q[1], p[2] + q[2]
            side = (a1 * b2 - a2 * b1) * d0 + (a2 * b0 - a0 * b2) * d1 + (a0 * b1 - a1 * b0) * d2
            length = math.sqrt(a0 * a0 + a1 * a1 + a2 * a2) * math.sqrt(b0 * b0 + b1 * b1 + b2 * b2)
            left |= side < -reach * length
            right |= side > reach * length
        found[n] = not (left and right)
    return found
