"""Convex polygons over shared vertices: what every planar face is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hsr.base.arrays import Array, Floats, Ints


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
        sizes = np.array([0, *(len(loop) for loop in loops)])
        corner = np.array([index for loop in loops for index in loop], dtype=np.int32)
        owner = np.arange(len(loops)) if face is None else np.asarray(face)
        return cls(
            np.ascontiguousarray(vertices, dtype=np.float64),
            corner,
            np.cumsum(sizes).astype(np.int32),
            owner.astype(np.int32),
        )

    @classmethod
    def of_triangles(cls, vertices: Floats, triangles: Ints) -> Polygons:
        """Build from (n, 3) vertex indices; every triangle is a face of its own."""
        count = len(triangles)
        return cls(
            np.ascontiguousarray(vertices, dtype=np.float64),
            np.ascontiguousarray(triangles, dtype=np.int32).reshape(-1),
            np.arange(0, 3 * count + 1, 3, dtype=np.int32),
            np.arange(count, dtype=np.int32),
        )

    def __len__(self) -> int:
        return len(self.face)

    def part(self, chosen: Array) -> Polygons:
        """Return some of the polygons, by their numbers (n,), with only the vertices they use."""
        sides = np.diff(self.start)[chosen]
        start = np.cumsum([0, *sides])
        place = np.arange(start[-1]) + np.repeat(self.start[chosen] - start[:-1], sides)
        used, corner = np.unique(self.corner[place], return_inverse=True)
        vertices = self.vertices[used].astype(np.float64)
        return Polygons(vertices, corner.astype(np.int32), start.astype(np.int32), self.face[chosen])

    @cached_property
    def _fan(self) -> tuple[Ints, Ints]:
        """Vertex indices (n, 3) of all fan triangles, and the polygon (n,) each comes from."""
        sides = np.diff(self.start)
        if (sides == 3).all():
            return self.corner.reshape(-1, 3), np.arange(len(self), dtype=np.int32)
        polygon = np.repeat(np.arange(len(self), dtype=np.int32), sides - 2)
        first = self.start[polygon]
        step = np.arange(len(polygon)) - np.repeat(np.cumsum(sides - 2) - (sides - 2), sides - 2)
        corners = np.stack([first, first + step + 1, first + step + 2], axis=1)
        return self.corner[corners], polygon

    @property
    def triangle_vertex(self) -> Ints:
        """Vertex indices (n, 3) of the fan triangles, polygon after polygon."""
        return self._fan[0]

    @property
    def triangle_polygon(self) -> Ints:
        """Polygon (n,) that each fan triangle comes from."""
        return self._fan[1]

    @cached_property
    def triangle_face(self) -> Ints:
        """Face (n,) that each fan triangle comes from."""
        return self.face[self.triangle_polygon]
