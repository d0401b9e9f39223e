"""Ray casting: build the ray of a sample, find the nearest hit over the object list, record it.

After Hill and Kelley, "Computer Graphics Using OpenGL" (3rd edition, chapter 12), with four ways to
go through the list: every face of every object; an extent around every object; hierarchies of
extents; and, in ``raytiles``, tiles of coherent rays. All four share the tests below and keep the
best of what they test by one rule, so that they find the same face at every sample.

A sample lies ``(x, y)`` pixels right of and below the image centre. Hits are compared by *nearness*,
1 / depth under perspective and -depth in a parallel view; of equal nearness the lower face id wins.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hsr.arrays import Array, Bools, Floats, Ints
from hsr.jit import jit, parallel_jit, prange
from hsr.kernels.bounds import Beam, Corner, Vector, box_entry, corner_of, nearness_of
from hsr.kernels.hierarchy import INNER, STACK, Tree
from hsr.kernels.quadrics import (
    BACK,
    FRONT,
    NO_FACE,
    cylinder_span,
    first_hit,
    polyhedron_span,
    sphere_span,
    square_hit,
)

SQUARE, CUBE, POLYHEDRON, SPHERE, CYLINDER, MESH = range(6)
"""The kinds of shapes."""

LIST, EXTENTS, HIERARCHY = range(3)
"""How single rays go through the objects."""

RAYS, NODES, EXTENT_TESTS, FACE_TESTS, HITS = range(5)
"""Places in an array of work counts. Tests of generic shapes count as one face test each."""

COUNTS = 5

SMALLEST = 5e-324
"""The least number above 0: ``e >= SMALLEST`` is ``e > 0``."""


class Camera(NamedTuple):
    """How the image is seen; ``closest`` and ``farthest`` are the nearness of near and far."""

    perspective: bool
    near: float
    far: float
    closest: float
    farthest: float
    width: int
    height: int


class Objects(NamedTuple):
    """The object list, one entry (n,) an object.

    Attributes
    ----------
    kind, first_face, cull : (n,) int32
    shape : (n,) int32
        Which polyhedron or which mesh of ``Shapes`` it is.
    mirrored : (n,) bool
        Whether the front of a mesh triangle is where it runs clockwise on the screen.
    screen : (n, 3, 4) float64
        From object space to column, row and depth; see ``corner_of``.
    origin, direction : (n + 1, 3, 3) float64
        The ray of sample (x, y) in object space: ``origin @ (1, x, y)``, ``direction @ (1, x, y)``.
        The last entry is the ray in world space.
    margin : (n + 1, 3) float64
        How far rounding may move that ray.
    low, high : (n, 3) float64
        The extent: the generic cube moved and scaled onto the object, in object space.
    """

    kind: Ints
    first_face: Ints
    cull: Ints
    shape: Ints
    mirrored: Bools
    screen: Floats
    origin: Floats
    direction: Floats
    margin: Floats
    low: Floats
    high: Floats


class Shapes(NamedTuple):
    """The shapes that need data, one after the other.

    Attributes
    ----------
    plane : (P, 4) float64
        Faces of the polyhedra: inside is ``n . p <= m`` for each row (n, m).
    vertex : (V, 3) float64
        Vertices of the meshes, object space.
    corner : (T, 3) int32
        Rows of ``vertex``, triangle after triangle in the order of the leaves of their hierarchy.
    face : (T,) int32
        Face of the object each triangle belongs to.
    plane_start : (polyhedra + 1,) int32
    vertex_start, triangle_start, node_start : (meshes + 1,) int32
        Where each shape begins; a mesh's root is its first node.
    """

    plane: Floats
    vertex: Floats
    corner: Ints
    face: Ints
    plane_start: Ints
    vertex_start: Ints
    triangle_start: Ints
    node_start: Ints


class Scene(NamedTuple):
    """All that a ray meets; ``tree`` has the hierarchies of the meshes."""

    camera: Camera
    objects: Objects
    shapes: Shapes
    tree: Tree


class Image(NamedTuple):
    """The answer: face id, -1 for the background, and depth, ``+inf`` for it; (H, W) each."""

    face: Ints
    depth: Floats


# ---------------------------------------------------------------- one triangle on the screen


class Facet(NamedTuple):
    """A triangle made ready for its coverage test.

    Attributes
    ----------
    turn : float
        Its orientation on the screen, 1 or -1; 0 if it covers nothing.
    x, y, h : 3 floats
        Columns, rows and weights of its corners.
    least : 3 floats
        What the edge function opposite each corner must at least be at a covered sample.
    plane : 3 floats
        Nearness at (x, y) is ``plane . (x, y, 1)``.
    low, high : float
        The least and greatest nearness of its corners.
    """

    turn: float
    x: Vector
    y: Vector
    h: Vector
    least: Vector
    plane: Vector
    low: float
    high: float


class Row(NamedTuple):
    """A facet on one row of samples: ``y`` is relative to the row and times ``turn``."""

    x: Vector
    y: Vector
    h: Vector
    least: Vector
    slope: float
    start: float
    low: float
    high: float


ZERO = (0.0, 0.0, 0.0)
NOTHING = Facet(0.0, ZERO, ZERO, ZERO, ZERO, ZERO, 0.0, 0.0)


@jit
def facet_of(a: Corner, b: Corner, c: Corner, perspective: bool, cull: int, mirrored: bool) -> Facet:
    """Prepare a triangle from its projected corners.

    Corners at or behind the eye are as good as any, for the edge functions are those of homogeneous
    corners (Olano and Greer, "Triangle Scan Conversion Using 2D Homogeneous Coordinates", 1997). A
    triangle seen edge-on covers nothing.
    """
    # Take the plane n . p = m through the corners (column, row, depth).
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    m = nx * a[0] + ny * a[1] + nz * a[2]

    # Decide the facing by the sign of the projected area; rows run down, so a front is negative.
    area = m if perspective else nz
    front = (area < 0.0) != mirrored
    if area == 0.0 or (cull == BACK and not front) or (cull == FRONT and front):
        return NOTHING
    turn = 1.0 if area > 0.0 else -1.0

    # Give every edge its owner at a sample that lies exactly on it.
    h = (a[2], b[2], c[2]) if perspective else (1.0, 1.0, 1.0)
    least = (
        least_inside(b, c, h[1], h[2], turn),
        least_inside(c, a, h[2], h[0], turn),
        least_inside(a, b, h[0], h[1], turn),
    )

    # Solve the plane for the nearness along the ray: its end is (x, y, 1) t, or (x, y, t).
    plane = (nx / area, ny / area, (nz if perspective else -m) / area)
    x, y = (a[0], b[0], c[0]), (a[1], b[1], c[1])
    return Facet(turn, x, y, h, least, plane, min(a[3], b[3], c[3]), max(a[3], b[3], c[3]))


@jit
def least_inside(p: Corner, q: Corner, p_weight: float, q_weight: float, turn: float) -> float:
    """Return the least value of the edge function of p q at a covered sample.

    A sample exactly on an edge belongs to the face it enters when moved right and, less than that,
    down: the top-left rule. The edge function grows by ``across`` to the right and ``down`` below.
    Opposite edges have opposite growth, without rounding, so one of two neighbours is the owner.
    """
    across = turn * (p[1] * q_weight - p_weight * q[1])
    down = turn * (p_weight * q[0] - p[0] * q_weight)
    return 0.0 if across > 0.0 or (across == 0.0 and down > 0.0) else SMALLEST


@jit
def row_of(facet: Facet, y: float) -> Row:
    """Carry a facet to the row of samples at height y."""
    turn, h = facet.turn, facet.h
    relative = (
        turn * (facet.y[0] - y * h[0]),
        turn * (facet.y[1] - y * h[1]),
        turn * (facet.y[2] - y * h[2]),
    )
    start = facet.plane[1] * y + facet.plane[2]
    return Row(facet.x, relative, h, facet.least, facet.plane[0], start, facet.low, facet.high)


@jit
def covered_nearness(row: Row, x: float, closest: float) -> float:
    """Return the nearness of a facet at column x of a row, ``-inf`` where it does not count.

    It counts where the sample is inside all three edges and the nearness at most ``closest``. The
    edge functions take the corners relative to the sample (Woop, Benthin and Wald, "Watertight
    Ray/Triangle Intersection", JCGT 2013). Exchanging the ends of an edge changes its sign and
    nothing else, so that no sample falls between two triangles, or into both.
    """
    ax, bx, cx = row.x[0] - x * row.h[0], row.x[1] - x * row.h[1], row.x[2] - x * row.h[2]
    ay, by, cy = row.y
    inside = (
        (bx * cy - by * cx >= row.least[0])
        & (cx * ay - cy * ax >= row.least[1])
        & (ax * by - ay * bx >= row.least[2])
    )
    # The plane of a facet nearly edge-on is steep: keep its rounding between the corners.
    nearness = row.slope * x + row.start
    nearness = nearness if nearness > row.low else row.low
    nearness = nearness if nearness < row.high else row.high
    return nearness if inside & (nearness <= closest) else -np.inf


# ---------------------------------------------------------------- the hits of one object


@jit
def is_nearer(nearness: float, face: int, best: float, best_face: int) -> bool:
    """Whether a hit beats the best so far: by its nearness, then by the lower face id."""
    return nearness > best or (nearness == best and face < best_face)


@jit
def at_sample(matrix: Floats, k: int, x: float, y: float) -> Vector:
    """Return ``matrix[k] @ (1, x, y)``: the origin or direction of a sample's ray."""
    return (
        matrix[k, 0, 0] + matrix[k, 0, 1] * x + matrix[k, 0, 2] * y,
        matrix[k, 1, 0] + matrix[k, 1, 1] * x + matrix[k, 1, 2] * y,
        matrix[k, 2, 0] + matrix[k, 2, 1] * x + matrix[k, 2, 2] * y,
    )


@jit
def generic_hit(x: float, y: float, k: int, scene: Scene) -> tuple[float, int]:
    """Hit generic object k with the ray of sample (x, y).

    Returns
    -------
    nearness : float
        ``-inf`` for a miss.
    face : int
        Face id, ``NO_FACE`` for a miss.
    """
    camera, objects, shapes = scene.camera, scene.objects, scene.shapes
    o, d = at_sample(objects.origin, k, x, y), at_sample(objects.direction, k, x, y)
    kind, cull = objects.kind[k], objects.cull[k]
    if kind == SQUARE:
        t, face = square_hit(o, d, camera.near, camera.far, cull)
    else:
        if kind == SPHERE:
            span = sphere_span(o, d)
        elif kind == CYLINDER:
            span = cylinder_span(o, d)
        else:
            start, end = shapes.plane_start[objects.shape[k]], shapes.plane_start[objects.shape[k] + 1]
            span = polyhedron_span(o, d, shapes.plane[start:end])
        t, face = first_hit(span, camera.near, camera.far, cull)
    if face == NO_FACE:
        return -np.inf, NO_FACE
    return nearness_of(t, camera.perspective), objects.first_face[k] + face


@jit
def triangle_hit(x: float, y: float, k: int, triangle: int, scene: Scene) -> tuple[float, int]:
    """Hit one triangle of mesh object k with the ray of sample (x, y); see :func:`generic_hit`."""
    camera, objects, shapes = scene.camera, scene.objects, scene.shapes
    a = _projected(scene, k, shapes.corner[triangle, 0])
    b = _projected(scene, k, shapes.corner[triangle, 1])
    c = _projected(scene, k, shapes.corner[triangle, 2])
    facet = facet_of(a, b, c, camera.perspective, objects.cull[k], objects.mirrored[k])
    if facet.turn == 0.0:
        return -np.inf, NO_FACE
    nearness = covered_nearness(row_of(facet, y), x, camera.closest)
    return nearness, objects.first_face[k] + shapes.face[triangle]


@jit
def _projected(scene: Scene, k: int, vertex: int) -> Corner:
    p, screen = scene.shapes.vertex, scene.objects.screen
    return corner_of(screen[k], p[vertex, 0], p[vertex, 1], p[vertex, 2], scene.camera.perspective)


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
def nearest_in_list(x: float, y: float, scene: Scene, extents: bool, work: Array | None) -> Best:
    """Find the nearest hit of the ray of sample (x, y) in the object list.

    Parameters
    ----------
    extents : bool
        Whether an object is skipped if the ray misses its extent.
    """
    objects = scene.objects
    best = Best(scene.camera.farthest, NO_OWNER)
    for k in range(len(objects.kind)):
        if extents:
            tally(work, EXTENT_TESTS)
            beam = beam_of(objects, k, x, y, scene.camera)
            if box_entry(objects.low, objects.high, k, beam) == np.inf:
                continue
        if objects.kind[k] != MESH:
            best = better(counted(generic_hit(x, y, k, scene), work), best)
            continue
        mesh = objects.shape[k]
        for triangle in range(scene.shapes.triangle_start[mesh], scene.shapes.triangle_start[mesh + 1]):
            best = better(counted(triangle_hit(x, y, k, triangle, scene), work), best)
    return best


@jit
def counted(hit: tuple[float, int], work: Array | None) -> tuple[float, int]:
    """Tally a tested face, and its hit if it is one."""
    tally(work, FACE_TESTS)
    if hit[0] > -np.inf:
        tally(work, HITS)
    return hit


class Pending(NamedTuple):
    """Nodes that wait in a walk, and the depths at which the ray enters them."""

    node: Array
    entry: Floats


@jit
def push(pending: Pending, waiting: int, tree: Tree, node: int, beam: Beam) -> int:
    """Let a node wait if the beam meets it; return how many nodes wait now."""
    entry = box_entry(tree.low, tree.high, node, beam)
    if entry == np.inf:
        return waiting
    pending.node[waiting], pending.entry[waiting] = node, entry
    return waiting + 1


@jit
def push_children(pending: Pending, waiting: int, tree: Tree, first: int, beam: Beam) -> int:
    """Let two sister nodes wait, the one entered earlier on top; return how many nodes wait now."""
    one = push(pending, waiting, tree, first, beam)
    two = push(pending, one, tree, first + 1, beam)
    if two == waiting + 2 and pending.entry[waiting] < pending.entry[waiting + 1]:
        pending.node[waiting], pending.node[waiting + 1] = first + 1, first
        entry = pending.entry[waiting]
        pending.entry[waiting], pending.entry[waiting + 1] = pending.entry[waiting + 1], entry
    return two


@jit
def nearest_in_hierarchy(
    x: float, y: float, scene: Scene, world: Tree, rooms: tuple[Pending, Pending], work: Array | None
) -> Best:
    """Find the nearest hit of the ray of sample (x, y) through the hierarchy over the objects.

    Parameters
    ----------
    world : Tree
        Its boxes are the objects' extents in world space.
    rooms : two Pending
        For the walk over the objects and for the walk within one mesh.
    """
    camera, objects, pending = scene.camera, scene.objects, rooms[0]
    beam = beam_of(objects, len(objects.kind), x, y, camera)
    best = Best(camera.farthest, NO_OWNER)
    waiting = push(pending, 0, world, 0, beam)
    while waiting > 0:
        waiting -= 1
        node, entry = pending.node[waiting], pending.entry[waiting]
        tally(work, NODES)
        if nearness_of(entry, camera.perspective) < best.nearness:
            continue
        first, count = world.first[node], world.count[node]
        if count == INNER:
            waiting = push_children(pending, waiting, world, first, beam)
            continue
        for k in range(first, first + count):
            if objects.kind[k] == MESH:
                best = nearest_in_mesh(x, y, k, scene, best, rooms[1], work)
            else:
                best = nearest_in_extent(x, y, k, scene, best, work)
    return best


@jit
def nearest_in_extent(x: float, y: float, k: int, scene: Scene, best: Best, work: Array | None) -> Best:
    """Return the better of ``best`` and the hit of generic object k, if the ray meets its extent."""
    camera, objects = scene.camera, scene.objects
    beam = beam_of(objects, k, x, y, camera)
    tally(work, EXTENT_TESTS)
    if box_entry(objects.low, objects.high, k, beam) == np.inf:
        return best
    return better(counted(generic_hit(x, y, k, scene), work), best)


@jit
def nearest_in_mesh(
    x: float, y: float, k: int, scene: Scene, best: Best, pending: Pending, work: Array | None
) -> Best:
    """Return the better of ``best`` and the nearest hit of mesh object k, through its hierarchy."""
    camera, objects, tree = scene.camera, scene.objects, scene.tree
    beam = beam_of(objects, k, x, y, camera)
    waiting = push(pending, 0, tree, scene.shapes.node_start[objects.shape[k]], beam)
    while waiting > 0:
        waiting -= 1
        node, entry = pending.node[waiting], pending.entry[waiting]
        tally(work, NODES)
        if nearness_of(entry, camera.perspective) < best.nearness:
            continue
        first, count = tree.first[node], tree.count[node]
        if count == INNER:
            waiting = push_children(pending, waiting, tree, first, beam)
            continue
        for triangle in range(first, first + count):
            best = better(counted(triangle_hit(x, y, k, triangle, scene), work), best)
    return best


@jit
def beam_of(objects: Objects, k: int, x: float, y: float, camera: Camera) -> Beam:
    """Return the ray of sample (x, y) in frame k, thick enough to hold the true line of sight."""
    d, margin = at_sample(objects.direction, k, x, y), objects.margin
    return Beam(
        at_sample(objects.origin, k, x, y),
        (reciprocal(d[0]), reciprocal(d[1]), reciprocal(d[2])),
        (margin[k, 0], margin[k, 1], margin[k, 2]),
        camera.near,
        camera.far,
    )


@jit
def reciprocal(number: float) -> float:
    """Return 1 / number, infinite for 0 of either sign."""
    return 1.0 / number if number != 0.0 else np.inf


# ---------------------------------------------------------------- all rays


@parallel_jit
def cast(
    camera: Camera,
    objects: Objects,
    shapes: Shapes,
    tree: Tree,
    world: Tree,
    way: int,
    image: Image,
    work: Array | None,
) -> None:
    """Cast the rays of all samples, one at a time.

    Parameters
    ----------
    camera, objects, shapes, tree
        The parts of a scene.
    world : Tree
        The hierarchy over the objects.
    way : int
        ``LIST``, ``EXTENTS`` or ``HIERARCHY``.
    image : Image
        Receives the answer.
    work : (H, COUNTS) int64 or None
        Receives the work done for every row.
    """
    for row in prange(camera.height):
        scene = Scene(camera, objects, shapes, tree)
        cast_row(row, scene, world, way, image, None if work is None else work[row])


@jit
def cast_row(row: int, scene: Scene, world: Tree, way: int, image: Image, work: Array | None) -> None:
    """Cast the rays of one row of samples."""
    camera = scene.camera
    rooms = (room(), room())
    y = row + 0.5 - 0.5 * camera.height
    for column in range(camera.width):
        x = column + 0.5 - 0.5 * camera.width
        tally(work, RAYS)
        if way == HIERARCHY:
            best = nearest_in_hierarchy(x, y, scene, world, rooms, work)
        else:
            best = nearest_in_list(x, y, scene, way == EXTENTS, work)
        image.face[row, column], image.depth[row, column] = answer_of(best, camera.perspective)


@jit
def room() -> Pending:
    """Return room for the nodes that wait in one walk."""
    return Pending(np.empty(STACK, np.int64), np.empty(STACK, np.float64))


@jit
def answer_of(best: Best, perspective: bool) -> tuple[int, float]:
    """Return the face id and the depth that a map shows for the nearest hit."""
    if best.face == NO_OWNER:
        return -1, np.inf
    return best.face, 1.0 / best.nearness if perspective else -best.nearness
