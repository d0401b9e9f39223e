"""A tube along a torus knot."""

from __future__ import annotations

import numpy as np

from hsr.scene.shapes.lattice import halves
from hsr.scene.shapes.polygons import Polygons


def polygons(p: int, q: int, segments: int, sides: int, thickness: float) -> Polygons:
    """Lay a tube along the (p, q) torus knot.

    The knot winds p times about the axis and q times about the core of the torus of radii 2 and 1
    (C. Adams, *The Knot Book*, 1994, section 5.1)::

        c(t) = ((2 + cos q t) cos p t, (2 + cos q t) sin p t, sin q t),    0 <= t < 2 pi

    A cross section is spanned by the normal N of the torus, to which the tangent T of the knot is
    perpendicular everywhere, and by the binormal T x N; this frame comes back to itself.

    Parameters
    ----------
    p, q : int
        Without common factor.
    segments, sides : int
        Cross sections along the knot, corners of each.
    thickness : float
        Radius of the tube.

    Returns
    -------
    Polygons
        ``2 segments sides`` triangles, closed. The axis of the torus is the z axis.
    """
    t = 2.0 * np.pi * np.arange(segments) / segments
    cp, sp, cq, sq = np.cos(p * t), np.sin(p * t), np.cos(q * t), np.sin(q * t)
    centre = np.stack([(2.0 + cq) * cp, (2.0 + cq) * sp, sq], axis=1)
    normal = np.stack([cq * cp, cq * sp, sq], axis=1)
    turn = np.stack([-(2.0 + cq) * sp, (2.0 + cq) * cp, 0.0 * t], axis=1)
    wind = np.stack([-sq * cp, -sq * sp, cq], axis=1)
    tangent = p * turn + q * wind
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    binormal = np.cross(tangent, normal)

    angle = 2.0 * np.pi * np.arange(sides)[:, None] / sides
    ring = np.cos(angle) * normal[:, None] + np.sin(angle) * binormal[:, None]
    vertices = (centre[:, None] + thickness * ring).reshape(-1, 3)
    index = np.arange(segments * sides, dtype=np.int32).reshape(segments, sides)
    return Polygons.of_rows(vertices, halves(np.pad(index, (0, 1), mode="wrap")))
