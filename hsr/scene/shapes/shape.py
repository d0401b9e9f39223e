"""What a shape is, whichever it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property, lru_cache
from typing import cast

import numpy as np

from hsr.base.arrays import Array, Floats
from hsr.base.files import digest_of
from hsr.scene.shapes.polygons import Polygons

MAX_FACES = 2**31 - 2
"""Face ids are int32, and OpenGL stores face + 1."""


class Kind(IntEnum):
    """How single rays meet a shape; kernels know it by these numbers."""

    SQUARE = 0
    CUBE = 1
    POLYHEDRON = 2
    SPHERE = 3
    CYLINDER = 4
    MESH = 5
    QUADRIC = 6


@dataclass(frozen=True, eq=False)
class Quadric:
    """A round solid: the points p = (x, y, z, 1) where p . form . p <= 0, as far as planes leave it.

    What the planes leave is convex. Its surface where p . form . p = 0 is face 0.

    Attributes
    ----------
    form : (4, 4) object
        Symmetric, in whole numbers, and so exact; p . form . p is negative inside, positive outside.
    ends : (n, 4) object
        Planes, two at most, in whole numbers: end . p >= 0 on the solid. The first of them bound it and are
        faces, 1 and so on; the others part it from what else solves the equation.
    reach : callable
        From a row (4,) to the least and the greatest value of row . p on the solid.
    outline : callable
        From where lines of sight meet, (x, y, z, w) in object space and rounded, to the curves that bound the
        solid's faces on an image: the faces of each, and its straight pieces (n, 2, 3).
    polygons : callable
        From how many sides stand for a full circle to polygons with their corners on the surface.
    """

    form: Array
    ends: Array
    reach: Callable[[Floats], tuple[float, float]]
    outline: Callable[[Floats], Iterator[tuple[set[int], Floats]]]
    polygons: Callable[[int], Polygons]

    @cached_property
    def rounded(self) -> Floats:
        """The form (4, 4) as float64, divided by its greatest coefficient."""
        return np.asarray(self.form / abs(self.form).max(), dtype=np.float64)

    @cached_property
    def box(self) -> Floats:
        """Opposite corners (2, 3) of the box around the solid."""
        return np.array([self.reach(axis) for axis in np.eye(4)[:3]]).T


@dataclass(frozen=True, eq=False)
class Shape:
    """One shape in object space, shared by all objects that look like it.

    Attributes
    ----------
    kind : Kind
    label : str
        The word of the scene file: ``cube``, ``mesh``, ``teapot``.
    polygons : Polygons or None
        The planar faces; None if there is a quadric.
    face_names : tuple of str
        Names of the faces of a generic shape; empty for meshes.
    cut : int
        Number of faces of a mesh file that had more than three corners and were cut into
        triangles, each of which is a face of its own here.
    quadric : Quadric or None
        The round solid that is the shape.
    concave : int
        How many of those the fan about their first corner would not cover.
    """

    kind: Kind
    label: str
    polygons: Polygons | None
    face_names: tuple[str, ...] = ()
    cut: int = 0
    quadric: Quadric | None = None
    concave: int = 0

    @property
    def curved(self) -> bool:
        """Whether the shape has faces that are not planar."""
        return self.quadric is not None

    @property
    def solid(self) -> Quadric | Polygons:
        """What bounds it."""
        return self.quadric or cast(Polygons, self.polygons)

    @property
    def faces(self) -> int:
        """Number of faces."""
        if self.face_names or self.polygons is None:
            return len(self.face_names)
        return len(self.polygons)

    @cached_property
    def digest(self) -> str:
        """The SHA-256 of what tells the shape from all others."""
        return digest_of(self._content())

    def _content(self) -> Iterator[bytes]:
        yield self.kind.name.encode()
        if self.kind == Kind.QUADRIC and self.quadric is not None:
            yield f"{self.quadric.form.tolist()} {self.quadric.ends.tolist()}".encode()
        if self.polygons is not None:
            own = self.polygons
            yield from (array.tobytes() for array in (own.vertices, own.corner, own.start, own.face))


@lru_cache
def tessellated(shape: Shape, segments: int) -> Shape:
    """Return the polyhedron that stands for a curved shape; its corners lie on the surface.

    ``segments`` sides stand for a full circle. The faces keep their numbers: every polygon of a sphere
    belongs to face 0.
    """
    if shape.quadric is None:
        return shape
    return Shape(Kind.MESH, shape.label, shape.quadric.polygons(segments), shape.face_names)


# ---------------------------------------------------------------- circles

ARCS = 180
"""Straight pieces in which a circle is drawn; they leave it by 1 - cos(pi / 180) = 0.00015 of its radius."""


def circle(segments: int) -> Floats:
    """Return corners of the unit circle as (segments, 2), counter-clockwise from +x."""
    angle = 2.0 * np.pi * np.arange(segments) / segments
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def arcs(centre: Floats, u: Floats, v: Floats) -> Floats:
    """Return the pieces (ARCS, 2, 3) of a circle with two perpendicular radii."""
    angle = np.linspace(0.0, 2.0 * np.pi, ARCS + 1)[:, None]
    points = centre + np.cos(angle) * u + np.sin(angle) * v
    return np.stack([points[:-1], points[1:]], axis=1)
