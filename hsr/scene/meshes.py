"""Meshes: what the readers of mesh files hand over, and the triangles that are made of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from hsr.base.arrays import Array, Floats
from hsr.base.errors import SceneError
from hsr.scene.shapes import Kind, Polygons, Shape
from hsr.scene.triangulation import triangulated

MAX_TRIANGLES = (2**31 - 1) // 3
"""Corners of triangles are numbered by int32."""

MAX_COORDINATE = 2.0**300
"""Beyond this, a product of three coordinates may overflow float64."""


class Faces(NamedTuple):
    """The faces of a mesh file, in its order.

    Attributes
    ----------
    vertices : (V, 3) float64
    corner : (K,) int64
        Vertex index of every corner, face after face, counted from 0.
    sides : (F,) int64
        Number of corners of every face.
    """

    vertices: Floats
    corner: Array
    sides: Array

    @classmethod
    def of(cls, vertices: Any, corner: Any, sides: Any) -> Faces:
        """Build from anything array-like."""
        vertices = np.asarray(vertices, np.float64).reshape(-1, 3)
        return cls(vertices, np.asarray(corner, np.int64).reshape(-1), np.asarray(sides, np.int64))

    @classmethod
    def of_loops(cls, vertices: Any, loops: Sequence[Any]) -> Faces:
        """Build from the corners of each face, of any number."""
        return cls.of(vertices, [index for loop in loops for index in loop], [len(loop) for loop in loops])

    @classmethod
    def of_rows(cls, vertices: Any, rows: Array) -> Faces:
        """Build from an (F, n) array: the vertex indices of faces that all have n corners."""
        return cls.of(vertices, rows, np.full(len(rows), rows.shape[1]))


def joined(parts: Sequence[Faces]) -> Faces:
    """Put the faces of several meshes one after the other.

    Raises
    ------
    SceneError
        If they are more than :func:`mesh_shape` takes.
    """
    _check_number(sum(int(part.sides.sum()) - 2 * len(part.sides) for part in parts))
    parts = [Faces.of([], [], []), *parts]
    vertices, corner, sides = (np.concatenate(column) for column in zip(*parts, strict=True))
    before = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    return Faces(vertices, corner + np.repeat(before, [len(part.corner) for part in parts]), sides)


def strip_triangles(corner: Array, sides: Array) -> Array:
    """Return the triangles (n, 3) of strips; every other one is turned around, so that all have one front.

    Parameters
    ----------
    corner : (K,) int64
        Vertex indices, strip after strip. A negative one begins another strip.
    sides : (S,) int64
        How many of them each strip has.
    """
    place = np.arange(len(corner))
    start = np.maximum(np.repeat(np.cumsum(sides) - sides, sides), np.where(corner < 0, place + 1, 0))
    start = np.maximum.accumulate(start)
    first = place[:-2][(start[2:] == start[:-2]) & (place[:-2] >= start[:-2])]
    odd = (first - start[first]) % 2
    return np.asarray(corner[np.stack([first + 2 * odd, first + 1, first + 2 - 2 * odd], axis=1)])


def mesh_shape(faces: Faces) -> Shape:
    """Cut the faces of a mesh into triangles.

    Triangles without area stay: they cover nothing, and face numbers remain those of the file. Vertices
    that no face uses may be anything; if they are not finite or too large, they become 0.

    Raises
    ------
    SceneError
        Without a face, or with a face of fewer than three corners, a vertex that does not exist, a
        coordinate that is not finite or too large, or more triangles than int32 can number.
    """
    faces = _checked(faces)
    start = np.concatenate([[0], np.cumsum(faces.sides)]).astype(np.int32)
    polygon = np.arange(len(faces.sides), dtype=np.int32)
    polygons = Polygons(faces.vertices, faces.corner.astype(np.int32), start, polygon)
    triangles, concave = triangulated(polygons)
    cut = int((faces.sides > 3).sum())
    return Shape(Kind.MESH, "mesh", Polygons.of_rows(faces.vertices, triangles), cut=cut, concave=concave)


def _check_number(triangles: int) -> None:
    if triangles > MAX_TRIANGLES:
        raise SceneError(f"the mesh has more than {MAX_TRIANGLES} triangles; split it")


def _checked(faces: Faces) -> Faces:
    if not len(faces.sides):
        raise SceneError("the mesh has no faces")
    if faces.sides.min() < 3:
        k = np.argmax(faces.sides < 3)
        raise SceneError(f"face {k} (counted from 0) has fewer than three corners")
    _check_number(int((faces.sides - 2).sum()))
    missing = (faces.corner < 0) | (faces.corner >= len(faces.vertices))
    if missing.any():
        face = int(np.searchsorted(np.cumsum(faces.sides), np.argmax(missing), side="right"))
        raise SceneError(
            f"face {face} (counted from 0) names a vertex that does not exist; "
            f"there are {len(faces.vertices)}"
        )
    wrong = np.asarray(~(np.abs(faces.vertices) <= MAX_COORDINATE).all(axis=1))
    if not wrong.any():
        return faces
    used = faces.corner[wrong[faces.corner]]
    if len(used):
        first = int(used.min())
        x, y, z = faces.vertices[first]
        what = "too large" if np.isfinite(faces.vertices[first]).all() else "not finite"
        raise SceneError(f"vertex {first} (counted from 0) is {what}: {x:g} {y:g} {z:g}")
    return faces._replace(vertices=np.where(wrong[:, None], 0.0, faces.vertices))
