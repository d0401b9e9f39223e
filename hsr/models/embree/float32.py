"""Embree's test of one ray with triangles, in its float32 arithmetic.

The test is that of Embree's robust mode, "modified Pluecker", of version 4 (Wald, Woop, Benthin,
Johnson & Ernst, "Embree: a kernel framework for efficient CPU ray tracing", ACM Transactions on
Graphics, 2014), on processors that multiply and add in one rounding. With the corners relative to the
ray's origin, an edge from p to q is on one side of the direction d by the sign of

    ((p - q) x (p + q)) . d

whose two values for an edge that two triangles share are opposite to the last bit: no ray slips
between them (Woop, Benthin & Wald, "Watertight Ray/Triangle Intersection", JCGT 2013). A ray on an edge
hits both. Embree refines an approximate reciprocal where a quotient here is rounded once, so that a
distance may differ by its last bit.
"""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array
from hsr.base.jit import jit
from hsr.models.llvmpipe.float32 import multiply_add

Vector = tuple[np.float32, np.float32, np.float32]

ULP = np.float32(2.0**-23)
"""How far an edge value may be on the wrong side, relative to the sum of the three."""

MISS = np.float32(np.inf)


@jit
def distances(origin: Array, direction: Array, corners: Array, reach: np.float32) -> Array:
    """Return the distance (n,) float32 at which a ray hits each triangle, ``MISS`` where it does not.

    Parameters
    ----------
    origin, direction : (3,) float32
    corners : (n, 3, 3) float32
    reach : float32
        Largest distance that counts, in units of the direction; the least is 0. Both are closed.
    """
    found = np.full(len(corners), MISS)
    for i in range(len(corners)):
        t = distance(corners[i], origin, direction)
        if np.float32(0.0) <= t <= reach:
            found[i] = t
    return found


@jit
def distance(corner: Array, origin: Array, d: Array) -> np.float32:
    """Return the distance along d of a triangle; ``MISS`` if missed."""
    v0, v1, v2 = minus(corner[0], origin), minus(corner[1], origin), minus(corner[2], origin)
    e0, e1, e2 = minus(v2, v0), minus(v0, v1), minus(v1, v2)

    # Find on which sides of the ray the edges pass.
    u = dot(cross(e0, plus(v2, v0)), d)
    v = dot(cross(e1, plus(v0, v1)), d)
    w = dot(cross(e2, plus(v1, v2)), d)
    slack = ULP * abs(u + v + w)
    if min(u, v, w) < -slack and max(u, v, w) > slack:
        return MISS

    # Meet the plane.
    normal = stable_normal(e0, e1, e2)
    denominator = np.float32(2.0) * dot(normal, d)
    if denominator == 0.0:
        return MISS
    return np.float32(np.float32(1.0) / denominator * (np.float32(2.0) * dot(v0, normal)))


@jit
def stable_normal(a: Vector, b: Vector, c: Vector) -> Vector:
    """Return the normal of a triangle by its edges.

    In each coordinate, that of a x b or b x c from which the smaller product is subtracted.
    """
    ab, bc = cross(a, b), cross(b, c)
    return (
        ab[0] if abs(a[2] * b[1]) < abs(b[2] * c[1]) else bc[0],
        ab[1] if abs(a[0] * b[2]) < abs(b[0] * c[2]) else bc[1],
        ab[2] if abs(a[1] * b[0]) < abs(b[1] * c[0]) else bc[2],
    )


@jit
def minus(a: Vector | Array, b: Vector | Array) -> Vector:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@jit
def plus(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@jit
def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b, the first product of each coordinate unrounded."""
    return (
        multiply_add(a[1], b[2], -(a[2] * b[1])),
        multiply_add(a[2], b[0], -(a[0] * b[2])),
        multiply_add(a[0], b[1], -(a[1] * b[0])),
    )


@jit
def dot(a: Vector, b: Vector | Array) -> np.float32:
    """Return a . b, summed from the last coordinate to the first, only the first product rounded."""
    return multiply_add(a[0], b[0], multiply_add(a[1], b[1], a[2] * b[2]))
