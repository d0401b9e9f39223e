"""Views of rounded numbers, whose truth is what a method would show that rounds nothing more.

A stage of a pipeline takes numbers, computes others from them, and rounds. Its model is the exact
answer for a view made of the results: their coordinates are the vertices, and the camera is one of
small integers that reads them off without any rounding. Nothing in here is a tolerance.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache

import numpy as np

from hsr.algorithms import exact
from hsr.base.arrays import Array, Bools, Ints
from hsr.models.stages import Cause, Stage
from hsr.problem.map import VisibilityMap
from hsr.problem.view import Placement, View, WorldPolygons
from hsr.scene.shapes import Kind, Shape

THIRD = np.array([0.0, 0.0, 1.0, 0.0])
"""The row of a matrix that reads off the third coordinate."""
THIRD.flags.writeable = False

fractions = np.frompyfunc(lambda number: Fraction(float(number)), 1, 1)
"""Turns an array of floats into one of fractions, which are what they are."""


@lru_cache(maxsize=1)
def tessellated_truth(view: View) -> VisibilityMap:
    """Return the exact map of the tessellated view; kept for the next method."""
    return exact.render(view.tessellated(), exact.Options())


def tessellation(view: View, options: object, samples: Array) -> Ints:  # noqa: ARG001
    """Model the stage common to all methods that know no curved shapes."""
    return tessellated_truth(view).face.ravel()[samples]


TESSELLATED = Stage(Cause.TESSELLATION, tessellation)


def of_polygons(view: View, polygons: WorldPolygons, chosen: Bools) -> View:
    """Return a view of these polygons in place of its objects, their faces numbered as they are.

    Parameters
    ----------
    view : View
    polygons : WorldPolygons
        In the world of ``view``, counter-clockwise on the screen when front-facing.
    chosen : (P,) bool
        Which of them there are; those of fewer than three corners are left out anyway.

    Returns
    -------
    View
        For the oracle alone: one object for each way of culling.
    """
    return replace(view, placements=tuple(_objects(polygons, chosen)))


def _objects(polygons: WorldPolygons, chosen: Bools) -> Iterator[Placement]:
    whole = chosen & (np.diff(polygons.start) >= 3)
    for cull in np.unique(polygons.cull[whole]):
        part = polygons.part(np.flatnonzero(whole & (polygons.cull == cull)))
        shape = Shape(Kind.MESH, "mesh", part)
        yield Placement("", shape, np.eye(4), 0, int(cull), False, (0.0, 0.0, 0.0))


def seen_along_third(view: View, x: float = 1.0, y: float = 1.0, w: float = 1.0) -> View:
    """Give a view a camera that looks along the third coordinate of its world, which is the depth.

    Parameters
    ----------
    view : View
    x, y : float
        Clip coordinates x and y: these times those of the world.
    w : float
        Clip coordinate w: this times the depth under perspective, else this.

    Returns
    -------
    View
        Near, far and the kind of projection are those of ``view``.
    """
    z_row, w_row = [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, w]
    if view.perspective:
        z_row, w_row = [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, w, 0.0]
    matrix = np.array([[x, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], z_row, w_row])
    return replace(view, clip_from_world=matrix, depth_row=THIRD)


def seen_from_front(view: View, near: float, far: float, y_up: bool = False) -> View:
    """Give a view a parallel camera whose world is the screen: pixels right, pixels down, depth.

    The clip coordinates ``((2 x - W) H, (H - 2 y) W, z, W H)`` have integers for coefficients. With
    ``y_up`` pixels are counted from the bottom, and the second is ``(2 y - H) W``.
    """
    width, height, up = float(view.width), float(view.height), 1.0 if y_up else -1.0
    matrix = np.diag([2.0 * height, up * 2.0 * width, 1.0, width * height])
    matrix[:2, 3] = -width * height, -up * width * height
    return replace(view, clip_from_world=matrix, depth_row=THIRD, near=near, far=far)
