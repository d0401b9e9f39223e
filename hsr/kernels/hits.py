"""hit(): where a ray meets the generic square, convex polyhedron, sphere and cylinder.

After Hill and Kelley, "Computer Graphics Using OpenGL" (3rd edition, chapter 12): an object is a generic
shape moved by a transform, and a ray is carried back by the inverse transform to meet the shape where that
is simple. It is not rescaled there, so that the t of a point ``o + t d`` is the same in both spaces.

A convex solid meets a line in one closed interval of t. The face through which the line enters is
seen from outside, its front; the face through which it leaves is seen from inside, its back. A line
that only touches the solid enters and leaves at the same t. Where it enters (or leaves) through
several faces at once, as in an edge, the lowest of them owns the point. An origin on the surface is a hit
at t = 0, one inside has its entry behind it, at t < 0.

Rays are given in float64 or float32; the arithmetic is in that type.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hsr.base.arrays import Floats
from hsr.base.jit import jit
from hsr.kernels.culling import CULL_BACK, CULL_FRONT
from hsr.kernels.vectors import Vector

SIDE, BASE, CAP = 0, 1, 2
"""The faces of a cylinder."""

NO_FACE = -1


class Span(NamedTuple):
    """The interval of a line within a solid; ``t_in > t_out`` if it misses.

    Attributes
    ----------
    t_in, t_out : float
    face_in, face_out : int
        The faces through which the line enters and leaves.
    """

    t_in: float
    face_in: int
    t_out: float
    face_out: int


MISS = Span(np.inf, NO_FACE, -np.inf, NO_FACE)
WHOLE = Span(-np.inf, NO_FACE, np.inf, NO_FACE)


@jit
def first_hit(span: Span, near: float, far: float, cull: int) -> tuple[float, int]:
    """Return the nearest hit of a solid that counts.

    A hit counts if ``near <= t <= far`` and its side is not culled.

    Returns
    -------
    t : float
    face : int
        ``NO_FACE`` if no hit counts.
    """
    if span.t_in > span.t_out:
        return np.inf, NO_FACE
    if near <= span.t_in <= far and cull != CULL_FRONT:
        return span.t_in, span.face_in
    if near <= span.t_out <= far and cull != CULL_BACK:
        return span.t_out, span.face_out
    return np.inf, NO_FACE


@jit
def intersection(one: Span, two: Span) -> Span:
    """Return the span within both; of equal entries (exits) the lower face counts."""
    t_in, face_in, t_out, face_out = one
    if two.t_in > t_in or (two.t_in == t_in and two.face_in < face_in):
        t_in, face_in = two.t_in, two.face_in
    if two.t_out < t_out or (two.t_out == t_out and two.face_out < face_out):
        t_out, face_out = two.t_out, two.face_out
    return Span(t_in, face_in, t_out, face_out)


@jit
def square_hit(o: Vector, d: Vector, near: float, far: float, cull: int) -> tuple[float, int]:
    """Hit the square ``z = 0``, ``|x|, |y| <= 1``, its border included; its front is toward +z.

    A line within the plane sees the square edge-on: it covers nothing.
    """
    if d[2] == 0.0 or (cull == CULL_BACK and d[2] > 0.0) or (cull == CULL_FRONT and d[2] < 0.0):
        return np.inf, NO_FACE
    t = -o[2] / d[2]
    inside = abs(o[0] + t * d[0]) <= 1.0 and abs(o[1] + t * d[1]) <= 1.0
    return (np.float64(t), 0) if inside and near <= t <= far else (np.inf, NO_FACE)


@jit
def polyhedron_span(o: Vector, d: Vector, planes: Floats, start: int, end: int) -> Span:
    """Clip a line by the half-spaces of a convex polyhedron (Cyrus and Beck 1978).

    Parameters
    ----------
    o, d : 3 floats
    planes : (n, 4) float64
        Rows (n, m) of planes ``n . p = m`` with n outward.
    start, end : int
        The rows that are the faces of this polyhedron. It is closed: a line within a plane is inside
        its half-space.
    """
    t_in, face_in, t_out, face_out = WHOLE
    for k in range(start, end):
        nx, ny, nz, m = planes[k, 0], planes[k, 1], planes[k, 2], planes[k, 3]
        along = nx * d[0] + ny * d[1] + nz * d[2]
        inside = m - (nx * o[0] + ny * o[1] + nz * o[2])
        if along == 0.0:
            if inside < 0.0:
                return MISS
        elif along < 0.0:
            t = np.float64(inside / along)
            if t > t_in:
                t_in, face_in = t, k - start
        else:
            t = np.float64(inside / along)
            if t < t_out:
                t_out, face_out = t, k - start
    return Span(t_in, face_in, t_out, face_out)


@jit
def sphere_span(o: Vector, d: Vector) -> Span:
    """Meet the sphere of radius 1 about the origin; a tangent touches it."""
    a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    b = o[0] * d[0] + o[1] * d[1] + o[2] * d[2]
    s = b / a
    # The point of the line nearest to the centre, and how far out it and the origin lie.
    v = np.sqrt((o[0] - s * d[0]) ** 2 + (o[1] - s * d[1]) ** 2 + (o[2] - s * d[2]) ** 2)
    r = np.sqrt(o[0] * o[0] + o[1] * o[1] + o[2] * o[2])
    return _roots(a, b, v, r)


@jit
def cylinder_span(o: Vector, d: Vector) -> Span:
    """Meet the cylinder of radius 1 about the z axis, ``0 <= z <= 1``.

    The side is an infinite cylinder, base and cap are the planes that cut it off. A line parallel
    to the axis meets base and cap if it runs within the side, the side included.
    """
    return intersection(_side_span(o, d), _slab_span(o[2], d[2]))


@jit
def _side_span(o: Vector, d: Vector) -> Span:
    a = d[0] * d[0] + d[1] * d[1]
    r = np.sqrt(o[0] * o[0] + o[1] * o[1])
    if a == 0.0:
        return WHOLE if r <= 1.0 else MISS
    b = o[0] * d[0] + o[1] * d[1]
    s = b / a
    v = np.sqrt((o[0] - s * d[0]) ** 2 + (o[1] - s * d[1]) ** 2)
    return _roots(a, b, v, r)


@jit
def _slab_span(z: float, dz: float) -> Span:
    """Meet ``0 <= z <= 1`` by its faces base and cap."""
    if dz == 0.0:
        return WHOLE if 0.0 <= z <= 1.0 else MISS
    one = type(z)(1)
    at_base, at_cap = np.float64(-z / dz), np.float64((one - z) / dz)
    if dz > 0.0:
        return Span(at_base, BASE, at_cap, CAP)
    return Span(at_cap, CAP, at_base, BASE)


@jit
def _roots(a: float, b: float, v: float, r: float) -> Span:
    """Solve ``a t^2 + 2 b t + c = 0`` for the unit circle or sphere without cancellation.

    Parameters
    ----------
    a, b : float
        Of the equation, a > 0.
    v, r : float
        Distances from the centre of the nearest point of the line, and of its origin. They give
        ``c = r^2 - 1`` and the discriminant ``a (1 - v^2)`` as products of small differences
        (Haines, Guenther and Akenine-Moeller, "Precision Improvements for Ray/Sphere Intersection",
        Ray Tracing Gems, 2019).
    """
    if v > 1.0:
        return MISS
    one = type(r)(1)
    c = (r + one) * (r - one)
    q = -(b + np.copysign(np.sqrt(a * (one + v) * (one - v)), b))
    if q == 0.0:
        return Span(0.0, 0, 0.0, 0)
    t0, t1 = np.float64(q / a), np.float64(c / q)
    return Span(min(t0, t1), 0, max(t0, t1), 0)
