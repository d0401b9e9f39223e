"""Generic shapes: what the faces of an object are, in object space, before any transform.

One file is one shape, as data: the corners and loops of planar faces, or the quadric of a round solid and the
planes that cut it off. Kernels, the exact decisions of certified methods and the oracle each read the data;
they share no code.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from hsr.scene.shapes import cube, cylinder, sphere, square
from hsr.scene.shapes.polygons import Polygons
from hsr.scene.shapes.shape import MAX_FACES, Kind, Quadric, Shape, tessellated

__all__ = ["GENERIC", "MAX_FACES", "Kind", "Polygons", "Quadric", "Shape", "generic", "tessellated"]

GENERIC: dict[str, Callable[..., Shape]] = {
    "square": square.shape,
    "cube": cube.shape,
    "sphere": sphere.shape,
    "cylinder": cylinder.shape,
}
"""What makes the shapes of which a scene file gives a word and a few numbers."""


@lru_cache
def generic(shape: str, **numbers: float) -> Shape:
    """Return a generic shape by its word and its numbers, both those of the scene file; made once."""
    return GENERIC[shape](**numbers)
