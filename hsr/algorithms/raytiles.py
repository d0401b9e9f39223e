"""Ray casting by coherent tiles of rays, certified.

The rays of a tile of the image go together through hierarchies that are refitted to the screen
(:mod:`hsr.kernels.raytiles`), and meet triangles by the tests of the depth buffer, spheres and cylinders as
quadrics on the screen (:mod:`hsr.kernels.curved`). Squares, cubes and polyhedra are met face by face, as the
fans of triangles that their polygons mean. Every decision that rounding might turn is noted instead of
taken, and taken afterwards in exact arithmetic (:mod:`hsr.algorithms.resolve`). So the face of every sample
is the true one, ties included, curved shapes too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from hsr.algorithms.curved import quadrics_of
from hsr.algorithms.loose import loose_tables, loose_triangles
from hsr.algorithms.resolve import Resolved, first_pieces, resolve
from hsr.algorithms.tiles import eye_between, format_of
from hsr.arrays import Array, Floats, Ints
from hsr.jit import one_by_one
from hsr.kernels import doubts, hierarchy, raytiles
from hsr.kernels.doubts import Window
from hsr.kernels.halfspaces import CLUSTER, ERROR, LANES, LOOSE, Eye, U
from hsr.kernels.projection import clip_rows, to_clip
from hsr.kernels.raytiles import CELLS, MEMBER, NO_QUADRIC, SHARE, SIDE
from hsr.kernels.tiles import deal
from hsr.scene.shapes import Kind, Shape
from hsr.viewing import Placement, View, reversed_loops
from hsr.visibility import Clock, VisibilityMap

LEAF = CLUSTER
"""Most triangles in a leaf: as many as are set up side by side."""

BATCH = 1 << 18
"""Vertices and nodes laid out on the screen together, or those of one object if it has more."""

SHARE_OF_VERTICES, SHARE_OF_NODES = 2048, 64
"""What one thread lays out at a time."""

ROOM = 64
"""Doubts of a tile for which there is room at first; a tile with more is cast again."""


def render(view: View, certified: bool) -> VisibilityMap:
    """Find what the ray of every sample meets first, tile by tile; see :func:`hsr.algorithms.raycast.render`.

    Parameters
    ----------
    view : View
    certified : bool
        Whether what float64 leaves in doubt is decided exactly.
    """
    clock = Clock()
    with clock("build"):
        meshes = {kind: mesh_of(*kind) for kind in map(_kind, view.placements)}
    with clock("prepare"):
        world = _world(view, meshes)
        room, picture = _room(world.members), _picture(view)
    with clock("render"):
        rows = clip_matrices(view)
        eye = eye_of(view, world, rows)
        mask = int(doubts.depth_mask(len(world.faces)))
        window = Window(0, 0, view.width, mask, int(doubts.gap_of(mask, eye.tie)))
        found, counts = _cast(view, world, rows, eye, window, room, picture, certified)
        resolved = _resolved(view, found, picture.keys, window)
        picture.face.ravel()[resolved.sample] = resolved.face
        picture.depth.ravel()[resolved.sample] = resolved.depth
    work = {
        "rays": view.width * view.height,
        "nodes visited": int(counts[raytiles.NODES]),
        "extent tests": int(counts[raytiles.EXTENTS]),
        "face tests": int(counts[doubts.TRIANGLES]),
        "uncertain": len(resolved.sample),
    }
    notes = {"depth_format": format_of(view, len(world.faces), eye)}
    return VisibilityMap(picture.face, picture.depth, "raycast", work, clock.seconds, notes)


# ---------------------------------------------------------------- once a shape


class Mesh(NamedTuple):
    """A shape of planar faces as triangles, in the order of the leaves of its hierarchy; else nothing.

    Attributes
    ----------
    vertices : (V, 3) float64, object space
    corner : (n, 3) int32
        Counter-clockwise to the eye if seen from the front.
    number : (n,) int32
        Number of each triangle among the fans of the polygons.
    tree : (N, 2) int32
        ``first`` and ``count`` of the nodes, see :data:`hsr.kernels.hierarchy.NODE`.
    box : (2, 3) float64
        Opposite corners of the box around the shape, whatever it is.
    """

    vertices: Floats
    corner: Ints
    number: Ints
    tree: Ints
    box: Floats


MeshKind = tuple[Shape, bool]
"""A shape, and whether its object is mirrored: the fans of its polygons then run the other way round."""

_meshes: WeakKeyDictionary[Shape, dict[bool, Mesh]] = WeakKeyDictionary()


def mesh_of(shape: Shape, mirrored: bool) -> Mesh:
    """Build the hierarchy of a shape, once for all its instances and views."""
    if shape.polygons is None:
        nothing = (np.empty((0, 3), np.int32), np.empty(0, np.int32), np.empty((0, 2), np.int32))
        return Mesh(np.empty((0, 3)), *nothing, box_of(shape))
    built = _meshes.setdefault(shape, {})
    if mirrored not in built:
        polygons, box = shape.polygons, box_of(shape)
        if mirrored:
            polygons = replace(polygons, corner=reversed_loops(polygons))
        number, tree = hierarchy.tree_of(polygons.vertices, polygons.triangle_vertex, box, LEAF)
        corner = np.take(polygons.triangle_vertex, number, axis=0)
        built[mirrored] = Mesh(polygons.vertices, corner, number, tree, box)
    return built[mirrored]


def _kind(placement: Placement) -> MeshKind:
    return placement.shape, placement.mirrored


BOXES = {
    Kind.SPHERE: np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]),
    Kind.CYLINDER: np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 1.0]]),
}


def box_of(shape: Shape) -> Floats:
    """Return the opposite corners (2, 3) of the box around a shape, object space."""
    if shape.polygons is None:
        return BOXES[shape.kind]
    return hierarchy.box_of(shape.polygons.vertices)


# ---------------------------------------------------------------- once a view


class World(NamedTuple):
    """The objects of a view.

    Attributes
    ----------
    shapes : Shapes
        The data of all meshes, one after the other.
    members : (n,) MEMBER
        The objects, with no place on the screen yet.
    box : (n, 2, 3) float64
        Opposite corners of the boxes around them, object space.
    faces : (pieces,) int32
        Face of each piece, see :func:`hsr.algorithms.resolve.first_pieces`.
    """

    shapes: raytiles.Shapes
    members: Array
    box: Floats
    faces: Ints


def _world(view: View, meshes: dict[MeshKind, Mesh]) -> World:
    """Join the data of all meshes, and say of each object where its own is."""
    sizes = np.array([[len(mesh.vertices), len(mesh.corner), len(mesh.tree)] for mesh in meshes.values()])
    described = np.zeros(len(meshes), MEMBER)
    described["vertices"], described["triangles"], described["nodes"] = sizes.T
    described["vertex"], described["triangle"], described["node"] = (np.cumsum(sizes, axis=0) - sizes).T

    place = {kind: k for k, kind in enumerate(meshes)}
    which = [place[_kind(placement)] for placement in view.placements]
    members = described[which]
    members["object"] = np.arange(len(members))
    members["cull"] = [placement.cull for placement in view.placements]
    members["piece"] = first_pieces(view)[:-1]
    members["quadric"] = NO_QUADRIC
    *shapes, boxes = zip(*meshes.values(), strict=True)
    vertices, corner, number, tree = (_joined(parts) for parts in shapes)
    return World((vertices, corner, number, tree), members, np.array(boxes)[which], _faces(view))


def _joined(parts: Sequence[Array]) -> Array:
    """Concatenate arrays; a single one is not copied."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _faces(view: View) -> Ints:
    """Return the face of each piece."""
    own = {placement.shape: _faces_of(placement.shape) for placement in view.placements}
    return np.concatenate([own[placement.shape] + np.int32(placement.first) for placement in view.placements])


def _faces_of(shape: Shape) -> Ints:
    if shape.polygons is None:
        return np.arange(shape.faces, dtype=np.int32)
    return shape.polygons.triangle_face


class Picture(NamedTuple):
    """The answer, and the keys of the tiles (rows, columns) that become it.

    Attributes
    ----------
    keys : (rows, columns, SIDE, SIDE + LANES) int64
    farthest : (rows, columns, CELLS, CELLS) float64
        The farthest key depth in each cell, infinite where some sample is empty.
    face : (H, W) int32
    depth : (H, W) float64
    """

    keys: Array
    farthest: Floats
    face: Ints
    depth: Floats


def _picture(view: View) -> Picture:
    """Make room for the answer; samples beyond the image hide everything.

    The memory is touched now: the first touch of a page takes longer than what is computed in it.
    """
    rows, columns = -(-view.height // SIDE), -(-view.width // SIDE)
    keys = np.full((rows, columns, SIDE, SIDE + LANES), doubts.EMPTY, np.int64)
    keys[-1, :, view.height - (rows - 1) * SIDE :] = 0
    keys[:, -1, :, view.width - (columns - 1) * SIDE :] = 0
    size = (view.height, view.width)
    farthest = np.full((rows, columns, CELLS, CELLS), np.inf)
    return Picture(keys, farthest, np.full(size, -1, np.int32), np.full(size, np.inf))


Room = tuple[Floats, Floats]
"""Room for the projected vertices (v, 4) and the extents of the nodes (e, 5) of any batch."""


def _room(members: Array) -> Room:
    vertices, nodes = (
        min(int(sizes.sum()), max(BATCH, int(sizes.max())))
        for sizes in (members["vertices"], members["nodes"])
    )
    return np.full((vertices, 4), 0.0), np.full((nodes, 5), 0.0)


def clip_matrices(view: View) -> Floats:
    """Return the matrices (n, 3, 4) that carry the objects' points (x, y, z, 1) to clip space (x, y, d)."""
    matrices = np.array([placement.world_from_object for placement in view.placements])
    return np.asarray(clip_rows(view.clip_from_world, view.depth_row) @ matrices)


def eye_of(view: View, world: World, rows: Floats) -> Eye:
    """Measure a view for the kernels.

    An entry of a matrix is a sum of at most four products, by rows that were divided once; a clip coordinate
    is a sum of three products and an offset, and depth is taken for w: fewer than sixteen roundings, each of
    at most the sum of the magnitudes.
    """
    matrices = abs(np.array([placement.world_from_object for placement in view.placements]))
    farthest = abs(world.box).max(axis=1)
    reach = (matrices[:, :3, :3] @ farthest[:, :, None])[:, :, 0] + matrices[:, :3, 3]
    clip = abs(clip_rows(view.clip_from_world, view.depth_row))
    size = reach @ clip[:, :3].T + clip[:, 3]
    least, most = _depths(world, rows)
    return eye_between(view, 16.0 * U * size.max(axis=0), least.min(), most.max())


def _depths(world: World, rows: Floats) -> tuple[Floats, Floats]:
    """Return the least and the greatest depth (n,) of the objects' boxes."""
    ends = rows[:, None, 2, :3] * world.box
    offset = rows[:, 2, 3]
    return offset + ends.min(axis=1).sum(axis=1), offset + ends.max(axis=1).sum(axis=1)


# ---------------------------------------------------------------- all rays


def _cast(
    view: View,
    world: World,
    rows: Floats,
    eye: Eye,
    window: Window,
    room: Room,
    picture: Picture,
    certified: bool,
) -> tuple[Array, Array]:
    """Cast all rays into batches of objects, nearest first; return the doubts (m,) and the counts."""
    extent = np.empty((len(rows), 5))
    raytiles.reach_objects(world.box, rows, eye, extent)
    least, most = _depths(world, rows)
    seen = (extent[:, 0] < extent[:, 1]) & (extent[:, 2] < extent[:, 3])
    seen &= (most >= view.near - eye.error_d) & (least <= view.far + eye.error_d)
    curved = np.flatnonzero(seen & (world.members["nodes"] == 0))
    world.members["quadric"][curved] = np.arange(len(curved))
    quadrics = quadrics_of(view, curved, world.members["piece"][curved], extent[curved, :4], eye)

    found, total = [np.empty(0, doubts.DOUBT)], np.zeros(raytiles.COUNTS, np.int64)
    order = np.argsort(extent[:, 4], kind="stable")
    for chosen in _batches(order[seen[order]], world.members):
        chosen = chosen[raytiles.may_show(extent[chosen], eye, picture.farthest)]
        laid = _laid(world.members[chosen], extent[chosen], room)
        shares = _shares(laid[0]["vertices"], SHARE_OF_VERTICES), _shares(laid[0]["nodes"], SHARE_OF_NODES)
        raytiles.lay_out(world.shapes, rows, eye, *shares, laid)
        loose = _loose(view, world, rows, eye, laid)
        batch = Batch(world.shapes, laid, (quadrics, loose), world.faces)
        for one, counts in _cast_batch(batch, eye, window, picture, certified):
            found.append(one)
            total += counts
    return np.concatenate(found), total


def _batches(order: Array, members: Array) -> Iterator[Array]:
    """Cut the objects into runs of at most ``BATCH`` vertices and nodes, or of one object."""
    start, laid = 0, 0
    for end, size in enumerate(members["vertices"][order] + members["nodes"][order]):
        if end > start and laid + size > BATCH:
            yield order[start:end]
            start, laid = end, 0
        laid += size
    yield order[start:]


def _laid(members: Array, extent: Floats, room: Room) -> raytiles.Laid:
    """Give the members of a batch their places on the screen."""
    for place, size in (("to_screen", "vertices"), ("to_extent", "nodes")):
        members[place] = np.cumsum(members[size]) - members[size]
    screen, nodes = room
    return members, extent, screen[: members["vertices"].sum()], nodes[: members["nodes"].sum()]


def _shares(sizes: Array, most: int) -> Array:
    """Cut what each member has into shares of at most ``most``."""
    parts = -(-sizes // most)
    shares = np.empty(parts.sum(), SHARE)
    shares["member"] = np.repeat(np.arange(len(sizes)), parts)
    shares["start"] = most * (np.arange(len(shares)) - np.repeat(np.cumsum(parts) - parts, parts))
    shares["end"] = np.minimum(shares["start"] + most, sizes[shares["member"]])
    return shares


def _loose(view: View, world: World, rows: Floats, eye: Eye, laid: raytiles.Laid) -> Floats:
    """Set up the triangles of a batch of which a corner is not certain."""
    members, _, screen, _ = laid
    uncertain = np.flatnonzero(~(screen[:, ERROR] <= LOOSE))
    clip, pieces = [np.empty((0, 3, 3))], [np.empty(0, np.int64)]
    for member in members[np.unique(np.searchsorted(members["to_screen"], uncertain, "right") - 1)]:
        vertices, corner, number = _own(world, member)
        projected = screen[member["to_screen"] :][: len(vertices)]
        chosen = loose_triangles(projected, corner, eye)
        clip.append(to_clip(vertices[corner[chosen].ravel()], rows[member["object"]]).reshape(-1, 3, 3))
        pieces.append(member["piece"] + number[chosen])
    piece = np.concatenate(pieces)
    return loose_tables(view, np.concatenate(clip), piece.astype(np.int32), piece, eye)


def _own(world: World, member: Array) -> tuple[Floats, Ints, Ints]:
    """Return the vertices, corners and numbers of a member's triangles."""
    vertices, corner, number, _ = world.shapes
    vertex = slice(member["vertex"], member["vertex"] + member["vertices"])
    triangle = slice(member["triangle"], member["triangle"] + member["triangles"])
    return vertices[vertex], corner[triangle], number[triangle]


class Batch(NamedTuple):
    """Objects laid out on the screen; see :func:`hsr.kernels.raytiles.cast`."""

    shapes: raytiles.Shapes
    laid: raytiles.Laid
    special: tuple[Array, Floats]
    faces: Ints


def _cast_batch(
    batch: Batch, eye: Eye, window: Window, picture: Picture, certified: bool
) -> Iterator[tuple[Array, Array]]:
    """Cast all rays into a batch; yield doubts and counts of tiles."""
    listed, todo = _todo(batch, picture)
    tiles, room = (picture.keys, picture.farthest, batch.faces, picture.face, picture.depth), ROOM
    while len(todo):
        counts = np.zeros((len(todo), raytiles.COUNTS), np.int64)
        noted = np.empty((len(todo), room), doubts.DOUBT) if certified else None
        with one_by_one():
            raytiles.cast(
                batch.shapes, batch.laid, batch.special, listed, todo, eye, window, tiles, noted, counts
            )
        used = counts[:, doubts.USED]
        done = used <= room
        parts = [] if noted is None else [noted[k, : used[k]] for k in np.flatnonzero(done & (used > 0))]
        yield np.concatenate([np.empty(0, doubts.DOUBT), *parts]), counts[done].sum(axis=0)
        todo, room = todo[~done], int(used.max())


def _todo(batch: Batch, picture: Picture) -> tuple[Ints, Array]:
    """List the members that each tile may see, nearest first; and the tiles that may see any.

    They come scattered over the image, so that threads that take equal parts have about equal work.
    """
    extent, (_, loose) = batch.laid[1], batch.special
    size = (picture.face.shape[1], len(picture.face))
    listed, todo = deal(extent, np.arange(len(extent)), size, (SIDE, SIDE))
    return listed, todo[(len(loose) > 0) | (todo[:, 2] < todo[:, 3])]


# ---------------------------------------------------------------- what is in doubt


def _resolved(view: View, found: Array, keys: Array, window: Window) -> Resolved:
    """Decide the doubts that are not certainly hidden by now, among them and what the keys show."""
    row, column = np.divmod(found["sample"], view.width)
    shown = keys[row // SIDE, column // SIDE, row % SIDE, column % SIDE]
    there = shown != doubts.EMPTY
    left = np.flatnonzero(~there | (found["key"] <= np.where(there, shown, 0) + window.gap))
    found, shown, there = found[left], shown[left], there[left]
    sample, first = np.unique(found["sample"], return_index=True)
    first = first[there[first]]
    sample = np.concatenate([found["sample"], found["sample"][first]])
    key = np.concatenate([found["key"], shown[first]])
    sure = np.concatenate([found["sure"], np.ones(len(first), np.bool_)])
    return resolve(view, sample, np.asarray(key & ~window.mask), sure)
