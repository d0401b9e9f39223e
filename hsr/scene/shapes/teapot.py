"""The Utah teapot: 32 bicubic patches, cut into triangles."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from hsr.base.arrays import Floats
from hsr.scene.shapes.lattice import halves, proper
from hsr.scene.shapes.polygons import Polygons

Curve = tuple[tuple[tuple[float, ...], ...], ...]

# Curves of cubic Bezier pieces, a row each; a piece ends with the first point of the one after it.
# Those that are turned about the y axis: radius, length of the tangent handles, height.
BODY = (
    ((1.4, 0.784, 2.4), (1.3375, 0.749, 2.53125), (1.4375, 0.805, 2.53125)),  # rim
    ((1.5, 0.84, 2.4), (1.75, 0.98, 1.875), (2.0, 1.12, 1.35)),  # upper half
    ((2.0, 1.12, 0.9), (2.0, 1.12, 0.45), (1.5, 0.84, 0.225)),  # lower half
    ((1.5, 0.84, 0.15), (1.5, 0.84, 0.075), (1.425, 0.798, 0.0)),  # bottom
    ((0.0, 0.0, 0.0),),
)
LID = (
    ((0.0, 0.0, 3.15), (0.8, 0.45, 3.15), (0.0, 0.0, 2.85)),  # knob
    ((0.2, 0.112, 2.7), (0.4, 0.224, 2.55), (1.3, 0.728, 2.55)),  # brim
    ((1.3, 0.728, 2.4),),
)
# Pairs of curves in the plane z = 0 that bound a bent tube: x and y of one, x and y of the other,
# and half the width of the tube.
HANDLE = (
    ((-1.6, 2.025, -1.5, 2.25, 0.3), (-2.3, 2.025, -2.5, 2.25, 0.3), (-2.7, 2.025, -3.0, 2.25, 0.3)),
    ((-2.7, 1.8, -3.0, 1.8, 0.3), (-2.7, 1.575, -3.0, 1.35, 0.3), (-2.5, 1.125, -2.65, 0.9375, 0.3)),
    ((-2.0, 0.9, -1.9, 0.6, 0.3),),
)
SPOUT = (
    ((1.7, 1.425, 1.7, 0.6, 0.66), (2.6, 1.425, 3.1, 0.825, 0.66), (2.3, 2.1, 2.4, 2.025, 0.25)),
    ((2.7, 2.4, 3.3, 2.4, 0.25), (2.8, 2.475, 3.525, 2.49375, 0.25), (2.9, 2.475, 3.45, 2.5125, 0.15)),
    ((2.8, 2.4, 3.2, 2.4, 0.15),),
)


def polygons(detail: int) -> Polygons:
    """Cut the 32 patches of the Utah teapot into ``detail`` x ``detail`` quads, each of two triangles.

    The control points are those of M. Newell (1975), as listed by F. Crow, "The Origins of the
    Teapot", IEEE Computer Graphics and Applications 7(1), 1987: 306 points, of which 12 repeat others
    and 4 belong to no patch. The 290 that remain follow from four curves by turning and mirroring.

    Parameters
    ----------
    detail : int
        At least 2: in one step the handle would be flat.

    Returns
    -------
    Polygons
        ``64 detail**2 - 8 detail`` triangles; those that would have no area, at the middle of lid
        and bottom, are left out. The pot stands on y = 0 about the y axis, 3.15 high, the spout
        toward +x. Its surface is open: at the end of the spout and between rim and lid one can
        look inside.
    """
    t = np.linspace(0.0, 1.0, detail + 1)
    columns = _on_cubics(patches().transpose(1, 2, 0, 3), t)
    points = _on_cubics(columns.swapaxes(0, 1), t).transpose(2, 1, 0, 3)
    # Neighbours agree on their common edge to the last bit. A zero is added, for -0.0 is not 0.0.
    vertices, index = np.unique(points.reshape(-1, 3) + 0.0, axis=0, return_inverse=True)
    return Polygons.of_rows(vertices, proper(halves(index.reshape(points.shape[:3]))))


def patches() -> Floats:
    """Return the control points of the teapot's bicubic patches.

    Returns
    -------
    (32, 4, 4, 3) float64
        Patch, row, column; the patches of the body, of the lid, of the handle, of the spout. Rows
        upward and columns to the right are counter-clockwise as seen from outside.
    """
    return np.concatenate([_turned(BODY), _turned(LID), _bent(HANDLE), _bent(SPOUT)])


def _on_cubics(control: Floats, t: Floats) -> Floats:
    """Find the points (n, ...) at the parameters t (n,) of the cubics with control points (4, ...).

    De Casteljau's algorithm: the segments between neighbouring points are divided in the ratio
    t : 1 - t until one point is left.
    """
    t = t.reshape(-1, *[1] * (control.ndim - 1))
    points: Floats = control[:, None]
    while len(points) > 1:
        points = _between(points[:-1], points[1:], t)
    first: Floats = points[0]
    return first


def _between(a: Floats, b: Floats, t: Floats) -> Floats:
    """Divide segments, counting from the nearer end: exact at both ends, and where they coincide."""
    return np.where(t < 0.5, a + t * (b - a), b - (1.0 - t) * (b - a))


def _pieces(curve: Curve) -> Floats:
    """Give each of n pieces its last point, and return what the points have (k, n, 4)."""
    pieces = [[*piece, after[0]] for piece, after in pairwise(curve)]
    return np.moveaxis(np.array(pieces), 2, 0)


def _turned(curve: Curve) -> Floats:
    """Turn a curve about the y axis: four patches, a quarter of a turn each, for every piece."""
    radius, tangent, height = _pieces(curve)
    none = np.zeros_like(radius)
    ahead = np.stack([radius, radius, tangent, none], axis=2)
    aside = ahead[:, :, ::-1]
    up = np.broadcast_to(height[:, :, None], ahead.shape)
    quarters = [(ahead, aside), (-aside, ahead), (-ahead, -aside), (aside, -ahead)]
    return np.concatenate([np.stack([x, up, z], axis=3) for x, z in quarters])


def _bent(curves: Curve) -> Floats:
    """Span a tube between two curves: two patches, mirror images in z = 0, for every piece."""
    x0, y0, x1, y1, width = _pieces(curves)
    x, y = (np.stack([one, one, other, other], axis=2) for one, other in ((x0, x1), (y0, y1)))
    z = np.stack([0.0 * width, width, width, 0.0 * width], axis=2)
    front = np.stack([x, y, z], axis=3)
    back = np.stack([x, y, -z], axis=3)[:, :, ::-1]
    return np.concatenate([front, back])
