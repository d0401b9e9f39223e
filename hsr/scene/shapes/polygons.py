"""Convex polygons over shared vertices: what every planar face is made of."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import chain

import numpy as np

from hsr.base.arrays import Array, Floats, Ints, ranges


@dataclass(frozen=True, eq=False)
class Polygons:
    """Convex polygons over shared vertices.

    Polygon ``i`` has the corners ``vertices[corner[start[i]:start[i + 1]]]``, counter-clockwise
    as seen from its front. A polygon of more than three corners means the fan of triangles about
    its first corner.

    Attributes
    ----------
    vertices : (V, 3) float64
    corner : (K,) int32
        Vertex index of every corner, polygon after polygon.
    start : (P + 1,) int32
    face : (P,) int32
        Face each polygon belongs to; several polygons may be one face.
    """

    vertices: Floats
    corner: Ints
    start: Ints
    face: Ints

    @classmethod
    def of(
        cls, vertices: Floats, loops: Sequence[Sequence[int]], face: Sequence[int] | None = None
    ) -> Polygons:
        """Build from lists of corners; without ``face`` every polygon is a face of its own."""
        start = np.cumsum([0, *map(len, loops)]).astype(np.int32)
        corner = np.array([*chain.from_iterable(loops)], np.int32)
        owner = np.array(range(len(loops)) if face is None else face, np.int32)
        return cls(np.ascontiguousarray(vertices, np.float64), corner, start, owner)

    @classmethod
    def of_rows(cls, vertices: Array, rows: Array) -> Polygons:
        """Build from vertex indices (n, k) of polygons that all have k corners; each is a face of its own."""
        count, sides = rows.shape
        corner = np.ascontiguousarray(rows, np.int32).reshape(-1)
        start = np.arange(0, sides * count + 1, sides, dtype=np.int32)
        face = np.arange(count, dtype=np.int32)
        return cls(np.ascontiguousarray(vertices, np.float64), corner, start, face)

    def __len__(self) -> int:
        return len(self.face)

    def part(self, chosen: Array) -> Polygons:
        """Return some of the polygons, by their numbers (n,), with only the vertices they use."""
        which, place = ranges(self.start[:-1][chosen], self.start[1:][chosen])
        start = np.searchsorted(which, np.arange(len(chosen) + 1))
        used, corner = np.unique(self.corner[place], return_inverse=True)
        vertices = self.vertices[used].astype(np.float64)
        return Polygons(vertices, corner.astype(np.int32), start.astype(np.int32), self.face[chosen])

    @property
    def used(self) -> Floats:
        """The vertices (n, 3) that are corners; a copy, unless all are."""
        index = np.unique(self.corner)
        return self.vertices if len(index) == len(self.vertices) else self.vertices[index]

    @property
    def reach(self) -> Callable[[Floats], tuple[float, float]]:
        """From a row (4,) to the least and the greatest value of ``row @ (p, 1)`` over all points p.

        It holds the vertices that are used: take it once, and ask it for many rows.
        """
        return partial(_reach, self.used)

    @cached_property
    def triangle_polygon(self) -> Ints:
        """Polygon (n,) that each fan triangle comes from."""
        return np.repeat(np.arange(len(self), dtype=np.int32), np.diff(self.start) - 2)

    @cached_property
    def triangle_vertex(self) -> Ints:
        """Vertex indices (n, 3) of the fan triangles, polygon after polygon."""
        if len(self.corner) == 3 * len(self):
            return self.corner.reshape(-1, 3)
        # Every polygon before a triangle's own has two corners more than triangles.
        corner = np.arange(len(self.triangle_polygon)) + 2 * self.triangle_polygon + 1
        return self.corner[np.stack([self.start[self.triangle_polygon], corner, corner + 1], axis=1)]

    @cached_property
    def triangle_face(self) -> Ints:
        """Face (n,) that each fan triangle comes from."""
        return self.face[self.triangle_polygon]


def _reach(points: Floats, row: Floats) -> tuple[float, float]:
    values = points @ row[:3] + row[3]
    return float(values.min()), float(values.max())
