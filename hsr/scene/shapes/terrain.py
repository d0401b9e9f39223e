"""A fractal height field."""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Floats
from hsr.scene.shapes.lattice import halves
from hsr.scene.shapes.polygons import Polygons


def polygons(detail: int, roughness: float, height: float, seed: int) -> Polygons:
    """Raise a square of ground by midpoint displacement.

    A. Fournier, D. Fussell, L. Carpenter, "Computer rendering of stochastic models",
    Communications of the ACM 25(6), 1982. Each step halves the cells: the middle of an edge gets
    the mean of its two ends, the middle of a cell the mean of its four corners, and both a random
    displacement. The displacements are uniform in ``[-height, height]`` in the first step and
    smaller by the factor ``roughness`` in every further one; the four corners of the square are
    at height 0.

    Parameters
    ----------
    detail : int
        Number of steps.
    roughness : float
        ``2**-H``, H being the dimension parameter of the paper.
    height : float
    seed : int

    Returns
    -------
    Polygons
        ``2 * 4**detail`` triangles over |x|, |z| <= 1, wound counter-clockwise seen from above.
    """
    random = np.random.default_rng(seed)
    y = np.zeros((2, 2))
    for step in range(detail):
        y = _displaced(y, height * roughness**step, random)
    side = len(y)
    ground = np.linspace(-1.0, 1.0, side)
    x, z = np.meshgrid(ground, ground[::-1])
    index = np.arange(side * side, dtype=np.int32).reshape(side, side)
    return Polygons.of_rows(np.stack([x, y, z], axis=-1).reshape(-1, 3), halves(index))


def _displaced(y: Floats, reach: float, random: np.random.Generator) -> Floats:
    """Refine heights (n, n) to (2 n - 1, 2 n - 1), the new ones displaced by at most ``reach``."""
    side = 2 * len(y) - 1
    finer = random.uniform(-reach, reach, (side, side))
    along, across = (y[:, 1:] + y[:, :-1]) / 2.0, (y[1:] + y[:-1]) / 2.0
    finer[::2, ::2] = y
    finer[::2, 1::2] += along
    finer[1::2, ::2] += across
    finer[1::2, 1::2] += (along[1:] + along[:-1]) / 2.0
    return finer
