"""The exact integers of a view, and the frame in which its lines of sight are axes.

Every float of a view is an integer times a power of two, and projection is homogeneous: a point
times a positive factor is the same point. So all of it is done in integers, without any division.

A sample is named by two integers, twice its distance in pixels from the middle of the image:

    i = 2 column + 1 - width        j = height - 2 row - 1        (x_ndc = i / width, y_ndc = j / height)

The four world functions X = width x_clip, Y = height y_clip, W = w_clip and H are the coordinates of
the frame. H is 1 under perspective and the depth for a parallel view. On the line of sight of (i, j)

    (X, Y, W, H) = w (i, j, 1, zeta),        w > 0

so the one number zeta = H / W tells the points of a line of sight apart. It is 1 / w under
perspective, falling with distance, and grows with depth for a parallel view; on every plane it is
affine in (i, j), which is why renderers interpolate it (Blinn, "Hyperbolic interpolation", 1992).
A world function of rank one, a x + b y + c z + d, becomes a *form*: four integers (a, b, c, k) that
stand for a i + b j + c + k zeta, its value divided by the positive w.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from flint import fmpq_mat

from hsr.base.arrays import Array, Floats
from hsr.base.errors import ViewError
from hsr.problem.view import View

MANTISSA = 53
"""Bits of a float64 mantissa."""

ONE = np.array([0, 0, 0, 1], dtype=object)
"""The world function that is 1 everywhere."""


def integers(values: Floats) -> Array:
    """Multiply floats by one power of two, the least that makes all of them integers.

    Parameters
    ----------
    values : (...) float64, finite

    Returns
    -------
    (...) object
        Python integers in the exact proportions of the floats.
    """
    fraction, exponent = np.frexp(values)
    mantissa = (fraction * 2.0**MANTISSA).astype(np.int64)
    lowest_bit = np.maximum(mantissa & -mantissa, 1)
    zeros = np.log2(lowest_bit.astype(np.float64)).astype(np.int64)
    exponent = np.where(mantissa == 0, np.iinfo(np.int32).max, exponent + zeros)
    shift = np.where(mantissa == 0, 0, exponent - exponent.min())
    return np.asarray((mantissa >> zeros).astype(object) << shift.astype(object), dtype=object)


def points(places: Floats) -> Array:
    """Return integers (n, 4) in the proportions of points (n, 3) and 1: homogeneous coordinates."""
    return integers(np.column_stack([places, np.ones(len(places))]))


def inverse(matrix: Array) -> Array:
    """Return a positive multiple of the inverse of a 4 x 4 matrix of integers, in integers.

    Raises
    ------
    ViewError
        If the matrix is singular.
    """
    exact = fmpq_mat([[int(entry) for entry in row] for row in matrix])
    determinant = exact.det()
    if determinant == 0:
        raise ViewError("a transform or camera of this view is singular: it flattens what it maps")
    scaled = exact.inv() * abs(determinant)
    return np.array([[int(entry.p) for entry in row] for row in scaled.tolist()], dtype=object)


@dataclass(frozen=True, eq=False)
class Frame:
    """The frame of a view's lines of sight, in integers.

    Attributes
    ----------
    width, height : int
        Of the image.
    rows : (4, 4) object
        X, Y, W and H of a homogeneous world point, up to positive factors: one for X, Y and W, and
        one for H.
    nearer : int
        1 if of two points of a line of sight that of greater zeta is nearer (perspective), else -1.
    depth, unit : (4,) object
        Forms whose quotient is the depth.
    limits : (L, 4) object
        Forms that are not negative from near to far; L is 1 if far is infinite, else 2.
    """

    width: int
    height: int
    rows: Array
    nearer: int
    depth: Array
    unit: Array
    limits: Array

    def placed(self, world_from_object: Floats) -> Array:
        """Return the rows for points of an object."""
        return self.rows @ integers(world_from_object)

    def at(self, sample: Array) -> tuple[Array, Array]:
        """Return the coordinates i and j of samples (n,) int64, numbered row after row."""
        row, column = np.divmod(sample, self.width)
        return 2 * column + 1 - self.width, self.height - 1 - 2 * row

    def exactly_at(self, sample: Array) -> tuple[Array, Array]:
        """Return the same coordinates as Python integers, which do not overflow."""
        i, j = self.at(sample)
        return i.astype(object), j.astype(object)


def frame_of(view: View) -> Frame:
    """Build the frame of a view.

    Raises
    ------
    ViewError
        If the camera is singular, or its depth does not grow along every line of sight.
    """
    x_row, y_row, w_row = integers(view.clip_from_world[[0, 1, 3]])
    limits = [view.near] if view.far == float("inf") else [view.near, view.far]
    constants = [[0.0, 0.0, 0.0, value] for value in (*limits, 1.0)]
    depth_row, *planes, unit = integers(np.array([view.depth_row, *constants]))

    rows = np.array([x_row * view.width, y_row * view.height, w_row, ONE if view.perspective else depth_row])
    to_form = inverse(rows)
    beyond = [(depth_row - planes[0]) @ to_form, *((plane - depth_row) @ to_form for plane in planes[1:])]
    forms = depth_row @ to_form, unit @ to_form, np.array(beyond)
    frame = Frame(view.width, view.height, rows, 1 if view.perspective else -1, *forms)
    _check_direction(view, frame)
    return frame


def _check_direction(view: View, frame: Frame) -> None:
    """Refuse a camera whose depth does not grow with distance along the lines of sight.

    Under perspective depth = (g + k zeta) / (unit), g affine in (i, j): it falls with zeta if g is
    positive, on the whole image if at its corners. For a parallel view w must be positive.
    """
    a, b, c, _ = frame.depth
    corners = product((-view.width, view.width), (-view.height, view.height))
    forward = all(a * i + b * j + c > 0 for i, j in corners)
    if not (forward if view.perspective else view.clip_from_world[3, 3] > 0):
        raise ViewError("the depth of this camera does not grow along its lines of sight")
