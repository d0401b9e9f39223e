"""hit() of any round solid by its equation: a quadric between planes, such as the tapered cylinder.

After Hill and Kelley, "Computer Graphics Using OpenGL" (3rd edition, chapter 12): the point ``p + t d`` of a
ray is put into the equation of the surface, here p . Q . p = 0 with p = (x, y, z, 1), and a t^2 + 2 b t + c =
0 is left. A cone is met twice at most, on one nappe or on both; the planes leave one nappe.
"""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Floats
from hsr.base.jit import jit
from hsr.kernels.hits import MISS, NO_FACE, Span, intersection, polyhedron_span
from hsr.kernels.vectors import Vector


@jit
def quadric_span(o: Vector, d: Vector, rows: Floats, start: int, end: int, faces: int) -> Span:
    """Meet the convex solid that planes leave of p . Q . p <= 0.

    Parameters
    ----------
    o, d : 3 floats
    rows : (n, 4) float64 or float32
        From ``start`` on, the four of Q; up to ``end``, planes (n, m), ``n . p <= m`` inside.
    faces : int
        How many of Q's surface and the planes, in this order, are faces. Where another plane is met, as
        rounding may have it at the apex of a cone, the surface is.
    """
    # Start from the point of the line nearest to the origin: from far away b^2 - a c would cancel.
    s = -(o[0] * d[0] + o[1] * d[1] + o[2] * d[2]) / (d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
    p = (o[0] + s * d[0], o[1] + s * d[1], o[2] + s * d[2])
    zero, one = type(s)(0), type(s)(1)

    # Cut the line by the planes.
    planes = polyhedron_span(p, d, rows, start + 4, end)
    ends = Span(planes.t_in, _face(planes.face_in, faces), planes.t_out, _face(planes.face_out, faces))

    # Put the line into the equation.
    a = _product(d, zero, rows, start, d, zero)
    b = _product(p, one, rows, start, d, zero)
    c = _product(p, one, rows, start, p, one)
    r = b * b - a * c
    if r < 0.0 or (a == 0.0 and b == 0.0):
        return moved(ends, s) if c <= 0.0 else MISS

    # Solve it without cancellation: of q / a and c / q the line enters at that with the sign of -sqrt(r).
    q = -(b + np.copysign(np.sqrt(r), b))
    over_a = np.float64(q / a) if a != 0.0 else np.copysign(np.inf, q)
    over_q = np.float64(c / q) if q != 0.0 else over_a
    enter, leave = (over_a, over_q) if q < 0.0 else (over_q, over_a)
    if a > 0.0 or enter < leave:
        return moved(intersection(Span(enter, 0, leave, 0), ends), s)

    # The line leaves one nappe, to enter the other: of one of them the planes leave the apex at most.
    first = intersection(Span(-np.inf, NO_FACE, leave, 0), ends)
    second = intersection(Span(enter, 0, np.inf, NO_FACE), ends)
    return moved(first if first.t_out - first.t_in > second.t_out - second.t_in else second, s)


@jit
def moved(span: Span, s: float) -> Span:
    """Return a span whose t counts from a point s before."""
    return Span(span.t_in + s, span.face_in, span.t_out + s, span.face_out)


@jit
def _face(plane: int, faces: int) -> int:
    return plane + 1 if plane + 1 < faces else 0


@jit
def _product(u: Vector, u3: float, rows: Floats, start: int, v: Vector, v3: float) -> float:
    """Return (u, u3) . Q . (v, v3)."""
    total: float = u3 * v3 * rows[start + 3, 3]
    for i in range(3):
        total += u[i] * v3 * rows[start + i, 3] + u3 * v[i] * rows[start + 3, i]
        for j in range(3):
            total += u[i] * rows[start + i, j] * v[j]
    return total
