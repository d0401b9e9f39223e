"""What rays are cast into: the camera and the object list, as arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hsr.base.arrays import Array

SQUARE, CUBE, POLYHEDRON, SPHERE, CYLINDER, MESH, QUADRIC = range(7)
"""The kinds of shapes."""


class Camera(NamedTuple):
    """How the image is seen; ``closest`` and ``farthest`` are the nearness of near and far."""

    perspective: bool
    near: float
    far: float
    closest: float
    farthest: float
    width: int
    height: int


OBJECT = np.dtype(
    [
        ("kind", np.int32),
        ("first_face", np.int32),
        ("cull", np.int32),
        ("mirrored", np.bool_),
        ("faces", np.int32),
        ("start", np.int64),
        ("end", np.int64),
        ("root", np.int64),
        ("screen", np.float64, (3, 4)),
        ("origin", np.float64, (3, 3)),
        ("direction", np.float64, (3, 3)),
        ("margin", np.float64, 3),
        ("low", np.float64, 3),
        ("high", np.float64, 3),
    ]
)
"""One object of the list.

mirrored : whether the front of a mesh triangle is where it runs clockwise on the screen.
faces : how many it has.
start, end : rows of its planes (cube, polyhedron; behind those of its form: quadric) or triangles (mesh).
root : row of the root of a mesh's nodes.
screen : from object space to column, row and depth; see :func:`hsr.kernels.triangle_on_screen.corner_of`.
origin, direction : the ray of sample (x, y) in object space is ``origin @ (1, x, y)``, ``direction @
    (1, x, y)``; its parameter is the depth.
margin : how far rounding may move that ray.
low, high : the extent: the generic cube moved and scaled onto the object, in object space.
"""

TRIANGLE = np.dtype([("corner", np.int32, 3), ("face", np.int32)])
"""One triangle of a mesh: rows of its vertices, and its face, counted from the object's first."""


class Data(NamedTuple):
    """What rays are cast into.

    Attributes
    ----------
    objects : (n,) OBJECT
        For a walk through hierarchies the world comes last: its space is world space, and the leaves under
        its root are objects.
    planes : (P, 4) float64 or float32
        Of all polyhedra: inside is ``n . p <= m`` for each row (n, m). Of all quadrics, see
        :func:`hsr.kernels.quadric.quadric_span`. Their type is that of the arithmetic of all generic shapes.
    vertices : (V, 3) float64 or float32
        Of all meshes, object space. Their type is that of the tests of triangles in space.
    triangles : (T,) TRIANGLE
        Of all meshes, in the order of the leaves.
    nodes : (N,) NODE
        Of the hierarchies of all meshes, for such a walk followed by that over the objects.
    """

    objects: Array
    planes: Array
    vertices: Array
    triangles: Array
    nodes: Array
