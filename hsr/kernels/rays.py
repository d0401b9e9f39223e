"""Ray casting: build the ray of a sample, find the nearest hit over the object list, record it.

After Hill and Kelley, "Computer Graphics Using OpenGL" (3rd edition, chapter 12), with three ways to
go through the list: every face of every object; an extent around every object; and hierarchies of
extents. All three keep the best of what they test by one rule, and test the triangles of meshes on the
screen, by ``facets``, so that they find the same face at every sample. For study, rays may instead meet
triangles in space by one of the tests of ``triangles``, in float32 (where planes and vertices are given so),
and extents without care for rounding. Tiles of coherent rays are in ``raytiles``.

A sample lies ``(x, y)`` pixels right of and below the image centre. Hits are compared by *nearness*,
1 / depth under perspective and -depth in a parallel view; of equal nearness the lower face id wins.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.base.jit import jit, parallel_jit, prange
from hsr.kernels.boxes import Beam, Corner, box_entry, corner_of, naive_entry, nearness_of
from hsr.kernels.culling import CULL_BACK, CULL_FRONT
from hsr.kernels.facets import covered_nearness, facet_of, row_of
from hsr.kernels.hierarchy import INNER, STACK
from hsr.kernels.hits import (
    NO_FACE,
    cylinder_span,
    first_hit,
    polyhedron_span,
    sphere_span,
    square_hit,
)
from hsr.kernels.quadric import quadric_span
from hsr.kernels.triangle_tests import MISS, SCREEN, triangle_at
from hsr.kernels.vectors import Vector, like, point

SQUARE, CUBE, POLYHEDRON, SPHERE, CYLINDER, MESH, QUADRIC, WORLD = range(8)
"""The kinds of shapes, and the world."""

LIST, EXTENTS, HIERARCHY = range(3)
"""How single rays go through the objects."""

RAYS, NODES, EXTENT_TESTS, FACE_TESTS, HITS = range(5)
"""Places in an array of work counts. Tests of generic shapes count as one face test each."""

COUNTS = 5


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
screen : from object space to column, row and depth; see ``corner_of``.
origin, direction : the ray of sample (x, y) in object space is ``origin @ (1, x, y)``, ``direction @
    (1, x, y)``; its parameter is the depth.
margin : how far rounding may move that ray.
low, high : the extent: the generic cube moved and scaled onto the object, in object space.

For ``HIERARCHY`` the world comes last in the list: its frame is world space, and the leaves under its
root are objects.
"""

TRIANGLE = np.dtype([("corner", np.int32, 3), ("face", np.int32)])
"""One triangle of a mesh: rows of its vertices, and its face, counted from the object's first."""


class Data(NamedTuple):
    """What rays are cast into.

    Attributes
    ----------
    objects : (n,) OBJECT
    planes : (P, 4) float64 or float32
        Of all polyhedra: inside is ``n . p <= m`` for each row (n, m). Of all quadrics, see
        ``quadric_span``. Their type is that of the arithmetic of all generic shapes.
    vertices : (V, 3) float64 or float32
        Of all meshes, object space. Their type is that of the tests of triangles in space.
    triangles : (T,) TRIANGLE
        Of all meshes, in the order of the leaves.
    nodes : (N,) NODE
        Of the hierarchies of all meshes, for ``HIERARCHY`` followed by that over the objects.
    """

    objects: Array
    planes: Array
    vertices: Array
    triangles: Array
    nodes: Array


class Way(NamedTuple):
    """How single rays go about it.

    Attributes
    ----------
    acceleration : int
        ``LIST``, ``EXTENTS`` or ``HIERARCHY``.
    test : int
        How triangles are tested: ``SCREEN``, or a test of ``triangles``.
    robust : bool
        Whether extents are met by ``box_entry``, else by ``naive_entry``.
    """

    acceleration: int
    test: int
    robust: bool


# ---------------------------------------------------------------- the hits of one object


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
    o, d = like(planes, at_sample(thing["origin"], x, y)), like(planes, at_sample(thing["direction"], x, y))
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
    """Hit one ``TRIANGLE`` of a mesh object with the ray of sample (x, y); see :func:`generic_hit`."""
    if test == SCREEN:
        return hit_on_screen(x, y, thing, triangle, vertices, camera)
    return hit_in_space(x, y, thing, triangle, vertices, camera, test)


@jit
def hit_on_screen(
    x: float, y: float, thing: Any, triangle: Any, vertices: Array, camera: Camera
) -> tuple[float, int]:
    """Project a triangle, and ask whether it covers the sample (x, y); see :func:`generic_hit`."""
    a = _projected(thing["screen"], vertices, triangle["corner"][0], camera.perspective)
    b = _projected(thing["screen"], vertices, triangle["corner"][1], camera.perspective)
    c = _projected(thing["screen"], vertices, triangle["corner"][2], camera.perspective)
    facet = facet_of(a, b, c, camera.perspective, thing["cull"], thing["mirrored"])
    if facet.turn == 0.0:
        return -np.inf, NO_FACE
    nearness = covered_nearness(row_of(facet, y), x, camera.closest)
    return nearness, int(thing["first_face"] + triangle["face"])


@jit
def hit_in_space(
    x: float, y: float, thing: Any, triangle: Any, vertices: Array, camera: Camera, test: int
) -> tuple[float, int]:
    """Carry the ray of sample (x, y) into the frame of a mesh, and test a triangle; see :func:`generic_hit`.

    A hit counts if ``near <= t <= far`` and its side is not culled. A ray exactly on an edge hits the
    triangles on both sides of it.
    """
    o = like(vertices, at_sample(thing["origin"], x, y))
    d = like(vertices, at_sample(thing["direction"], x, y))
    a = point(vertices[triangle["corner"][0]])
    b = point(vertices[triangle["corner"][1]])
    c = point(vertices[triangle["corner"][2]])
    t, facing = triangle_at(test, o, d, a, b, c)
    culled = (thing["cull"] == CULL_BACK and facing < 0.0) or (thing["cull"] == CULL_FRONT and facing > 0.0)
    if t == MISS or culled or not camera.near <= t <= camera.far:
        return -np.inf, NO_FACE
    return nearness_of(t, camera.perspective), int(thing["first_face"] + triangle["face"])


@jit
def _projected(screen: Floats, vertices: Array, k: int, perspective: bool) -> Corner:
    return corner_of(screen, vertices[k, 0], vertices[k, 1], vertices[k, 2], perspective)


# ---------------------------------------------------------------- the nearest hit of one ray


class Best(NamedTuple):
    """The nearest hit so far."""

    nearness: float
    face: int


NO_OWNER = 2**31 - 1
"""Above every face id, so that a face exactly at the far plane beats the background."""


@jit
def better(hit: tuple[float, int], best: Best) -> Best:
    """Return the nearer of two hits, of equal ones that with the lower face id."""
    nearness, face = hit
    if nearness > best.nearness or (nearness == best.nearness and face < best.face):
        return Best(nearness, face)
    return best


@jit
def tally(work: Array | None, what: int) -> None:
    """Count one more piece of work, if work is counted."""
    if work is not None:
        work[what] += 1


@jit
def counted(hit: tuple[float, int], work: Array | None) -> tuple[float, int]:
    """Tally a tested face, and its hit if it is one."""
    tally(work, FACE_TESTS)
    if hit[0] > -np.inf:
        tally(work, HITS)
    return hit


@jit
def nearest_in_list(x: float, y: float, camera: Camera, data: Data, way: Way, work: Array | None) -> Best:
    """Find the nearest hit of the ray of sample (x, y) in the object list.

    With ``EXTENTS`` an object is skipped if the ray misses its extent.
    """
    best = Best(camera.farthest, NO_OWNER)
    for k in range(len(data.objects)):
        thing = data.objects[k]
        if way.acceleration == EXTENTS and not meets_extent(x, y, thing, camera, way.robust, work):
            continue
        if thing["kind"] != MESH:
            best = better(counted(generic_hit(x, y, thing, data.planes, camera), work), best)
            continue
        for i in range(thing["start"], thing["end"]):
            hit = triangle_hit(x, y, thing, data.triangles[i], data.vertices, camera, way.test)
            best = better(counted(hit, work), best)
    return best


@jit
def meets_extent(x: float, y: float, thing: Any, camera: Camera, robust: bool, work: Array | None) -> bool:
    """Whether the ray of sample (x, y) meets the extent of an object."""
    tally(work, EXTENT_TESTS)
    return entry_of(thing, beam_of(thing, x, y, camera), robust) < np.inf


@jit
def entry_of(box: Any, beam: Beam, robust: bool) -> float:
    """Return the parameter at which a beam enters a box, ``+inf`` if it misses."""
    return box_entry(box, beam) if robust else naive_entry(box, beam)


@jit
def beam_of(thing: Any, x: float, y: float, camera: Camera) -> Beam:
    """Return the ray of sample (x, y) in an object's frame, thick enough to hold the line of sight."""
    d, margin = at_sample(thing["direction"], x, y), thing["margin"]
    return Beam(
        at_sample(thing["origin"], x, y),
        (reciprocal(d[0]), reciprocal(d[1]), reciprocal(d[2])),
        (margin[0], margin[1], margin[2]),
        camera.near,
        camera.far,
    )


@jit
def reciprocal(number: float) -> float:
    """Return 1 / number, for 0 infinity of its sign."""
    return 1.0 / number if number != 0.0 else np.copysign(np.inf, number)


PENDING = np.dtype([("node", np.int64), ("entry", np.float64)])
"""A node that waits in a walk, and the depth at which the ray enters it."""


@jit
def push(pending: Array, waiting: int, nodes: Array, node: int, beam: Beam, robust: bool) -> int:
    """Let a node wait if the beam meets it; return how many nodes wait now."""
    entry = entry_of(nodes[node], beam, robust)
    pending[waiting]["node"], pending[waiting]["entry"] = node, entry
    return waiting + int(entry < np.inf)


@jit
def push_children(pending: Array, waiting: int, nodes: Array, first: int, beam: Beam, robust: bool) -> int:
    """Let two sister nodes wait, the one entered earlier on top; return how many nodes wait now."""
    one = push(pending, waiting, nodes, first, beam, robust)
    two = push(pending, one, nodes, first + 1, beam, robust)
    if two == waiting + 2 and pending[waiting]["entry"] < pending[one]["entry"]:
        earlier = pending[waiting]["entry"]
        pending[waiting]["node"], pending[one]["node"] = first + 1, first
        pending[waiting]["entry"], pending[one]["entry"] = pending[one]["entry"], earlier
    return two


@jit
def nearest_in_hierarchy(
    x: float, y: float, camera: Camera, data: Data, way: Way, rooms: Array, work: Array | None
) -> Best:
    """Find the nearest hit of the ray of sample (x, y) through the hierarchy over the objects.

    Parameters
    ----------
    rooms : (2, STACK) PENDING
        Room for the walk over the objects and for the walk within one mesh.
    """
    pending, nodes, world = rooms[0], data.nodes, data.objects[len(data.objects) - 1]
    beam = beam_of(world, x, y, camera)
    best = Best(camera.farthest, NO_OWNER)
    waiting = push(pending, 0, nodes, world["root"], beam, way.robust)
    while waiting > 0:
        waiting -= 1
        node = nodes[pending[waiting]["node"]]
        tally(work, NODES)
        if nearness_of(pending[waiting]["entry"], camera.perspective) < best.nearness:
            continue
        if node["count"] == INNER:
            waiting = push_children(pending, waiting, nodes, node["first"], beam, way.robust)
            continue
        for k in range(node["first"], node["first"] + node["count"]):
            thing = data.objects[k]
            if thing["kind"] == MESH:
                best = nearest_in_mesh(x, y, camera, thing, data, way, best, rooms[1], work)
            elif meets_extent(x, y, thing, camera, way.robust, work):
                best = better(counted(generic_hit(x, y, thing, data.planes, camera), work), best)
    return best


@jit
def nearest_in_mesh(
    x: float,
    y: float,
    camera: Camera,
    thing: Any,
    data: Data,
    way: Way,
    best: Best,
    pending: Array,
    work: Array | None,
) -> Best:
    """Return the better of ``best`` and the nearest hit of a mesh object, through its hierarchy."""
    nodes, beam = data.nodes, beam_of(thing, x, y, camera)
    waiting = push(pending, 0, nodes, thing["root"], beam, way.robust)
    while waiting > 0:
        waiting -= 1
        node = nodes[pending[waiting]["node"]]
        tally(work, NODES)
        if nearness_of(pending[waiting]["entry"], camera.perspective) < best.nearness:
            continue
        if node["count"] == INNER:
            waiting = push_children(pending, waiting, nodes, node["first"], beam, way.robust)
            continue
        for i in range(node["first"], node["first"] + node["count"]):
            hit = triangle_hit(x, y, thing, data.triangles[i], data.vertices, camera, way.test)
            best = better(counted(hit, work), best)
    return best


# ---------------------------------------------------------------- all rays


@parallel_jit
def cast(camera: Camera, data: Data, way: Way, face: Ints, depth: Floats, work: Array | None) -> None:
    """Cast the rays of all samples, one at a time.

    Parameters
    ----------
    camera : Camera
    data : Data
    way : Way
    face : (H, W) int32
        Receives the face id of every sample, -1 for the background.
    depth : (H, W) float64
        Receives its depth, ``+inf`` for the background.
    work : (H, COUNTS) int64 or None
        Receives the work done for every row.
    """
    for row in prange(camera.height):
        rooms = np.empty((2, STACK), PENDING)
        done = None if work is None else work[row]
        y = row + 0.5 - 0.5 * camera.height
        for column in range(camera.width):
            x = column + 0.5 - 0.5 * camera.width
            tally(done, RAYS)
            if way.acceleration == HIERARCHY:
                best = nearest_in_hierarchy(x, y, camera, data, way, rooms, done)
            else:
                best = nearest_in_list(x, y, camera, data, way, done)
            face[row, column], depth[row, column] = answer_of(best, camera.perspective)


@jit
def answer_of(best: Best, perspective: bool) -> tuple[int, float]:
    """Return the face id and the depth that a map shows for the nearest hit."""
    if best.face == NO_OWNER:
        return -1, np.inf
    return best.face, 1.0 / best.nearness if perspective else -best.nearness
