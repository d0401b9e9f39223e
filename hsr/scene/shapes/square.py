"""The square: z = 0, |x|, |y| <= 1."""

from __future__ import annotations

import numpy as np

from hsr.scene.shapes.polygons import Polygons
from hsr.scene.shapes.shape import Kind, Shape

CORNERS = ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0))


def shape() -> Shape:
    """Make the square; its front is toward +z."""
    return Shape(Kind.SQUARE, "square", Polygons.of(np.array(CORNERS, float), [range(4)]), ("square",))
