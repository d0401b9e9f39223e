"""Ray casting: one ray a sample, and of all it meets the nearest.

Four ways to go through the objects, one answer: the plain list of the textbook, the list with an
extent around every object, hierarchies of extents for single rays, and coherent tiles of rays.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, get_args
from weakref import WeakKeyDictionary

import numpy as np

from hsr.arrays import Array, Floats, Ints
from hsr.errors import MethodError
from hsr.kernels import hierarchy, rays, raytiles
from hsr.kernels.bounds import nearness_of
from hsr.scene.shapes import Kind, Polygons, Shape
from hsr.viewing import Rays, View
from hsr.visibility import Clock, VisibilityMap, depth_format

Acceleration = Literal["tiles", "hierarchy", "extents", "none"]

WAYS = {"none": rays.LIST, "extents": rays.EXTENTS, "hierarchy": rays.HIERARCHY}

SOLIDS = (Kind.CUBE, Kind.POLYHEDRON)
"""The shapes that are cut out by the planes of their faces."""

COUNTED = ("rays", "nodes visited", "extent tests", "face tests", "hits")
"""Names of the work counts, in the order of the kernels."""


@dataclass(frozen=True)
class Options:
    """How rays go through the objects.

    Attributes
    ----------
    acceleration : {"tiles", "hierarchy", "extents", "none"}
        Tiles of 16 x 16 rays through hierarchies, single rays through hierarchies, the object list
        with extents, or the plain object list.
    count : bool
        Whether work is counted, by kernels compiled for that.
    """

    acceleration: Acceleration = "tiles"
    count: bool = False

    def __post_init__(self) -> None:
        known = get_args(Acceleration)
        if self.acceleration not in known:
            raise MethodError(f"acceleration {self.acceleration!r}: choose one of {', '.join(known)}")


def render(view: View, options: Options) -> VisibilityMap:
    """Find the nearest hit of every sample's ray.

    Rays hit squares, cubes, polyhedra, spheres and cylinders in the shape's own frame, meshes
    triangle by triangle on the screen. A hit counts if ``near <= depth <= far`` and its side is not
    culled. A sample on an edge between triangles belongs to the right or lower of them (top-left
    rule); the border of a generic shape belongs to the shape. Of equal depths the lower face id wins.

    Parameters
    ----------
    view : View
    options : Options

    Returns
    -------
    VisibilityMap
        The face is the same for every acceleration and every number of threads. ``seconds`` has
        ``build`` (hierarchies; next to nothing when this process has built them before),
        ``prepare`` and ``render``.
    """
    clock = Clock()
    with clock("build"):
        shapes, tree = _shapes(view)
    with clock("prepare"):
        camera = _camera(view)
        objects, world = _objects(view)
        size = (view.height, view.width)
        image = rays.Image(np.empty(size, np.int32), np.empty(size))
        work = np.zeros((view.height, len(COUNTED)), np.int64) if options.count else None
    with clock("render"):
        if options.acceleration == "tiles":
            _cast_tiles(rays.Scene(camera, objects, shapes, tree), image, work)
        else:
            way = WAYS[options.acceleration]
            rays.cast(camera, objects, shapes, tree, world, way, image, work)
    counts = {} if work is None else dict(zip(COUNTED, work.sum(axis=0).tolist(), strict=True))
    notes = {"depth_format": depth_format("distance", 2.0**-52, view.near, view.far)}
    return VisibilityMap(*image, "raycast", counts, clock.seconds, notes)


# ---------------------------------------------------------------- shapes


class _Mesh(NamedTuple):
    """A mesh in the order of its hierarchy's leaves; see ``rays.Meshes``."""

    vertex: Floats
    corner: Ints
    face: Ints
    tree: hierarchy.Tree


_built: WeakKeyDictionary[Shape, _Mesh] = WeakKeyDictionary()


def _mesh_of(shape: Shape) -> _Mesh:
    """Build the hierarchy of a mesh, once for all its instances and views."""
    if shape not in _built:
        polygons = _polygons(shape)
        corner = np.ascontiguousarray(polygons.triangle_vertex, np.int32)
        order, tree = hierarchy.build(*hierarchy.boxes_of(polygons.vertices, corner))
        _built[shape] = _Mesh(polygons.vertices, corner[order], polygons.triangle_face[order], tree)
    return _built[shape]


def _polygons(shape: Shape) -> Polygons:
    assert shape.polygons is not None, "only spheres and cylinders have no polygons"
    return shape.polygons


def _distinct(view: View, kinds: Sequence[Kind]) -> list[Shape]:
    """Return the shapes of these kinds, each once, in order of appearance."""
    return list(dict.fromkeys(p.shape for p in view.placements if p.shape.kind in kinds))


def _shapes(view: View) -> tuple[rays.Shapes, hierarchy.Tree]:
    """Join the data of all shapes, with indices that count from the start of the joint arrays."""
    planes = [_planes_of(_polygons(shape)) for shape in _distinct(view, SOLIDS)]
    meshes = [_mesh_of(shape) for shape in _distinct(view, [Kind.MESH])]
    vertex_start = _starts([len(mesh.vertex) for mesh in meshes])
    triangle_start = _starts([len(mesh.corner) for mesh in meshes])
    node_start = _starts([len(mesh.tree.first) for mesh in meshes])
    shapes = rays.Shapes(
        _joined(planes, np.float64, 4),
        _joined([mesh.vertex for mesh in meshes], np.float64, 3),
        _joined([mesh.corner + start for mesh, start in zip(meshes, vertex_start, strict=False)], np.int32, 3),
        _joined([mesh.face for mesh in meshes], np.int32),
        _starts([len(part) for part in planes]),
        vertex_start,
        triangle_start,
        node_start,
    )
    trees = [mesh.tree for mesh in meshes]
    first = [
        tree.first + np.where(tree.count == hierarchy.INNER, node, triangle)
        for tree, node, triangle in zip(trees, node_start, triangle_start, strict=False)
    ]
    return shapes, hierarchy.Tree(
        _joined(first, np.int32),
        _joined([tree.count for tree in trees], np.int32),
        _joined([tree.low for tree in trees], np.float64, 3),
        _joined([tree.high for tree in trees], np.float64, 3),
    )


def _planes_of(polygons: Polygons) -> Floats:
    """Return ``(n, m)`` of every face: n the sum over its fan, m = n . its first corner."""
    a, b, c = (polygons.vertices[polygons.triangle_vertex[:, i]] for i in range(3))
    normal = np.zeros((len(polygons), 3))
    np.add.at(normal, polygons.triangle_polygon, np.cross(b - a, c - a))
    first = polygons.vertices[polygons.corner[polygons.start[:-1]]]
    return np.column_stack([normal, (normal * first).sum(axis=1)])


def _extent_of(shape: Shape) -> Floats:
    """Return the opposite corners (2, 3) of a shape's box in object space."""
    if shape.kind == Kind.SPHERE:
        return np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])
    if shape.kind == Kind.CYLINDER:
        return np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 1.0]])
    if shape.kind == Kind.MESH:
        tree = _mesh_of(shape).tree
        return np.stack([tree.low[0], tree.high[0]])
    vertices = _polygons(shape).vertices
    return np.stack([vertices.min(axis=0), vertices.max(axis=0)])


def _starts(sizes: Sequence[int]) -> Ints:
    return np.cumsum([0, *sizes]).astype(np.int32)


def _joined(parts: Sequence[Any], dtype: Any, width: int = 0) -> Any:
    """Concatenate arrays (n,) or (n, width), of which there may be none."""
    empty = np.empty((0, width) if width else 0, dtype)
    return np.ascontiguousarray(np.concatenate([empty, *parts]) if len(parts) != 1 else parts[0], dtype)


# ---------------------------------------------------------------- the scene as the kernels see it


def _camera(view: View) -> rays.Camera:
    near, far, perspective = view.near, view.far, view.perspective
    closest, farthest = nearness_of(near, perspective), nearness_of(far, perspective)
    return rays.Camera(perspective, near, far, closest, farthest, view.width, view.height)


def _objects(view: View) -> tuple[rays.Objects, hierarchy.Tree]:
    """Return the objects in the order of the leaves of the hierarchy over them, and that hierarchy."""
    placements = view.placements
    shapes = [placement.shape for placement in placements]
    row = {shape: k for kinds in ([Kind.MESH], SOLIDS) for k, shape in enumerate(_distinct(view, kinds))}
    extents = {shape: _extent_of(shape) for shape in set(shapes)}
    low, high = np.moveaxis(np.array([extents[shape] for shape in shapes]), 1, 0)
    matrix = np.array([placement.world_from_object for placement in placements])
    inverse = np.linalg.inv(matrix[:, :3, :3])
    screen = _screen_from_world(view) @ matrix
    margin = _margins(view, screen, matrix, inverse, np.maximum(abs(low), abs(high)))
    order, world = _hierarchy_over(matrix, low - 2.0 * margin, high + 2.0 * margin)

    sight = _sample_rays(view)
    translation = np.pad(matrix[:, :3, 3:], ((0, 0), (0, 0), (0, 2)))
    origin, direction = inverse @ (sight.origin - translation), inverse @ sight.direction
    objects = rays.Objects(
        np.array([shape.kind for shape in shapes], np.int32)[order],
        np.array([placement.first for placement in placements], np.int32)[order],
        np.array([placement.cull for placement in placements], np.int32)[order],
        np.array([row.get(shape, 0) for shape in shapes], np.int32)[order],
        np.array([placement.mirrored for placement in placements], np.bool_)[order],
        screen[order],
        np.concatenate([origin[order], sight.origin[None]]),
        np.concatenate([direction[order], sight.direction[None]]),
        np.concatenate([margin[order], np.zeros((1, 3))]),
        low[order],
        high[order],
    )
    return objects, world


def _hierarchy_over(matrix: Floats, low: Floats, high: Floats) -> tuple[Ints, hierarchy.Tree]:
    """Build the hierarchy over extents carried to world space by ``matrix`` (n, 4, 4).

    The extents come with twice the margin of their rays: once for the ray, which in world space is no
    more certain, and once for the rounding of what is computed here.
    """
    linear, centre, half = matrix[:, :3, :3], 0.5 * (low + high), 0.5 * (high - low)
    centre = (linear @ centre[:, :, None])[:, :, 0] + matrix[:, :3, 3]
    half = (abs(linear) @ half[:, :, None])[:, :, 0]
    return hierarchy.build(centre - half, centre + half)


def _sample_rays(view: View) -> Rays:
    """Return the rays as functions of (1, x, y), pixels right of and below the image centre."""
    per_pixel = [1.0, 2.0 / view.width, -2.0 / view.height]
    return Rays(view.rays.origin * per_pixel, view.rays.direction * per_pixel)


def _screen_from_world(view: View) -> Floats:
    """Return the rows (3, 4) column, row and depth; see ``bounds.corner_of``.

    Clip coordinates are divided by w; here that is depth times a constant, or a constant.
    """
    x_row, y_row, _, w_row = view.clip_from_world
    axis = np.argmax(abs(view.depth_row[:3])) if view.perspective else 3
    weight = w_row[axis] / view.depth_row[axis] if view.perspective else w_row[axis]
    return np.stack([x_row * (0.5 * view.width / weight), y_row * (-0.5 * view.height / weight), view.depth_row])


def _margins(
    view: View, screen: Floats, world_from_object: Floats, object_from_world: Floats, size: Floats
) -> Floats:
    """Bound how far (n, 3) rounding moves a line of sight, or what it meets, in object space.

    A point of a ray is ``A^-1 (e + t d - b)``: A, b the object's transform, e and d the sample's ray,
    read off the inverse C^-1 of the camera. Each of the two inverses and three products rounds every
    coordinate fewer than ten times, relative to the sum of the magnitudes of what is added. The
    magnitudes to add up are therefore |A^-1||A||A^-1| |C^-1||C| (|e| + t |d| + |b| + |A| |p|), p
    being the farthest corner of the extent and t the depth of its farthest part; the last term is for the
    vertices projected by ``screen``. Fifty roundings of 2^-53 each are less than 2^-47 of that.
    """
    linear, translation = abs(world_from_object[:, :3, :3]), abs(world_from_object[:, :3, 3])
    world = _sample_rays(view)
    inverse_camera = world.direction if view.perspective else world.direction + world.origin * [0.0, 1.0, 1.0]
    rounding = abs(inverse_camera) @ abs(np.linalg.inv(inverse_camera))
    corner = np.array([1.0, 0.5 * view.width, 0.5 * view.height])
    t = (abs(screen[:, 2, :3]) * size).sum(axis=1) + abs(screen[:, 2, 3])
    ray = abs(world.origin) @ corner + t[:, None] * (abs(world.direction) @ corner)
    reach = ray + translation + (linear @ size[:, :, None])[:, :, 0]
    inverse = abs(object_from_world)
    return 2.0**-47 * (inverse @ linear @ inverse @ rounding @ reach[:, :, None])[:, :, 0]


# ---------------------------------------------------------------- tiles

BATCH = 1 << 18
"""Triangles laid out on the screen together, or one object if it has more."""


def _cast_tiles(scene: rays.Scene, image: rays.Image, work: Array | None) -> None:
    """Cast all rays tile by tile into batches of objects, nearest first."""
    camera, objects, shapes, tree = scene
    tiles = _tiles(camera)
    reaches = raytiles.Reaches(np.empty((len(objects.kind), 4), np.int16), np.empty(len(objects.kind)))
    raytiles.reach_objects(scene, reaches)
    seen = (reaches.samples[:, 0] <= reaches.samples[:, 1]) & (reaches.samples[:, 2] <= reaches.samples[:, 3])
    order = np.argsort(-reaches.nearest, kind="stable")
    for member in _batches(order[seen[order]], scene):
        batch, grown = _batch(member, scene, reaches)
        raytiles.lay_out(camera, objects, shapes, tree, batch, grown, tiles)
        raytiles.cast_batch(camera, objects, shapes, tree, batch, grown, tiles, work)
    raytiles.read_out(camera, tiles, image)


def _tiles(camera: rays.Camera) -> raytiles.Tiles:
    """Return tiles that show nothing; samples beyond the image are as near as can be."""
    side = raytiles.SIDE
    across, down = -(-camera.width // side), -(-camera.height // side)
    nearness = np.full((down, across, side, side), camera.farthest)
    if camera.width % side:
        nearness[:, -1, :, camera.width % side :] = np.inf
    if camera.height % side:
        nearness[-1, :, camera.height % side :, :] = np.inf
    face = np.full((across * down, side * side), rays.NO_OWNER, np.int64)
    floor = np.full(across * down, camera.farthest)
    return raytiles.Tiles(nearness.reshape(face.shape), face, floor, across)


def _batches(order: Ints, scene: rays.Scene) -> Iterator[Ints]:
    """Cut the objects into runs of at most ``BATCH`` triangles, or of one object."""
    start, triangles = 0, 0
    for end, size in enumerate(_sizes(scene, scene.shapes.triangle_start)[order]):
        if end > start and triangles + size > BATCH:
            yield order[start:end]
            start, triangles = end, 0
        triangles += size
    yield order[start:]


def _sizes(scene: rays.Scene, start: Ints) -> Array:
    """Return how many vertices, nodes or triangles (n,) each object has, given where meshes begin."""
    is_mesh = scene.objects.kind == Kind.MESH
    sizes = np.zeros(len(is_mesh), np.int64)
    sizes[is_mesh] = np.diff(start)[scene.objects.shape[is_mesh]]
    return sizes


def _batch(
    member: Ints, scene: rays.Scene, reaches: raytiles.Reaches
) -> tuple[raytiles.Batch, raytiles.Reaches]:
    """Return room for a batch: its vertices, and reaches for its nodes and triangles."""
    vertices, nodes, triangles = (
        _starts(_sizes(scene, start)[member])
        for start in (scene.shapes.vertex_start, scene.shapes.node_start, scene.shapes.triangle_start)
    )
    nodes = nodes + len(reaches.nearest)
    triangles = triangles + nodes[-1]
    batch = raytiles.Batch(member, vertices[:-1], nodes[:-1], triangles[:-1], np.empty((vertices[-1], 4)))
    samples, nearest = np.empty((triangles[-1], 4), np.int16), np.empty(triangles[-1])
    samples[: len(reaches.samples)], nearest[: len(reaches.nearest)] = reaches
    return batch, raytiles.Reaches(samples, nearest)
