"""Ray casting by coherent tiles of rays, certified.

The rays of a tile of the image go together through hierarchies that are refitted to the screen
(:mod:`hsr.kernels.raytiles.casting`), and meet triangles by the tests of the depth buffer, spheres and
cylinders as quadrics on the screen (:mod:`hsr.kernels.raytiles.curved`). Squares, cubes and polyhedra are met
face by face, as the fans of triangles that their polygons mean; single rays cut them by half-spaces
(:mod:`hsr.kernels.hits`). Every decision that rounding might turn is noted instead of taken, and taken
afterwards in exact arithmetic (:mod:`hsr.certify`). So the face of every sample is the true one, ties
included, curved shapes too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple, cast

import numpy as np

from hsr.algorithms.prepare.behind_eye import crossing_tables, crossing_triangles
from hsr.algorithms.prepare.doubts import NO_DOUBTS, decide, filled, format_of, numbers_of
from hsr.algorithms.prepare.quadrics import quadrics_of
from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.base.jit import thread_count
from hsr.certify import first_pieces
from hsr.kernels import hierarchy
from hsr.kernels.projection import clip_rows, to_clip
from hsr.kernels.raytiles import casting
from hsr.kernels.raytiles.casting import MEMBER, NO_QUADRIC, SHARE
from hsr.kernels.zbuffer import fill
from hsr.kernels.zbuffer.fill import CELL, COLUMNS, LINES
from hsr.kernels.zbuffer.setup import CLUSTER, ERROR, LANES, PRECISE, SIDE_BY_SIDE, SMALL, Eye, U, eye_between
from hsr.kernels.zbuffer.tiles import deal
from hsr.problem.geometry import Geometry, Placement, reversed_loops
from hsr.problem.map import Clock, VisibilityMap
from hsr.problem.view import View
from hsr.scene.shapes import Polygons, Shape

LEAF = CLUSTER
"""Most triangles in a leaf: as many as are set up side by side."""

BATCH = 1 << 18
"""Vertices and nodes laid out on the screen together, or those of one object if it has more."""

SHARE_OF_VERTICES, SHARE_OF_NODES = SIDE_BY_SIDE, 64
"""What one thread lays out at a time."""

ROOM = 256
"""Doubts of a tile for which there is room at first; a tile with more is cast again."""


# What over- or underflows here is bounded by infinity, and so decided exactly.
@np.errstate(all="ignore")
def render(view: View, certified: bool) -> VisibilityMap:
    """Find what the ray of every sample meets first, tile by tile; see :func:`hsr.algorithms.raycast.render`.

    Parameters
    ----------
    view : View
    certified : bool
        Whether what float64 leaves in doubt is decided exactly.
    """
    clock = Clock()
    geometry = view.geometry
    with clock("build"):
        hierarchies = geometry.once("raycast hierarchies", lambda: hierarchies_of(geometry))
    with clock("prepare"):
        world = geometry.once("raycast world", lambda: world_of(geometry, hierarchies))
        # Touch the memory now: the first touch of a page takes longer than what is computed in it.
        room, size = _room(world.members), (view.height, view.width)
        face, depth = np.full(size, -1, np.int32), np.full(size, np.inf)
    with clock("render"):
        rows = clip_matrices(view)
        eye = eye_of(view, world, rows)
        caster = Caster(view, world, rows, eye, certified, (world.faces, face, depth))
        found, counts = _cast(caster, room)
        uncertain = decide(view, found, numbers_of(found, len(world.faces)), (face, depth))
    work = {
        "rays": view.width * view.height,
        "nodes visited": int(counts[casting.NODES]),
        "extent tests": int(counts[casting.EXTENTS]),
        "face tests": int(counts[fill.TRIANGLES]),
        "uncertain": uncertain,
    }
    notes = {"depth_format": format_of(view, len(world.faces), eye)}
    return VisibilityMap(face, depth, "raycast", work, clock.seconds, notes)


# ---------------------------------------------------------------- once a shape


class Hierarchy(NamedTuple):
    """A shape of planar faces as triangles, in the order of the leaves of its hierarchy; else nothing.

    Attributes
    ----------
    vertices : (3, V) float64, object space
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


Handed = tuple[Shape, bool]
"""A shape, and whether its object is mirrored: the fans of its polygons then run the other way round."""


def hierarchies_of(geometry: Geometry) -> dict[Handed, Hierarchy]:
    """Build the hierarchies of all shapes, once for all their instances."""
    return {kind: _hierarchy_of(*kind) for kind in dict.fromkeys(map(_handed, geometry))}


def _hierarchy_of(shape: Shape, mirrored: bool) -> Hierarchy:
    polygons, box = shape.polygons, box_of(shape)
    if polygons is None:
        corner, number, tree = (np.empty(size, np.int32) for size in ((0, 3), 0, (0, 2)))
        return Hierarchy(np.empty((3, 0)), corner, number, tree, box)
    if mirrored:
        polygons = replace(polygons, corner=reversed_loops(polygons))
    number, tree = hierarchy.tree_of(polygons.vertices, polygons.triangle_vertex, box, LEAF)
    corner = np.take(polygons.triangle_vertex, number, axis=0)
    return Hierarchy(np.ascontiguousarray(polygons.vertices.T), corner, number, tree, box)


def _handed(placement: Placement) -> Handed:
    return placement.shape, placement.mirrored


def box_of(shape: Shape) -> Floats:
    """Return the opposite corners (2, 3) of the box around a shape, object space."""
    if shape.quadric is not None:
        return shape.quadric.box
    return hierarchy.box_of(cast(Polygons, shape.polygons).vertices)


# ---------------------------------------------------------------- once a scene


class World(NamedTuple):
    """The objects of a scene.

    Attributes
    ----------
    shapes : Shapes
        The data of all hierarchies, one after the other.
    members : (n,) MEMBER
        The objects, with no place on the screen and no quadric yet.
    box : (n, 2, 3) float64
        Opposite corners of the boxes around them, object space.
    faces : (pieces,) int32
        Face of each piece, see :func:`hsr.certify.first_pieces`.
    """

    shapes: casting.Shapes
    members: Array
    box: Floats
    faces: Ints


def world_of(geometry: Geometry, hierarchies: dict[Handed, Hierarchy]) -> World:
    """Join the data of all hierarchies, and say of each object where its own is."""
    every = hierarchies.values()
    sizes = np.array([[one.vertices.shape[1], len(one.corner), len(one.tree)] for one in every])
    described = np.zeros(len(hierarchies), MEMBER)
    described["vertices"], described["triangles"], described["nodes"] = sizes.T
    described["vertex"], described["triangle"], described["node"] = (np.cumsum(sizes, axis=0) - sizes).T

    place = {kind: k for k, kind in enumerate(hierarchies)}
    which = [place[_handed(one)] for one in geometry]
    members = described[which]
    members["object"] = np.arange(len(members))
    members["cull"] = [one.cull for one in geometry]
    members["piece"] = first_pieces(geometry)[:-1]
    members["quadric"] = NO_QUADRIC
    points, *shapes, boxes = zip(*every, strict=True)
    vertices, faces = _joined(points, axis=1), np.concatenate([_faces_of(one) for one in geometry])
    corner, number, tree = (_joined(parts) for parts in shapes)
    return World((vertices, corner, number, tree), members, np.array(boxes)[which], faces)


def _joined(parts: Sequence[Array], axis: int = 0) -> Array:
    """Concatenate arrays; a single one is not copied."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts, axis)


def _faces_of(one: Placement) -> Ints:
    """Return the face of each piece of an object."""
    polygons = one.shape.polygons
    own = np.arange(one.shape.faces) if polygons is None else polygons.triangle_face
    return np.asarray(own, np.int32) + np.int32(one.first)


Room = tuple[Floats, Floats]
"""Room for the projected vertices (v, 4) and the extents of the nodes (e, 5) of any batch."""


def _room(members: Array) -> Room:
    both = members["vertices"], members["nodes"]
    vertices, nodes = (min(int(sizes.sum()), max(BATCH, int(sizes.max()))) for sizes in both)
    return np.full((vertices, 4), 0.0), np.full((nodes, 5), 0.0)


def clip_matrices(view: View) -> Floats:
    """Return the matrices (n, 3, 4) that carry the objects' points (x, y, z, 1) to clip space (x, y, d)."""
    return np.asarray(clip_rows(view.clip_from_world, view.depth_row) @ view.geometry.matrices)


def eye_of(view: View, world: World, rows: Floats) -> Eye:
    """Measure a view for the kernels.

    An entry of a matrix is a sum of at most four products, by rows that were divided once; a clip coordinate
    is a sum of three products and an offset, and depth is taken for w: fewer than sixteen roundings, each of
    at most the sum of the magnitudes.
    """
    matrices = abs(view.geometry.matrices)
    clip = abs(clip_rows(view.clip_from_world, view.depth_row))
    bound = (clip + SMALL) @ matrices + SMALL
    size = (bound[:, :, :3] @ abs(world.box).max(axis=1)[:, :, None])[:, :, 0] + bound[:, :, 3]
    least, most = _depths(world, rows)
    error_x, error_y, error_d = (16.0 * U * size.max(axis=0)).tolist()
    image, seen = (float(view.width), float(view.height)), (float(least.min()), float(most.max()))
    return eye_between(view.perspective, image, (error_x, error_y, error_d), (view.near, view.far), seen)


def _depths(world: World, rows: Floats) -> tuple[Floats, Floats]:
    """Return the least and the greatest depth (n,) of the objects' boxes."""
    ends = rows[:, None, 2, :3] * world.box
    offset = rows[:, 2, 3]
    return offset + ends.min(axis=1).sum(axis=1), offset + ends.max(axis=1).sum(axis=1)


# ---------------------------------------------------------------- all rays


class Caster(NamedTuple):
    """A view as the kernels see it, and the answer.

    Attributes
    ----------
    view : View
    world : World
    rows : (n, 3, 4) float64
        See :func:`clip_matrices`.
    eye : Eye
    certified : bool
    image : Image
    """

    view: View
    world: World
    rows: Floats
    eye: Eye
    certified: bool
    image: fill.Image


def _cast(caster: Caster, room: Room) -> tuple[Array, Array]:
    """Cast all rays into batches of objects, nearest first; return the doubts (m,) and the counts."""
    extent, seen = _extents(caster)
    members = caster.world.members
    curved = np.flatnonzero(seen & (members["nodes"] == 0))
    quadrics = quadrics_of(caster.view, curved, members["piece"][curved], extent[curved, :4], caster.eye)

    order = np.argsort(extent[:, 4], kind="stable")
    batches = list(_batches(order[seen[order]], members))
    once = len(batches) < 2
    kept = _kept(0 if once else caster.view.height, caster.view.width)
    found, total = [NO_DOUBTS], np.zeros(casting.COUNTS, np.int64)
    for chosen in batches:
        if not once:
            chosen = chosen[casting.may_show(extent[chosen], _gap(caster), kept[1])]
        batch = members[chosen]
        of_curved = batch["nodes"] == 0
        batch["quadric"][of_curved] = np.searchsorted(curved, chosen[of_curved])
        laid = _lay_out(caster, batch, extent[chosen], room)
        for noted, counts in _cast_batch(caster, laid, (quadrics, _crossing(caster, laid)), kept):
            found.append(noted)
            total += counts
    every = np.concatenate(found)
    return every if once else _settled(caster, every, kept[0]), total


def _extents(caster: Caster) -> tuple[Floats, Bools]:
    """Return what samples each object may cover and how near it comes (n, 5), and whether it may be seen."""
    extent, (least, most) = np.empty((len(caster.rows), 5)), _depths(caster.world, caster.rows)
    casting.reach_objects(caster.world.box, caster.rows, caster.eye, extent)
    seen = (extent[:, 0] < extent[:, 1]) & (extent[:, 2] < extent[:, 3])
    # Depths that overflowed are not numbers: such an object may be anywhere.
    error = caster.eye.error_d
    return extent, seen & ~(most < caster.view.near - error) & ~(least > caster.view.far + error)


def _batches(order: Array, members: Array) -> Iterator[Array]:
    """Cut the objects into runs of at most ``BATCH`` vertices and nodes, or of one object."""
    start, laid = 0, 0
    for end, size in enumerate(members["vertices"][order] + members["nodes"][order]):
        if end > start and laid + size > BATCH:
            yield order[start:end]
            start, laid = end, 0
        laid += size
    if start < len(order):
        yield order[start:]


def _kept(height: int, width: int) -> casting.Kept:
    """Return tiles that show nothing; samples beyond the image hide everything."""
    rows, columns = -(-height // LINES), -(-width // COLUMNS)
    keys = np.full((rows, columns, LINES, COLUMNS + LANES), fill.EMPTY, np.int64)
    keys[-1:, :, height - (rows - 1) * LINES :] = 0
    keys[:, -1, :, width - (columns - 1) * COLUMNS :] = 0
    return keys, np.full((rows, columns, LINES // CELL, COLUMNS // CELL), np.inf)


def _lay_out(caster: Caster, members: Array, extent: Floats, room: Room) -> casting.Laid:
    """Lay a batch of objects out on the screen."""
    for place, size in (("to_screen", "vertices"), ("to_extent", "nodes")):
        members[place] = np.cumsum(members[size]) - members[size]
    laid = (members, extent, room[0][: members["vertices"].sum()], room[1][: members["nodes"].sum()])
    vertices = _shares(members["vertices"], SHARE_OF_VERTICES)
    nodes = _shares(members["nodes"], SHARE_OF_NODES)
    casting.lay_out(caster.world.shapes, caster.rows, caster.eye, vertices, nodes, laid)
    return laid


def _shares(sizes: Array, most: int) -> Array:
    """Cut what each member has into shares of at most ``most``."""
    parts = -(-sizes // most)
    shares = np.empty(parts.sum(), SHARE)
    shares["member"] = np.repeat(np.arange(len(sizes)), parts)
    shares["start"] = most * (np.arange(len(shares)) - np.repeat(np.cumsum(parts) - parts, parts))
    shares["end"] = np.minimum(shares["start"] + most, sizes[shares["member"]])
    return shares


def _crossing(caster: Caster, laid: casting.Laid) -> Floats:
    """Set up the triangles of a batch of which a corner is not certain."""
    members, _, screen, _ = laid
    uncertain = np.flatnonzero(~(screen[:, ERROR] <= PRECISE))
    clip, pieces = [np.empty((0, 3, 3))], [np.empty(0, np.int32)]
    for member in members[np.unique(np.searchsorted(members["to_screen"], uncertain, "right") - 1)]:
        vertices, corner, number = _own(caster.world, member)
        projected = screen[member["to_screen"] :][: len(vertices)]
        chosen = crossing_triangles(projected, corner, caster.eye)
        corners = to_clip(vertices[corner[chosen].ravel()], caster.rows[member["object"]])
        clip.append(corners.reshape(-1, 3, 3))
        pieces.append(number[chosen] + np.int32(member["piece"]))
    piece = np.concatenate(pieces)
    return crossing_tables(caster.view, np.concatenate(clip), piece, piece, caster.eye)


def _own(world: World, member: Array) -> tuple[Floats, Ints, Ints]:
    """Return the vertices, corners and numbers of a member's triangles."""
    vertices, corner, number, _ = world.shapes
    vertex = slice(member["vertex"], member["vertex"] + member["vertices"])
    triangle = slice(member["triangle"], member["triangle"] + member["triangles"])
    return vertices[:, vertex].T, corner[triangle], number[triangle]


def _cast_batch(
    caster: Caster, laid: casting.Laid, special: tuple[Array, Floats], kept: casting.Kept
) -> Iterator[tuple[Array, Array]]:
    """Cast all rays into a batch that is laid out; yield doubts and counts of tiles."""
    extent, crossing = laid[1], special[1]
    listed, todo = deal(extent, caster.view.width, caster.view.height, thread_count())
    todo = todo[(len(crossing) > 0) | (todo[:, 2] < todo[:, 3])]
    shapes, eye, image = caster.world.shapes, caster.eye, caster.image

    def cast(todo: Array, noted: Array | None, counts: Array) -> None:
        casting.cast(shapes, laid, special, listed, todo, eye, kept, image, noted, counts)

    return filled(todo, ROOM, caster.certified, cast)


# ---------------------------------------------------------------- what is in doubt


def _settled(caster: Caster, found: Array, keys: Array) -> Array:
    """Forget doubts that later batches hide, and where some are left, add what the keys show in the end."""
    row, column = np.divmod(found["sample"], caster.view.width)
    shown = keys[row // LINES, column // COLUMNS, row % LINES, column % COLUMNS]
    left = found["key"] - shown <= _gap(caster)
    last = found[left & (shown != fill.EMPTY)]
    last["key"], last["sure"] = shown[left & (shown != fill.EMPTY)], True
    return np.concatenate([found[left], np.unique(last)])


def _gap(caster: Caster) -> int:
    """Return by how much keys differ at most whose depths may be equal."""
    return fill.gap_of(fill.depth_mask(len(caster.world.faces)), caster.eye.tie)
