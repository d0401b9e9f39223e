"""Generic shapes: what the faces of an object are, in object space, before any transform.

One file is one shape, as data: the corners and loops of planar faces, or the quadric of a round solid and the
planes that cut it off. Kernels, the exact decisions of certified methods and the oracle each read the data;
they share no code.

Some are meshes made from a formula, +y up, their faces counter-clockwise as seen from outside (from above,
for the terrain). The same numbers give the same bytes.
"""

from __future__ import annotations

from functools import lru_cache
from pkgutil import resolve_name

from hsr.scene.shapes.polygons import Polygons
from hsr.scene.shapes.shape import MAX_FACES, Kind, Quadric, Shape, tessellated

__all__ = ["MAX_FACES", "Kind", "Polygons", "Quadric", "Shape", "generic", "tessellated"]


@lru_cache
def generic(shape: str, **numbers: float) -> Shape:
    """Return a generic shape by its word and its numbers, both those of the scene file; made once.

    The word names the file. What makes the shape there is called ``shape``, or ``polygons`` if it is a mesh.
    """
    made_by = resolve_name(f"{__name__}.{shape.replace('-', '_')}")
    if hasattr(made_by, "shape"):
        made: Shape = made_by.shape(**numbers)
        return made
    return Shape(Kind.MESH, shape, made_by.polygons(**numbers))
