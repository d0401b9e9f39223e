"""The numbers of a view as integers, and the grid on which its samples are whole numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from operator import mul

from hsr.viewing import View

Matrix = list[list[int]]
"""4 rows of 4."""


def integers(numbers: Iterable[float]) -> tuple[list[int], int]:
    """Return finite numbers times the least power of two that makes all of them whole, and that power."""
    ratios = [number.as_integer_ratio() for number in numbers]
    unit = max(denominator for _, denominator in ratios)
    return [numerator * (unit // denominator) for numerator, denominator in ratios], unit


@dataclass(frozen=True, eq=False)
class Frame:
    """A view in integers, all of them ``unit`` times what they stand for.

    The place of a sample is (i, j) = (W x_ndc, H y_ndc): two whole numbers, i to the right, j up.

    Attributes
    ----------
    width, height : int
    perspective : bool
    matrices : dict of int to Matrix
        Carry a point (x, y, z, 1) of each object to (i w, j w, w, depth), w the one of clip space.
    limits : tuple of int
        Depths of the near plane and, unless it is infinite, of the far plane.
    unit : int
    """

    width: int
    height: int
    perspective: bool
    matrices: dict[int, Matrix]
    limits: tuple[int, ...]
    unit: int

    def place(self, sample: int) -> tuple[int, int]:
        """Return the place of a sample ``row * W + column``."""
        row, column = divmod(sample, self.width)
        return 2 * column + 1 - self.width, self.height - 1 - 2 * row


def frame_of(view: View, things: list[int]) -> Frame:
    """Scale a view to integers, with the matrices of some of its objects."""
    across, up, _, w = view.clip_from_world.tolist()
    planes = [view.near, view.far] if math.isfinite(view.far) else [view.near]
    camera, camera_unit = integers([*across, *up, *w, *view.depth_row.tolist(), *planes])
    across, up, w, depth = (camera[k : k + 4] for k in range(0, 16, 4))
    clip = [[view.width * a for a in across], [view.height * a for a in up], w, depth]

    worlds = [view.placements[thing].world_from_object.ravel().tolist() for thing in things]
    world, unit = integers([number for numbers in worlds for number in numbers])
    matrices = {thing: _product(clip, world[16 * k : 16 * k + 16]) for k, thing in enumerate(things)}
    limits = tuple(limit * unit for limit in camera[16:])
    return Frame(view.width, view.height, view.perspective, matrices, limits, camera_unit * unit)


def _product(clip: Matrix, world: list[int]) -> Matrix:
    """Return the product of two matrices, the second one row after row."""
    columns = [world[k::4] for k in range(4)]
    return [[sum(map(mul, row, column)) for column in columns] for row in clip]
