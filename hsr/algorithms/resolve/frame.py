"""The numbers of a view as integers, and the grid on which its samples are whole numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr.arrays import Array, Floats
from hsr.viewing import View

_ratio: Any = np.frompyfunc(float.as_integer_ratio, 1, 2)


def integers(numbers: Floats) -> tuple[Array, int]:
    """Return ``numbers`` times the least power of two that makes all of them whole, and that power.

    Parameters
    ----------
    numbers : (...) float64, finite

    Returns
    -------
    (...) object
        Python integers.
    int
    """
    numerator, denominator = _ratio(numbers)
    unit = int(denominator.max())
    return numerator * (unit // denominator), unit


@dataclass(frozen=True, eq=False)
class Frame:
    """A view in integers, all of them ``unit`` times what they stand for.

    The place of a sample is (i, j) = (W x_ndc, H y_ndc): two whole numbers, i to the right, j up.

    Attributes
    ----------
    width, height : int
    perspective : bool
    matrices : (objects, 4, 4) object
        Carry a point (x, y, z, 1) of each object to (i w, j w, w, depth), w the one of clip space.
    limits : tuple of int
        Depths of the near plane and, unless it is infinite, of the far plane.
    unit : int
    """

    width: int
    height: int
    perspective: bool
    matrices: Array
    limits: tuple[int, ...]
    unit: int

    def place(self, sample: Array) -> tuple[Array, Array]:
        """Return the places (n,) and (n,) object of samples (n,) ``row * W + column``."""
        row, column = np.divmod(sample, self.width)
        i, j = 2 * column + 1 - self.width, self.height - 1 - 2 * row
        return i.astype(object), j.astype(object)


def frame_of(view: View) -> Frame:
    """Scale a view to integers."""
    rows = np.vstack([view.clip_from_world[[0, 1, 3]], view.depth_row])
    planes = [view.near, view.far] if np.isfinite(view.far) else [view.near]
    camera, camera_unit = integers(np.append(rows, planes))
    clip = camera[:16].reshape(4, 4) * np.array([[view.width], [view.height], [1], [1]], dtype=object)
    worlds, unit = integers(np.stack([placement.world_from_object for placement in view.placements]))
    limits = tuple(camera[16:] * unit)
    return Frame(view.width, view.height, view.perspective, clip @ worlds, limits, camera_unit * unit)
