"""Where a ray meets a triangle, by the three tests of the literature, to be compared with each other.

Ray and corners are given in one frame, in float64 or float32; all arithmetic is in that type, and each
test returns the parameter t of the hit, ``o + t d``, before or behind the origin. Their borders are closed:
a ray exactly on an edge hits the triangles on both sides of it. They differ in what rounding does there.

===============  ================================  ==========================================
Test             A ray aimed at an edge                A ray aimed at a vertex
===============  ================================  ==========================================
Möller-Trumbore  may miss both triangles           may miss the whole fan
edge planes      hits one of them                  may miss the whole fan: planes that are
                                                   rounded one by one have no common line
Woop             hits one of them                  hits one of the fan
===============  ================================  ==========================================

:mod:`hsr.lab.watertight` counts.
"""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array
from hsr.base.jit import jit
from hsr.kernels.vectors import Vector, cross, dot, minus, point

MISS = np.inf

SCREEN, MOLLER_TRUMBORE, EDGE_PLANES, WOOP = range(4)
"""The tests by number; ``SCREEN`` is that of the projected triangle, in ``triangle_on_screen``."""


@jit
def triangle_at(test: int, o: Vector, d: Vector, a: Vector, b: Vector, c: Vector) -> tuple[float, float]:
    """Test a triangle by the test of that number.

    Returns
    -------
    t : float
        ``MISS`` for a miss.
    facing : float
        Positive where the corners run counter-clockwise as seen from where the ray comes: its front.
    """
    if test == MOLLER_TRUMBORE:
        return moller_trumbore(o, d, a, b, c)
    if test == EDGE_PLANES:
        return edge_planes(o, d, a, b, c)
    return woop(o, d, a, b, c)


@jit
def moller_trumbore(o: Vector, d: Vector, a: Vector, b: Vector, c: Vector) -> tuple[float, float]:
    """Solve ``o + t d = a + u (b - a) + v (c - a)`` by Cramer's rule; see :func:`triangle_at`.

    Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (Journal of Graphics Tools,
    1997). It hits where ``u >= 0``, ``v >= 0`` and ``u + v <= 1``.
    """
    ab, ac, ao = minus(b, a), minus(c, a), minus(o, a)
    p = cross(d, ac)
    facing = dot(ab, p)
    if facing == 0.0:
        return MISS, 0.0
    u = dot(ao, p) / facing
    q = cross(ao, ab)
    v = dot(d, q) / facing
    if u < 0.0 or v < 0.0 or u + v > 1.0:
        return MISS, 0.0
    return np.float64(dot(ac, q) / facing), np.float64(facing)


@jit
def edge_planes(o: Vector, d: Vector, a: Vector, b: Vector, c: Vector) -> tuple[float, float]:
    """Ask on which side of the planes through the origin and the edges a ray runs; see :func:`triangle_at`.

    With the corners relative to the origin, the plane through the edge from a to b has the normal a x b.
    Exchanging the ends of an edge changes its sign and nothing else. The volumes that the planes' normals
    span with the direction are the weights of the opposite corners (Davidovic, Engelhardt, Georgiev,
    Slusallek and Dachsbacher, "3D Rasterization: A Bridge between Rasterization and Ray Casting", Graphics
    Interface 2012).
    """
    a, b, c = minus(a, o), minus(b, o), minus(c, o)
    u, v, w = dot(cross(c, b), d), dot(cross(a, c), d), dot(cross(b, a), d)
    return _weighted(u, v, w, dot(a, cross(c, b)), u + v + w)


@jit
def woop(o: Vector, d: Vector, a: Vector, b: Vector, c: Vector) -> tuple[float, float]:
    """Shear the ray onto its dominant axis and test the triangle in the plane; see :func:`triangle_at`.

    Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013). A vertex is sheared once
    and the same for all its triangles, and the sign of a rounded ``bx cy - by cx`` is never the opposite of
    the true one, at worst 0; then float32 asks float64, whose products of float32 numbers are exact.
    """
    # Make the axis along which the ray runs fastest the third, without changing the handedness.
    z = dominant_axis(d)
    x, y = (z + 1) % 3, (z + 2) % 3
    if d[z] < 0.0:
        x, y = y, x

    # Shear the corners, relative to the origin, so that the ray is the third axis.
    a, b, c = minus(a, o), minus(b, o), minus(c, o)
    shear_x, shear_y = d[x] / d[z], d[y] / d[z]
    ax, ay = a[x] - shear_x * a[z], a[y] - shear_y * a[z]
    bx, by = b[x] - shear_x * b[z], b[y] - shear_y * b[z]
    cx, cy = c[x] - shear_x * c[z], c[y] - shear_y * c[z]

    # Find on which side of the edges the ray passes.
    u, v, w = cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax
    if u == 0.0 or v == 0.0 or w == 0.0:
        u = type(u)(np.float64(cx) * np.float64(by) - np.float64(cy) * np.float64(bx))
        v = type(v)(np.float64(ax) * np.float64(cy) - np.float64(ay) * np.float64(cx))
        w = type(w)(np.float64(bx) * np.float64(ay) - np.float64(by) * np.float64(ax))
    return _weighted(u, v, w, (u * a[z] + v * b[z] + w * c[z]) / d[z], u + v + w)


@jit
def misses(test: int, origins: Array, directions: Array, corners: Array) -> int:
    """Count the rays that hit none of some triangles in front of their origins.

    Parameters
    ----------
    test : int
    origins, directions : (n, 3) float64 or float32
    corners : (m, 3, 3), of the same type
    """
    missed = 0
    for k in range(len(origins)):
        o, d = point(origins[k]), point(directions[k])
        hit = False
        for i in range(len(corners)):
            a, b, c = point(corners[i, 0]), point(corners[i, 1]), point(corners[i, 2])
            if 0.0 <= triangle_at(test, o, d, a, b, c)[0] < MISS:
                hit = True
                break
        missed += not hit
    return missed


@jit
def dominant_axis(d: Vector) -> int:
    """Return the axis of the greatest coordinate in magnitude, the first of equal ones."""
    if abs(d[0]) >= abs(d[1]) and abs(d[0]) >= abs(d[2]):
        return 0
    return 1 if abs(d[1]) >= abs(d[2]) else 2


@jit
def _weighted(u: float, v: float, w: float, depth: float, total: float) -> tuple[float, float]:
    """Return the hit of a ray that weighs the corners by u, v and w: none if their signs differ."""
    if (u < 0.0 or v < 0.0 or w < 0.0) and (u > 0.0 or v > 0.0 or w > 0.0):
        return MISS, 0.0
    if total == 0.0:
        return MISS, 0.0
    return np.float64(depth / total), np.float64(total)
