"""The cube: |x|, |y|, |z| <= 1.

Its six planes, in the order of its faces: top y = 1, bottom y = -1, right x = 1, left x = -1, front z = 1 and
back z = -1. They go through the corners, which are what is written down.
"""

from __future__ import annotations

import numpy as np

from hsr.scene.shapes.polygons import Polygons
from hsr.scene.shapes.shape import Kind, Shape

# Corner k is (x, y, z) with x = bit 0, y = bit 1, z = bit 2 of k, as -1 or +1.
FACES = {
    "top": (6, 7, 3, 2),
    "bottom": (0, 1, 5, 4),
    "right": (5, 1, 3, 7),
    "left": (0, 4, 6, 2),
    "front": (4, 5, 7, 6),
    "back": (1, 0, 2, 3),
}


def shape() -> Shape:
    """Make the cube."""
    corners = 2 * (np.arange(8)[:, None] >> np.arange(3) & 1) - 1
    polygons = Polygons.of_rows(corners, np.array(list(FACES.values())))
    return Shape(Kind.CUBE, "cube", polygons, tuple(FACES))
