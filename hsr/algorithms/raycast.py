"""Ray casting: one ray a sample, and of all it meets the nearest.

Four ways to go through the objects: the plain list of the textbook, the list with an extent around every
object, hierarchies of extents for single rays, and coherent tiles of rays. The first three are rounded, and
give one answer; tiles are certified, and give the true one (:mod:`hsr.algorithms.prepare.ray_tiles`).

Single rays can be studied besides: with the triangle tests of the literature in place of that on the
screen, in float32, and with extents that take no care of rounding. Those do not all answer the same.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hsr.algorithms.prepare import choices, ray_tiles
from hsr.base.arrays import Array, Floats, Ints
from hsr.base.errors import MethodError
from hsr.kernels import hierarchy, ray_hierarchy, rays, triangle_tests
from hsr.kernels.projection import nearness_of
from hsr.kernels.ray_objects import OBJECT, TRIANGLE, Camera, Data
from hsr.problem.geometry import Geometry, as_float32
from hsr.problem.map import Clock, VisibilityMap, depth_format
from hsr.problem.view import Rays, View
from hsr.scene.shapes import Kind, Polygons, Shape

WAYS = {"hierarchy": ray_hierarchy.HIERARCHY, "extents": ray_hierarchy.EXTENTS, "none": ray_hierarchy.LIST}

TESTS = {
    "screen": triangle_tests.SCREEN,
    "edge-planes": triangle_tests.EDGE_PLANES,
    "moller-trumbore": triangle_tests.MOLLER_TRUMBORE,
    "woop": triangle_tests.WOOP,
}

CHOICES = {
    "acceleration": ("tiles", *WAYS),
    "test": TESTS,
    "arithmetic": ("float64", "float32"),
    "slabs": ("robust", "naive"),
}
"""What each option may be."""

SOLIDS = (Kind.CUBE, Kind.POLYHEDRON, Kind.QUADRIC)
"""The shapes that are cut out by planes, and by an equation."""

COUNTED = ("nodes visited", "extent tests", "face tests", "hits")
"""Names of the work counts, in the order of the kernels."""


@dataclass(frozen=True)
class Options:
    """How rays go through the objects, and how they meet them.

    Attributes
    ----------
    acceleration : {"tiles", "hierarchy", "extents", "none"}
        Tiles of 64 x 64 rays through hierarchies, single rays through hierarchies, the object list
        with extents, or the plain object list.
    certified : bool
        Whether what float64 leaves in doubt is decided exactly, with tiles. Otherwise it goes to the side it
        seems to be on: what certification costs is the difference in time.
    count : bool
        Whether the work of single rays is counted, by kernels compiled for that; that of tiles always is.
    test : {"screen", "edge-planes", "moller-trumbore", "woop"}
        How single rays meet the triangles of meshes: projected to the screen, or in object space by one of
        the tests of :mod:`hsr.kernels.triangle_tests`.
    arithmetic : {"float64", "float32"}
        Of the rays, planes and vertices in object space, and of the tests there.
    slabs : {"robust", "naive"}
        How single rays meet extents.
    """

    acceleration: str = "tiles"
    certified: bool = True
    count: bool = False
    test: str = "screen"
    arithmetic: str = "float64"
    slabs: str = "robust"

    def __post_init__(self) -> None:
        choices.check("raycast", self, CHOICES)
        studied = (self.test, self.arithmetic, self.slabs) != ("screen", "float64", "robust")
        if self.acceleration == "tiles" and studied:
            raise MethodError(
                "tiles test triangles on the screen, in float64, through robust slabs; "
                "for other tests, arithmetic or slabs choose acceleration 'hierarchy'"
            )
        if self.acceleration != "tiles" and not self.certified:
            raise MethodError("single rays are never certified; leave certified out, or choose tiles")
        if self.test == "screen" and self.arithmetic == "float32":
            raise MethodError("the test on the screen is in float64 only; choose another test for float32")
        if self.acceleration == "none" and self.slabs == "naive":
            raise MethodError("the plain list has no extents for naive slabs; choose acceleration 'extents'")


def render(view: View, options: Options) -> VisibilityMap:
    """Find the nearest hit of every sample's ray.

    A hit counts if ``near <= depth <= far`` and its side is not culled.

    Tiles: the face is that of the limit from the right and below, whatever the rounding.

    Single rays hit squares, cubes, polyhedra, spheres and cylinders in the shape's own frame, meshes
    triangle by triangle on the screen. A sample on an edge between triangles belongs to the right or lower of
    them (top-left rule), with the tests in object space to both; the border of a generic shape belongs to the
    shape. Of equal depths the lower face id wins.

    Parameters
    ----------
    view : View
    options : Options

    Returns
    -------
    VisibilityMap
        Of certified tiles, ``face`` is exact; ``depth`` is correctly rounded where it was decided exactly,
        and elsewhere its inverse (under perspective; in a parallel view it itself) is within 2^-35 of the
        range of what is seen, or what its vertices' rounding makes of it if that is more. Of single rays,
        the face is the same for every acceleration (tested on the screen, with robust slabs). Neither
        depends on the number of threads.

        ``seconds``: ``build`` (hierarchies, once a scene), ``prepare`` and ``render``. ``work`` of tiles:
        ``rays``; ``nodes visited``, ``extent tests`` of objects and ``face tests``, each once for every tile;
        ``uncertain`` samples, which were decided exactly. Of single rays, if counted: ``rays``,
        ``nodes visited``, ``extent tests``, ``face tests`` and ``hits``.

    Raises
    ------
    MethodError
        If a coordinate is beyond float32, and that is the arithmetic.
    """
    if options.acceleration == "tiles":
        return ray_tiles.render(view, options.certified)
    clock = Clock()
    with clock("build"):
        shapes = _shapes(view)
    with clock("prepare"):
        camera, data = _camera(view), _data(view, shapes, options)
        size = (view.height, view.width)
        face, depth = np.empty(size, np.int32), np.empty(size)
        work = np.zeros((view.height, len(COUNTED)), np.int64) if options.count else None
    with clock("render"):
        if options.acceleration == "none" and work is None:
            rays.cast(camera, data, TESTS[options.test], face, depth)
        else:
            ray_hierarchy.cast_through_extents(camera, data, _way(options), face, depth, work)
    counts: dict[str, int] = {}
    if work is not None:
        counts = {"rays": face.size} | dict(zip(COUNTED, work.sum(axis=0).tolist(), strict=True))
    step = float(np.finfo(options.arithmetic).eps)
    notes = {"depth_format": depth_format("distance", step, view.near, view.far)}
    return VisibilityMap(face, depth, "raycast", counts, clock.seconds, notes)


# ---------------------------------------------------------------- asked about single things


def screen_matrices(view: View) -> Floats:
    """Return the rows column, row and depth (n, 3, 4) that project each object; see ``corner_of``."""
    return np.asarray(_objects(view, _shapes(view))["screen"])


def cast_by_list(view: View, options: Options, samples: Array) -> Ints:
    """Find the face of single samples by the plain object list.

    Parameters
    ----------
    view : View
    options : Options
        The test and its arithmetic count.
    samples : (n,) int
        Numbers ``row * W + column``.

    Returns
    -------
    (n,) int32
        Face ids, -1 for the background.
    """
    plain = replace(options, acceleration="none", certified=True, slabs="robust")  # no tiles, no doubts
    camera, data, test = _camera(view), _data(view, _shapes(view), plain), TESTS[plain.test]
    face = np.empty(len(samples), np.int32)
    for k, (row, column) in enumerate(zip(*np.divmod(samples, view.width), strict=True)):
        x, y = column + 0.5 - 0.5 * view.width, row + 0.5 - 0.5 * view.height
        face[k], _ = rays.answer_of(rays.nearest_hit(x, y, camera, data, test), camera.perspective)
    return face


# ---------------------------------------------------------------- shapes


def _polygons(shape: Shape) -> Polygons:
    assert shape.polygons is not None, "only spheres and cylinders have no polygons"
    return shape.polygons


class _Shapes(NamedTuple):
    """The data of all shapes of a scene, and its objects.

    Attributes
    ----------
    planes, vertices, triangles, nodes
        As for ``rays.cast``.
    objects : (n,) OBJECT
        In file order, without what depends on the camera.
    inverse : (n, 3, 3) float64
        Of the linear parts of their matrices.
    """

    planes: Floats
    vertices: Floats
    triangles: Array
    nodes: Array
    objects: Array
    inverse: Floats


def _shapes(view: View) -> _Shapes:
    """Return the data of all shapes, made once a scene."""
    return view.geometry.once("raycast shapes", lambda: _joined_shapes(view.geometry))


def _joined_shapes(geometry: Geometry) -> _Shapes:
    """Join the data of all shapes, with indices that count from the start of the joint arrays."""
    planes, vertices = [np.empty((0, 4))], [np.empty((0, 3))]
    triangles, nodes = [np.empty(0, TRIANGLE)], [np.empty(0, hierarchy.NODE)]
    described = {}
    for shape in dict.fromkeys(one.shape for one in geometry):
        thing = described[shape] = np.zeros((), OBJECT)
        own = triangles if shape.kind == Kind.MESH else planes
        thing["kind"], thing["faces"] = shape.kind, shape.faces
        thing["start"], thing["root"] = _rows(own), _rows(nodes)
        if shape.kind == Kind.MESH:
            mesh, below = _mesh_of(_polygons(shape), _rows(vertices), _rows(triangles), _rows(nodes))
            vertices.append(_polygons(shape).vertices)
            triangles.append(mesh)
            nodes.append(below)
            thing["low"], thing["high"] = below[0]["low"], below[0]["high"]
        else:
            thing["low"], thing["high"] = ray_tiles.box_of(shape)
        if shape.kind in SOLIDS:
            planes.append(_rows_of(shape))
        thing["end"] = _rows(own)
    objects = np.array([described[one.shape] for one in geometry])
    objects["first_face"] = [one.first for one in geometry]
    objects["cull"] = [one.cull for one in geometry]
    objects["mirrored"] = [one.mirrored for one in geometry]
    inverse = np.asarray(np.linalg.inv(geometry.matrices[:, :3, :3]), np.float64)
    joint = np.concatenate(planes), np.concatenate(vertices), np.concatenate(triangles), np.concatenate(nodes)
    return _Shapes(*joint, objects, inverse)


def _rows(parts: list[Array]) -> int:
    return sum(map(len, parts))


def _mesh_of(polygons: Polygons, vertex: int, triangle: int, node: int) -> tuple[Array, Array]:
    """Return the triangles of a mesh in the order of its hierarchy's leaves, and the nodes.

    Their indices count from these vertex, triangle and node on.
    """
    corner = np.ascontiguousarray(polygons.triangle_vertex, np.int32)
    order, nodes = hierarchy.build(*hierarchy.boxes_of(polygons.vertices, corner))
    nodes["first"] += np.where(nodes["count"] == hierarchy.INNER, node, triangle).astype(np.int32)
    triangles = np.empty(len(corner), TRIANGLE)
    triangles["corner"], triangles["face"] = corner[order] + vertex, polygons.triangle_face[order]
    return triangles, nodes


def _rows_of(shape: Shape) -> Floats:
    """Return the planes (n, m) that cut out a solid, behind the four rows of its equation if it has one."""
    if shape.quadric is None:
        return _planes_of(_polygons(shape))
    outward = shape.quadric.ends.astype(np.float64) * [-1.0, -1.0, -1.0, 1.0]
    return np.vstack([shape.quadric.rounded, outward])


def _planes_of(polygons: Polygons) -> Floats:
    """Return ``(n, m)`` of every face: n the sum over its fan, m = n . its first corner."""
    a, b, c = (polygons.vertices[polygons.triangle_vertex[:, i]] for i in range(3))
    normal = np.zeros((len(polygons), 3))
    np.add.at(normal, polygons.triangle_polygon, np.cross(b - a, c - a))
    first = polygons.vertices[polygons.corner[polygons.start[:-1]]]
    return np.column_stack([normal, (normal * first).sum(axis=1)])


# ---------------------------------------------------------------- the view as the kernels see it


def _camera(view: View) -> Camera:
    near, far, perspective = view.near, view.far, view.perspective
    closest, farthest = nearness_of(near, perspective), nearness_of(far, perspective)
    return Camera(perspective, near, far, closest, farthest, view.width, view.height)


def _way(options: Options) -> ray_hierarchy.Way:
    return ray_hierarchy.Way(WAYS[options.acceleration], TESTS[options.test], options.slabs == "robust")


COARSER = 2.0**29
"""How many times as coarse float32 rounds as float64."""


def _data(view: View, shapes: _Shapes, options: Options) -> Data:
    """Return what rays are cast into, in the arithmetic and the order that the options want."""
    objects, planes, vertices, nodes = _objects(view, shapes), shapes.planes, shapes.vertices, shapes.nodes
    if options.arithmetic == "float32":
        planes, vertices = (as_float32(part, "raycast", "choose float64") for part in (planes, vertices))
        objects["margin"] *= COARSER
    if options.acceleration == "hierarchy":
        objects, nodes = _with_world(view, objects, nodes)
    return Data(objects, planes, vertices, shapes.triangles, nodes)


def _objects(view: View, shapes: _Shapes) -> Array:
    """Return the objects (n,) in file order, as the camera sees them."""
    objects, matrix, inverse = shapes.objects.copy(), view.geometry.matrices, shapes.inverse
    sight = _sample_rays(view)
    translation = np.pad(matrix[:, :3, 3:], ((0, 0), (0, 0), (0, 2)))
    objects["screen"] = _screen_from_world(view) @ matrix
    objects["origin"] = inverse @ (sight.origin - translation)
    objects["direction"] = inverse @ sight.direction
    objects["margin"] = _margins(view, objects, matrix, inverse)
    return objects


def _with_world(view: View, objects: Array, nodes: Array) -> tuple[Array, Array]:
    """Put the objects in the order of the hierarchy over them, the world at their end.

    The hierarchy's nodes follow the others.
    """
    order, own = hierarchy.build(*_world_extents(view, objects))
    own["first"] += np.where(own["count"] == hierarchy.INNER, len(nodes), 0).astype(np.int32)
    world = np.zeros(1, OBJECT)
    sight = _sample_rays(view)
    world["root"] = len(nodes)
    world["origin"], world["direction"] = sight.origin, sight.direction
    return np.concatenate([objects[order], world]), np.concatenate([nodes, own])


def _world_extents(view: View, objects: Array) -> tuple[Floats, Floats]:
    """Return the boxes (n, 3), low and high, around the extents of all objects in world space.

    They hold twice the margin: once for the ray, which in world space is no more certain, and once for
    the rounding of what is computed here.
    """
    matrix = view.geometry.matrices
    low, high = objects["low"] - 2.0 * objects["margin"], objects["high"] + 2.0 * objects["margin"]
    linear, centre, half = matrix[:, :3, :3], 0.5 * (low + high), 0.5 * (high - low)
    centre = (linear @ centre[:, :, None])[:, :, 0] + matrix[:, :3, 3]
    half = (abs(linear) @ half[:, :, None])[:, :, 0]
    return centre - half, centre + half


def _sample_rays(view: View) -> Rays:
    """Return the rays as functions of (1, x, y), pixels right of and below the image centre."""
    per_pixel = np.array([1.0, 2.0 / view.width, -2.0 / view.height])
    return Rays(view.rays.origin * per_pixel, view.rays.direction * per_pixel)


def _screen_from_world(view: View) -> Floats:
    """Return the rows (3, 4) column, row and depth; see :func:`hsr.kernels.triangle_on_screen.corner_of`.

    Clip coordinates are divided by w; here that is depth times a constant, or a constant.
    """
    x_row, y_row, _, w_row = view.clip_from_world
    axis = np.argmax(abs(view.depth_row[:3])) if view.perspective else 3
    weight = w_row[axis] / view.depth_row[axis] if view.perspective else w_row[axis]
    column, row = 0.5 * view.width / weight, -0.5 * view.height / weight
    return np.stack([x_row * column, y_row * row, view.depth_row])


def _margins(view: View, objects: Array, matrix: Floats, inverse: Floats) -> Floats:
    """Bound how far (n, 3) rounding moves a line of sight, or what it meets, in object space.

    A point of a ray is ``A^-1 (e + t d - b)``: A, b the object's transform, e and d the sample's ray,
    read off the inverse C^-1 of the camera. Each of the two inverses and three products rounds every
    coordinate fewer than ten times, relative to the sum of the magnitudes of what is added. The
    magnitudes to add up are therefore |A^-1||A||A^-1| |C^-1||C| (|e| + t |d| + |b| + |A| |p|), p being
    the farthest corner of the extent and t its depth; the last term is for the vertices that are
    projected to the screen. Fifty roundings of 2^-53 each are less than 2^-47 of that.
    """
    linear, translation, inverse = abs(matrix[:, :3, :3]), abs(matrix[:, :3, 3]), abs(inverse)
    sight = _sample_rays(view)
    frame = sight.direction if view.perspective else sight.direction + sight.origin * [0.0, 1.0, 1.0]
    rounding = abs(frame) @ abs(np.linalg.inv(frame))
    farthest = np.maximum(abs(objects["low"]), abs(objects["high"]))
    depth = abs(objects["screen"][:, 2])
    t = (depth[:, :3] * farthest).sum(axis=1) + depth[:, 3]
    border = np.array([1.0, 0.5 * view.width, 0.5 * view.height])
    ray = abs(sight.origin) @ border + t[:, None] * (abs(sight.direction) @ border)
    reach = ray + translation + (linear @ farthest[:, :, None])[:, :, 0]
    return np.asarray(2.0**-47 * (inverse @ linear @ inverse @ rounding @ reach[:, :, None])[:, :, 0])
