"""The numbers of a view as integers, and the grid on which its samples are whole numbers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite

from hsr.problem.view import Placement, View

Matrix = list[list[int]]
"""Rows of 4."""


def integers(numbers: Iterable[float]) -> tuple[list[int], int]:
    """Return finite numbers times the least power of two that makes all of them whole, and that power."""
    above, below = zip(*[number.as_integer_ratio() for number in numbers], strict=True)
    unit = max(below)
    return [a * (unit // b) for a, b in zip(above, below, strict=True)], unit


@dataclass(frozen=True, eq=False)
class Frame:
    """A view in integers, all of them ``unit`` times what they stand for.

    The place of a sample is (i, j) = (W x_ndc, H y_ndc): two whole numbers, i to the right, j up.

    Attributes
    ----------
    width, height : int
    perspective : bool
    clip : Matrix
        Carries a point (x, y, z, 1) of the world to (i w, j w, w, depth), w the one of clip space.
    limits : list of int
        Depths of the near plane and, unless it is infinite, of the far plane.
    unit : int
    """

    width: int
    height: int
    perspective: bool
    clip: Matrix
    limits: list[int]
    unit: int

    def place(self, row: int, column: int) -> tuple[int, int]:
        """Return the place of a sample."""
        return 2 * column + 1 - self.width, self.height - 1 - 2 * row

    def matrix(self, placement: Placement) -> Matrix:
        """Return what carries a point (x, y, z, 1) of an object to (i w, j w, w, depth) and to 1.

        The 5 rows are integers once more times a power of two, which is the last number.
        """
        world, unit = integers(placement.world_from_object.ravel().tolist())
        columns = list(zip(world[0:4], world[4:8], world[8:12], world[12:16], strict=True))
        rows = [[a * x + b * y + c * z + d * w for x, y, z, w in columns] for a, b, c, d in self.clip]
        return [*rows, [0, 0, 0, unit]]


def frame_of(view: View) -> Frame:
    """Scale a view to integers."""
    across, up, _, w = view.clip_from_world.tolist()
    planes = [view.near, view.far] if isfinite(view.far) else [view.near]
    camera, unit = integers([*across, *up, *w, *view.depth_row.tolist(), *planes])
    across, up, w, depth = (camera[k : k + 4] for k in range(0, 16, 4))
    clip = [[view.width * a for a in across], [view.height * a for a in up], w, depth]
    return Frame(view.width, view.height, view.perspective, clip, camera[16:], unit)
