"""Which side of a convex polygon faces the eye: three forms of one test.

All work on clip space, the camera's space scaled to the view (:mod:`hsr.kernels.projection`), and on
polygons whose corners run counter-clockwise when seen from the front. Each returns one number a
polygon: positive for a front face, negative for a back face, 0 for a face seen edge-on. In exact
arithmetic the three signs agree; these are plain float64, so the sign of a face that is edge-on to
within rounding is not certain.

Normals are those of Newell's method (Sutherland, Sproull & Schumacker, *A Characterization of Ten
Hidden-Surface Algorithms*, Computing Surveys 6, 1974), which sums over all corners. Summed as the
triangles of the fan about the first corner it is the same sum, with numbers no larger than the polygon.
"""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.base.jit import jit, parallel_jit, prange

CULL_BACK, CULL_FRONT, CULL_BOTH = 1, 2, 3
"""What is left out of a picture, if not nothing, 0: a bit for back faces, and one for front faces."""


@parallel_jit
def facing_by_normal(clip: Floats, corner: Ints, start: Ints, perspective: bool) -> Floats:
    """Test ``V . N >= 0`` for back faces, V running from the eye to the face.

    In the right-handed camera space (x, y, -d) a face lies in the plane ``A x + B y + C z + D = 0``
    with N = (A, B, C) outward. Under perspective the eye is the origin, so that for a point V of
    the face ``V . N = -D``: back faces have ``D <= 0``. For a parallel view V is (0, 0, -1) and
    ``V . N = -C``: back faces have ``C <= 0`` (Hearn & Baker, *Computer Graphics*, section on
    back-face detection).

    Parameters
    ----------
    clip : (V, 3) float64, clip space
    corner, start : (K,), (P + 1,) int32
        The polygons, before any clipping: the test holds behind the eye too.
    perspective : bool

    Returns
    -------
    (P,) float64
        ``-V . N``: D under perspective, else C.
    """
    facing = np.empty(len(start) - 1)
    for i in prange(len(facing)):
        a, b, c = newell(clip, corner[start[i] : start[i + 1]])
        p = clip[corner[start[i]]]
        facing[i] = -(a * p[0] + b * p[1] - c * p[2]) if perspective else c
    return facing


@jit
def newell(points: Array, corner: Ints) -> tuple[float, float, float]:
    """Return the normal (A, B, C) of a polygon in the space (x, y, -d), as long as twice its area.

    Parameters
    ----------
    points : (V, 3) float64 or float32
        (x, y, d), d growing away from the eye. The type is that of the arithmetic.
    corner : (n,) int32
    """
    a = b = c = points.dtype.type(0.0)
    first = points[corner[0]]
    for k in range(1, len(corner) - 1):
        p, q = points[corner[k]], points[corner[k + 1]]
        px, py, pz = p[0] - first[0], p[1] - first[1], first[2] - p[2]
        qx, qy, qz = q[0] - first[0], q[1] - first[1], first[2] - q[2]
        a += py * qz - pz * qy
        b += pz * qx - px * qz
        c += px * qy - py * qx
    return a, b, c


@parallel_jit
def facing_in_ndc(clip: Floats, corner: Ints, start: Ints, perspective: bool) -> Floats:
    """Test ``C <= 0`` for back faces, after the divide, in normalised device coordinates with y up.

    There all lines of sight are parallel, so that C alone decides. C is twice the signed area of the
    projection, which does not ask whether the frame is left-handed.

    Parameters
    ----------
    clip : (V, 3) float64, clip space
    corner, start : (K,), (P + 1,) int32
        The polygons, clipped to near; one without corners has no image, and 0 is returned.
    perspective : bool

    Returns
    -------
    (P,) float64
        C.
    """
    facing = np.empty(len(start) - 1)
    for i in prange(len(facing)):
        twice_area = 0.0
        for k in range(start[i] + 1, start[i + 1] - 1):
            x, y = _divided(clip[corner[start[i]]], perspective)
            px, py = _divided(clip[corner[k]], perspective)
            qx, qy = _divided(clip[corner[k + 1]], perspective)
            twice_area += (px - x) * (qy - y) - (py - y) * (qx - x)
        facing[i] = twice_area
    return facing


@jit
def _divided(point: Floats, perspective: bool) -> tuple[float, float]:
    w = point[2] if perspective else 1.0
    return point[0] / w, point[1] / w


@parallel_jit
def facing_by_determinant(clip: Floats, corner: Ints, start: Ints, perspective: bool) -> Floats:
    """Test ``det [a b c] <= 0`` for back faces, a, b and c being corners (x, y, w).

    The volume spanned by the eye and the face: no divide, and no matter what lies behind the eye
    (Olano & Greer, *Triangle Scan Conversion using 2D Homogeneous Coordinates*, 1997).

    Parameters
    ----------
    clip : (V, 3) float64, clip space
    corner, start : (K,), (P + 1,) int32
        The polygons, before any clipping.
    perspective : bool

    Returns
    -------
    (P,) float64
        The sum of the determinants of the fan's triangles.
    """
    facing = np.empty(len(start) - 1)
    for i in prange(len(facing)):
        total = 0.0
        a = clip[corner[start[i]]]
        for k in range(start[i] + 1, start[i + 1] - 1):
            b, c = clip[corner[k]], clip[corner[k + 1]]
            aw, bw, cw = (a[2], b[2], c[2]) if perspective else (1.0, 1.0, 1.0)
            total += (
                aw * (b[0] * c[1] - b[1] * c[0])
                - bw * (a[0] * c[1] - a[1] * c[0])
                + cw * (a[0] * b[1] - a[1] * b[0])
            )
        facing[i] = total
    return facing
