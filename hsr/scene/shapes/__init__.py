"""Generic shapes: what the faces of an object are, in object space, before any transform.

One file is one shape, as data: the corners and loops of planar faces, or the quadric of a round solid and the
planes that cut it off. Kernels, the exact decisions of certified methods and the oracle each read the data;
they share no code.

Some are meshes made from a formula, +y up, their faces counter-clockwise as seen from outside (from above,
for the terrain). The same numbers give the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from hsr.scene.shapes import cube, cylinder, fir, menger, sphere, square, teapot, terrain, torus_knot
from hsr.scene.shapes.polygons import Polygons
from hsr.scene.shapes.shape import MAX_FACES, Kind, Quadric, Shape, tessellated

__all__ = ["GENERIC", "MAX_FACES", "Kind", "Polygons", "Quadric", "Shape", "generic", "tessellated"]

GENERIC: dict[str, Callable[..., Shape | Polygons]] = {
    "square": square.shape,
    "cube": cube.shape,
    "sphere": sphere.shape,
    "cylinder": cylinder.shape,
    "teapot": teapot.polygons,
    "torus-knot": torus_knot.polygons,
    "terrain": terrain.polygons,
    "menger": menger.polygons,
    "fir": fir.polygons,
}
"""What makes shapes, or the polygons of meshes, of which a scene file gives a word and a few numbers."""


@lru_cache
def generic(shape: str, **numbers: float) -> Shape:
    """Return a generic shape by its word and its numbers, both those of the scene file; made once."""
    made = GENERIC[shape](**numbers)
    return made if isinstance(made, Shape) else Shape(Kind.MESH, shape, made)
