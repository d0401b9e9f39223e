"""The Menger sponge."""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array, Bools
from hsr.scene.shapes.polygons import Polygons


def polygons(level: int) -> Polygons:
    """Drill the cube |x|, |y|, |z| <= 1 into the Menger sponge.

    K. Menger, "Allgemeine Räume und Cartesische Räume", 1926. The cube is divided into
    3 x 3 x 3; the middle of each side and of the cube go; and so on in what remains.

    Parameters
    ----------
    level : int
        How often; 0 is the plain cube.

    Returns
    -------
    Polygons
        The squares, all of one size, that separate the sponge from what was drilled away: a closed
        surface without inner walls.
    """
    solid = np.pad(_sponge(level), 1)
    loops = np.concatenate([_walls(solid, axis, side) for axis in range(3) for side in (0, 1)])
    lattice = (3**level + 1,) * 3
    used, corner = np.unique(np.ravel_multi_index(loops.reshape(-1, 3).T, lattice), return_inverse=True)
    points = np.stack(np.unravel_index(used, lattice), axis=1).astype(np.float64)
    return Polygons.of_rows(2.0 * points / 3**level - 1.0, corner.reshape(-1, 4))


def _sponge(level: int) -> Bools:
    """Tell which of 3**level cells a side remain.

    A cell is gone if, in base 3, at least two of its three coordinates have a 1 at the same place.
    """
    side = 3**level
    solid = np.ones((side, side, side), dtype=np.bool_)
    for place in range(level):
        middle = np.arange(side) // 3**place % 3 == 1
        x, y, z = middle[:, None, None], middle[None, :, None], middle[None, None, :]
        solid &= ~(x & y | y & z | z & x)
    return solid


def _walls(solid: Bools, axis: int, side: int) -> Array:
    """Corners (n, 4, 3), in cells, of the squares between a solid cell and an empty one.

    The solid cell lies below (side 1) or above (side 0) the square along the axis. ``solid`` has a
    border of empty cells, which the corners do not count.
    """
    beyond = np.roll(solid, -1 if side else 1, axis)
    cell = np.argwhere(solid & ~beyond) - 1
    u, v, n = np.roll(np.eye(3, dtype=np.int64), -(axis + 1), axis=0)
    loop = np.stack([0 * u, u, u + v, v]) if side else np.stack([0 * u, v, u + v, u])
    corners: Array = cell[:, None] + side * n + loop
    return corners
