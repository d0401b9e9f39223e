"""Ray casting: build the ray of a sample, find the nearest hit over the object list, record it.

After Hill and Kelley, "Computer Graphics Using OpenGL" (3rd edition, chapter 12):

    define the objects, and set up the camera
    for each pixel:
        build the ray from the eye through its centre
        find all hits with the objects of the list
        keep the one that is closest to the eye and in front of it
        record its face and depth

A ray is carried into the space of each object, where :mod:`hsr.kernels.hits` meets the generic shapes; the
triangles of meshes are met on the screen, or in space by a test of :mod:`hsr.kernels.triangle_tests`. A
sample lies ``(x, y)`` pixels right of and below the image centre. Hits are compared by *nearness*, 1 / depth
under perspective and -depth in a parallel view; of equal nearness the lower face id wins.

:mod:`hsr.kernels.ray_hierarchy` asks fewer objects, and counts; :mod:`hsr.kernels.raytiles` casts many rays
at a time.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.base.jit import jit, parallel_jit, prange
from hsr.kernels.culling import CULL_BACK, CULL_FRONT
from hsr.kernels.hits import (
    NO_FACE,
    cylinder_span,
    first_hit,
    polyhedron_span,
    sphere_span,
    square_hit,
)
from hsr.kernels.projection import nearness_of
from hsr.kernels.quadric import quadric_span
from hsr.kernels.ray_objects import CYLINDER, MESH, QUADRIC, SPHERE, SQUARE, Camera, Data
from hsr.kernels.triangle_on_screen import corner_of, covered_nearness, facet_of
from hsr.kernels.triangle_tests import MISS, SCREEN, triangle_at
from hsr.kernels.vectors import Vector, like, point

NO_OWNER = 2**31 - 1
"""Above every face id, so that a face exactly at the far plane beats the background."""


class Best(NamedTuple):
    """The nearest hit so far."""

    nearness: float
    face: int


@parallel_jit
def cast(camera: Camera, data: Data, test: int, face: Ints, depth: Floats) -> None:
    """Cast the rays of all samples, one at a time, against every face of every object.

    Parameters
    ----------
    camera : Camera
    data : Data
    test : int
        How triangles are tested, see :mod:`hsr.kernels.triangle_tests`.
    face : (H, W) int32
        Receives the face id of every sample, -1 for the background.
    depth : (H, W) float64
        Receives its depth, ``+inf`` for the background.
    """
    for row in prange(camera.height):
        y = row + 0.5 - 0.5 * camera.height
        for column in range(camera.width):
            x = column + 0.5 - 0.5 * camera.width
            best = nearest_hit(x, y, camera, data, test)
            face[row, column], depth[row, column] = answer_of(best, camera.perspective)


@jit
def nearest_hit(x: float, y: float, camera: Camera, data: Data, test: int) -> Best:
    """Find the nearest hit of the ray of sample (x, y) in the object list."""
    best = Best(camera.farthest, NO_OWNER)
    for k in range(len(data.objects)):
        thing = data.objects[k]
        if thing["kind"] != MESH:
            best = better(generic_hit(x, y, thing, data.planes, camera), best)
            continue
        for i in range(thing["start"], thing["end"]):
            best = better(triangle_hit(x, y, thing, data.triangles[i], data.vertices, camera, test), best)
    return best


@jit
def better(hit: tuple[float, int], best: Best) -> Best:
    """Return the nearer of two hits, of equal ones that with the lower face id; a miss is none."""
    nearness, face = hit
    if nearness == -np.inf:
        return best
    if nearness > best.nearness or (nearness == best.nearness and face < best.face):
        return Best(nearness, face)
    return best


@jit
def answer_of(best: Best, perspective: bool) -> tuple[int, float]:
    """Return the face id and the depth that a map shows for the nearest hit."""
    if best.face == NO_OWNER:
        return -1, np.inf
    return best.face, 1.0 / best.nearness if perspective else -best.nearness


@jit
def ray_of(thing: Any, x: float, y: float, numbers: Array) -> tuple[Vector, Vector]:
    """Return the ray of sample (x, y) in an object's space: origin and direction, of the type of an array."""
    o, d = at_sample(thing["origin"], x, y), at_sample(thing["direction"], x, y)
    return like(numbers, o), like(numbers, d)


@jit
def at_sample(matrix: Floats, x: float, y: float) -> Vector:
    """Return ``matrix @ (1, x, y)``: the origin or direction of a sample's ray."""
    return (
        matrix[0, 0] + matrix[0, 1] * x + matrix[0, 2] * y,
        matrix[1, 0] + matrix[1, 1] * x + matrix[1, 2] * y,
        matrix[2, 0] + matrix[2, 1] * x + matrix[2, 2] * y,
    )


@jit
def generic_hit(x: float, y: float, thing: Any, planes: Floats, camera: Camera) -> tuple[float, int]:
    """Hit a generic object, an ``OBJECT``, with the ray of sample (x, y).

    Returns
    -------
    nearness : float
        ``-inf`` for a miss.
    face : int
        Face id, ``NO_FACE`` for a miss.
    """
    o, d = ray_of(thing, x, y, planes)
    kind, cull = thing["kind"], thing["cull"]
    if kind == SQUARE:
        t, face = square_hit(o, d, camera.near, camera.far, cull)
    else:
        if kind == SPHERE:
            span = sphere_span(o, d)
        elif kind == CYLINDER:
            span = cylinder_span(o, d)
        elif kind == QUADRIC:
            span = quadric_span(o, d, planes, thing["start"], thing["end"], thing["faces"])
        else:
            span = polyhedron_span(o, d, planes, thing["start"], thing["end"])
        t, face = first_hit(span, camera.near, camera.far, cull)
    if face == NO_FACE:
        return -np.inf, NO_FACE
    return nearness_of(t, camera.perspective), int(thing["first_face"] + face)


@jit
def triangle_hit(
    x: float, y: float, thing: Any, triangle: Any, vertices: Array, camera: Camera, test: int
) -> tuple[float, int]:
    """Hit one ``TRIANGLE`` of a mesh object with the ray of sample (x, y); see :func:`generic_hit`.

    A sample on an edge belongs to one of its two triangles on the screen, and to both in space.
    """
    corner, cull, nearness = triangle["corner"], thing["cull"], -np.inf
    a, b, c = point(vertices[corner[0]]), point(vertices[corner[1]]), point(vertices[corner[2]])
    if test == SCREEN:
        screen, perspective = thing["screen"], camera.perspective
        p, q = corner_of(screen, a, perspective), corner_of(screen, b, perspective)
        facet = facet_of(p, q, corner_of(screen, c, perspective), perspective, cull, thing["mirrored"])
        if facet.turn != 0.0:
            nearness = covered_nearness(facet, x, y, camera.closest)
    else:
        o, d = ray_of(thing, x, y, vertices)
        t, facing = triangle_at(test, o, d, a, b, c)
        culled = (cull == CULL_BACK and facing < 0.0) or (cull == CULL_FRONT and facing > 0.0)
        if t != MISS and not culled and camera.near <= t <= camera.far:
            nearness = nearness_of(t, camera.perspective)
    return nearness, int(thing["first_face"] + triangle["face"])
