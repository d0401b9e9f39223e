"""Generic shapes: what the faces of an object are, in object space, before any transform."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property, lru_cache

import numpy as np

from hsr.base.arrays import Array, Floats, Ints

MAX_FACES = 2**31 - 2
"""Face ids are int32, and OpenGL stores face + 1."""


class Kind(IntEnum):
    """The generic shapes; kernels know them by these numbers."""

    SQUARE = 0
    CUBE = 1
    POLYHEDRON = 2
    SPHERE = 3
    CYLINDER = 4
    MESH = 5


CURVED = (Kind.SPHERE, Kind.CYLINDER)


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


@dataclass(frozen=True, eq=False)
class Shape:
    """One shape in object space, shared by all objects that look like it.

    Attributes
    ----------
    kind : Kind
    label : str
        The word of the scene file: ``cube``, ``mesh``, ``teapot``.
    polygons : Polygons or None
        The planar faces; None for a sphere or a cylinder, whose faces are curved.
    face_names : tuple of str
        Names of the faces of a generic shape; empty for meshes.
    cut : int
        Number of faces of a mesh file that had more than three corners and were cut into
        triangles, each of which is a face of its own here.
    """

    kind: Kind
    label: str
    polygons: Polygons | None
    face_names: tuple[str, ...] = ()
    cut: int = 0

    @property
    def curved(self) -> bool:
        """Whether the shape has faces that are not planar."""
        return self.kind in CURVED

    @property
    def faces(self) -> int:
        """Number of faces."""
        if self.face_names or self.polygons is None:
            return len(self.face_names)
        return len(self.polygons)


CUBE_FACES = ("top", "bottom", "right", "left", "front", "back")

# Corner k of the cube is (x, y, z) with x = bit 0, y = bit 1, z = bit 2 of k, as -1 or +1.
CUBE_LOOPS = ((6, 7, 3, 2), (0, 1, 5, 4), (5, 1, 3, 7), (0, 4, 6, 2), (4, 5, 7, 6), (1, 0, 2, 3))


@lru_cache
def generic(kind: Kind) -> Shape:
    """Return the generic square, cube, sphere or cylinder."""
    if kind == Kind.SQUARE:
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=np.float64)
        return Shape(kind, "square", Polygons.of(corners, [(0, 1, 2, 3)]), ("square",))
    if kind == Kind.CUBE:
        bits = np.arange(8)[:, None] >> np.arange(3) & 1
        corners = (2 * bits - 1).astype(np.float64)
        return Shape(kind, "cube", Polygons.of(corners, CUBE_LOOPS), CUBE_FACES)
    if kind == Kind.SPHERE:
        return Shape(kind, "sphere", None, ("sphere",))
    if kind == Kind.CYLINDER:
        return Shape(kind, "cylinder", None, ("side", "base", "cap"))
    raise ValueError(f"{kind.name} is not a generic shape without data")


@lru_cache
def tessellated(kind: Kind, segments: int) -> Shape:
    """Return the polyhedron that stands for a sphere or cylinder; its corners lie on the surface.

    ``segments`` sides stand for a full circle. The faces keep their numbers: every polygon of the
    sphere belongs to face 0.
    """
    shape = generic(kind)
    polygons = _sphere(segments) if kind == Kind.SPHERE else _cylinder(segments)
    return Shape(Kind.MESH, shape.label, polygons, shape.face_names)


def _circle(segments: int) -> Floats:
    """Return the unit circle as (segments, 2), counter-clockwise from +x."""
    angle = 2.0 * np.pi * np.arange(segments) / segments
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _sphere(segments: int) -> Polygons:
    rings = max(segments // 2, 2)
    latitude = np.pi * np.arange(1, rings) / rings
    circle = _circle(segments)
    ring = np.sin(latitude)[:, None, None] * circle
    height = np.broadcast_to(np.cos(latitude)[:, None, None], (rings - 1, segments, 1))
    body = np.concatenate([ring, height], axis=2).reshape(-1, 3)
    vertices = np.concatenate([[[0.0, 0.0, 1.0]], body, [[0.0, 0.0, -1.0]]])
    south = len(vertices) - 1

    loops: list[tuple[int, int, int]] = []
    for j in range(segments):
        k = (j + 1) % segments
        loops.append((0, 1 + j, 1 + k))
        for i in range(rings - 2):
            upper, lower = 1 + i * segments, 1 + (i + 1) * segments
            loops += [(upper + j, lower + j, lower + k), (upper + j, lower + k, upper + k)]
        last = 1 + (rings - 2) * segments
        loops.append((last + j, south, last + k))
    return Polygons.of(vertices, loops, [0] * len(loops))


def _cylinder(segments: int) -> Polygons:
    circle = _circle(segments)
    base = np.column_stack([circle, np.zeros(segments)])
    cap = np.column_stack([circle, np.ones(segments)])
    around = range(segments)
    side = [(j, (j + 1) % segments, segments + (j + 1) % segments, segments + j) for j in around]
    loops = [*side, tuple(reversed(around)), tuple(range(segments, 2 * segments))]
    return Polygons.of(np.concatenate([base, cap]), loops, [0] * segments + [1, 2])
