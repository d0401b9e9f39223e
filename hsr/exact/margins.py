"""How close a decision was: distances to edges in pixels, and the gap in depth behind the owner."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np

from hsr.base.errors import ViewError
from hsr.exact.decide import Piece
from hsr.exact.depths import depth_quotient
from hsr.exact.germs import Polynomial, beside
from hsr.exact.problem import Problem, problem_of
from hsr.problem.view import View

REACH = 1.0
"""Pixels by which a sample may miss a face that is still told."""


@dataclass(frozen=True)
class FaceMargin:
    """How a part of a face, a triangle of its fan or half of a sphere, lies about a sample.

    Attributes
    ----------
    face : int
    edges : tuple of float
        Distances in pixels to what bounds it on the image, positive inside: the three edges of a
        triangle, the outline of a curved piece (there to first order), near and far where they cut.
    depth : float or None
        Depth at the sample, None where the part is not.
    """

    face: int
    edges: tuple[float, ...]
    depth: float | None


@dataclass(frozen=True)
class Margins:
    """How close the decision at a sample was.

    Attributes
    ----------
    faces : tuple of FaceMargin
        Parts of faces at the sample, nearest first; then those that miss it by less than a pixel.
    gap : float
        Difference of the depths of the two nearest, infinite if there are not two.
    """

    faces: tuple[FaceMargin, ...]
    gap: float


@lru_cache(maxsize=1)
def _problem(view: View) -> Problem:
    """Set up a view; kept for the next sample of it."""
    return problem_of(view)


def margins(view: View, row: int, column: int) -> Margins:
    """Measure how close the decision at a sample was.

    Parameters
    ----------
    view : View
    row, column : int
        The sample; row 0 is the top row.

    Returns
    -------
    Margins

    Raises
    ------
    ViewError
        If there is no such sample, or the view has no exact answer (see :func:`truth`).
    """
    if not (0 <= row < view.height and 0 <= column < view.width):
        raise ViewError(f"no sample at row {row}, column {column}: the image is {view.width}x{view.height}")
    problem = _problem(view)
    i, j = int(problem.i[column]), int(problem.j[row])
    found: list[tuple[Fraction, FaceMargin]] = []
    missed: list[FaceMargin] = []
    for piece in _near(problem, row, column):
        edges = tuple(pixels(polynomial, i, j) for polynomial in piece.extent)
        if piece.depth_at(beside(i, j)) is not None:
            depth = Fraction(*depth_quotient(problem.frame, piece, i, j))
            found.append((depth, FaceMargin(piece.face, edges, float(depth))))
        elif min(edges) > -REACH:
            missed.append(FaceMargin(piece.face, edges, None))
    found.sort(key=lambda one: one[0])
    gap = float(found[1][0] - found[0][0]) if len(found) > 1 else float("inf")
    return Margins((*(face for _, face in found), *missed), gap)


def _near(problem: Problem, row: int, column: int) -> list[Piece]:
    """Return the pieces whose bounding boxes, a pixel wider, hold a sample."""
    boxes = np.vstack([problem.triangles.box, *(this.box for this in problem.rounds)])
    place = np.array([row, column])
    inside = (boxes[:, :2] <= place + 1).all(axis=1) & (place - 1 <= boxes[:, 2:]).all(axis=1)
    return [problem.piece(int(number)) for number in np.flatnonzero(inside)]


def pixels(polynomial: Polynomial, i: int, j: int) -> float:
    """Distance to where a polynomial vanishes, to first order; a pixel is two units of (i, j)."""
    slopes = [int(polynomial.derivative(k)(i, j)) for k in (0, 1)]
    return pixels_to_zero(int(polynomial(i, j)), slopes[0] ** 2 + slopes[1] ** 2)


def pixels_to_zero(value: int, square: int) -> float:
    """Turn a value, and the square of its gradient by (i, j), into a distance.

    Infinite if the value is stationary at the sample, as that of what does not cut is, or all but so: if the
    square of the distance is beyond float64.
    """
    if value**2 >> 1023 >= square:
        return float("inf") if value >= 0 else float("-inf")
    distance = 0.5 * math.sqrt(value**2 / square)
    return distance if value >= 0 else -distance
