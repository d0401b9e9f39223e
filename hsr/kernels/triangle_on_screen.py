"""The test of a triangle on the screen: does it cover a sample, and how near is it there.

It is that of :mod:`hsr.kernels.rays` for the triangles of meshes; those in space, where the ray is, are in
:mod:`hsr.kernels.triangle_tests`. The edges are those of the triangle's homogeneous corners: a vertex behind
the eye needs no clipping.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hsr.base.arrays import Floats
from hsr.base.jit import jit
from hsr.kernels.culling import CULL_BACK, CULL_FRONT
from hsr.kernels.projection import nearness_of
from hsr.kernels.vectors import Vector

SMALLEST = 5e-324
"""The least number above 0: ``e >= SMALLEST`` is ``e > 0``."""

Corner = tuple[float, float, float, float]
"""A projected point: column and row in pixels from the image centre times its weight, depth, nearness."""


class Facet(NamedTuple):
    """A triangle made ready for its coverage test.

    Attributes
    ----------
    turn : float
        Its orientation on the screen, 1 or -1; 0 if it covers nothing.
    x, y, h : 3 floats
        Columns, rows and weights of its corners.
    least : 3 floats
        What the edge function opposite each corner must at least be at a covered sample.
    plane : 3 floats
        Nearness at (x, y) is ``plane . (x, y, 1)``.
    low, high : float
        The least and greatest nearness of its corners.
    """

    turn: float
    x: Vector
    y: Vector
    h: Vector
    least: Vector
    plane: Vector
    low: float
    high: float


ZERO = (0.0, 0.0, 0.0)
NOTHING = Facet(0.0, ZERO, ZERO, ZERO, ZERO, ZERO, 0.0, 0.0)


@jit
def corner_of(matrix: Floats, p: Vector, perspective: bool) -> Corner:
    """Project a point by the rows column, row and depth of a (3, 4) matrix.

    Returns
    -------
    X, Y, depth, nearness : float
        Under perspective the point appears X / depth pixels right of and Y / depth below the image
        centre, in a parallel view X and Y.
    """
    x, y, z = p
    depth = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z + matrix[2, 3]
    return (
        matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z + matrix[0, 3],
        matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z + matrix[1, 3],
        depth,
        nearness_of(depth, perspective),
    )


@jit
def facet_of(a: Corner, b: Corner, c: Corner, perspective: bool, cull: int, mirrored: bool) -> Facet:
    """Prepare a triangle from its projected corners.

    Corners at or behind the eye are as good as any, for the edge functions are those of homogeneous
    corners (Olano and Greer, "Triangle Scan Conversion Using 2D Homogeneous Coordinates", 1997). A
    triangle seen edge-on covers nothing.
    """
    # Take the plane n . p = m through the corners (column, row, depth).
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    m = nx * a[0] + ny * a[1] + nz * a[2]

    # Decide the facing by the sign of the projected area; rows run down, so a front is negative.
    area = m if perspective else nz
    front = (area < 0.0) != mirrored
    if area == 0.0 or (cull == CULL_BACK and not front) or (cull == CULL_FRONT and front):
        return NOTHING
    turn = 1.0 if area > 0.0 else -1.0

    # Give every edge its owner at a sample that lies exactly on it.
    h = (a[2], b[2], c[2]) if perspective else (1.0, 1.0, 1.0)
    least = (
        least_inside(b, c, h[1], h[2], turn),
        least_inside(c, a, h[2], h[0], turn),
        least_inside(a, b, h[0], h[1], turn),
    )

    # Solve the plane for the nearness along the ray: its end is (x, y, 1) t, or (x, y, t).
    plane = (nx / area, ny / area, (nz if perspective else -m) / area)
    x, y = (a[0], b[0], c[0]), (a[1], b[1], c[1])
    return Facet(turn, x, y, h, least, plane, min(a[3], b[3], c[3]), max(a[3], b[3], c[3]))


@jit
def least_inside(p: Corner, q: Corner, p_weight: float, q_weight: float, turn: float) -> float:
    """Return the least value of the edge function of p q at a covered sample.

    A sample exactly on an edge belongs to the face it enters when moved right and, less than that,
    down: the top-left rule. The edge function grows by ``across`` to the right and ``down`` below.
    Opposite edges have opposite growth, without rounding, so one of two neighbours is the owner.
    """
    across = turn * (p[1] * q_weight - p_weight * q[1])
    down = turn * (p_weight * q[0] - p[0] * q_weight)
    return 0.0 if across > 0.0 or (across == 0.0 and down > 0.0) else SMALLEST


@jit
def covered_nearness(facet: Facet, x: float, y: float, closest: float) -> float:
    """Return the nearness of a facet at the sample (x, y), ``-inf`` where it does not count.

    It counts where the sample is inside all three edges and the nearness at most ``closest``. The
    edge functions take the corners relative to the sample (Woop, Benthin and Wald, "Watertight
    Ray/Triangle Intersection", JCGT 2013). Exchanging the ends of an edge changes its sign and
    nothing else, so that no sample falls between two triangles, or into both.
    """
    turn, h = facet.turn, facet.h
    ax, bx, cx = facet.x[0] - x * h[0], facet.x[1] - x * h[1], facet.x[2] - x * h[2]
    ay, by, cy = (
        turn * (facet.y[0] - y * h[0]),
        turn * (facet.y[1] - y * h[1]),
        turn * (facet.y[2] - y * h[2]),
    )
    inside = (
        (bx * cy - by * cx >= facet.least[0])
        & (cx * ay - cy * ax >= facet.least[1])
        & (ax * by - ay * bx >= facet.least[2])
    )
    # The plane of a facet nearly edge-on is steep: keep its rounding between the corners.
    nearness = facet.plane[0] * x + (facet.plane[1] * y + facet.plane[2])
    nearness = nearness if nearness > facet.low else facet.low
    nearness = nearness if nearness < facet.high else facet.high
    return nearness if inside & (nearness <= closest) else -np.inf
