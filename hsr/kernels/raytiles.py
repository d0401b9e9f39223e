"""Coherent rays: tiles of 16 x 16 samples go through the hierarchies together.

A tile's rays share their way down a hierarchy. For that the hierarchy is refitted to the screen: each
node gets the rectangle of samples it can reach and the greatest nearness it can have (bottom-up, as
in Wald, Boulos and Shirley, "Ray Tracing Deformable Scenes Using Dynamic Bounding Volume
Hierarchies", 2007). A node is passed by if its rectangle misses the tile, or if the whole tile
already shows something nearer. What is left in the leaves is tested row by row of the tile.

Instances are laid out on the screen in batches, nearest objects first, and forgotten afterwards, so
that memory does not grow with their number. The tests themselves are those of ``rays``.

The parallel loops only call: what Numba makes of a ``prange`` body loses what the body itself writes
into the arrays of a tuple.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hsr.arrays import Array, Floats, Ints
from hsr.jit import jit, parallel_jit, prange
from hsr.kernels.bounds import (
    Corner,
    Reach,
    corner_of,
    reach_box,
    reach_triangle,
    samples_of,
)
from hsr.kernels.hierarchy import INNER, STACK, Tree
from hsr.kernels.rays import (
    EXTENT_TESTS,
    FACE_TESTS,
    MESH,
    NODES,
    Best,
    Camera,
    Facet,
    Image,
    Objects,
    Scene,
    Shapes,
    answer_of,
    better,
    counted,
    covered_nearness,
    facet_of,
    generic_hit,
    row_of,
    tally,
)

SIDE = 16
"""Samples along each side of a tile: two vectors of eight float64."""

AREA = SIDE * SIDE

NONE = 32767
"""More than any column or row: images are at most 2^14 samples wide and high."""

STRIPS = 16
"""Shares of the image for the threads; share s has the tile rows s, s + STRIPS, ..."""


class Tiles(NamedTuple):
    """The nearest hits so far, tile by tile (row-major), sample by sample.

    Attributes
    ----------
    nearness : (tiles, AREA) float64
    face : (tiles, AREA) int64
    floor : (tiles,) float64
        The least nearness within each tile: what is less near is hidden in all of it.
    across : int
        Tiles side by side.
    """

    nearness: Floats
    face: Array
    floor: Floats
    across: int


class Reaches(NamedTuple):
    """What can be reached on the screen by all objects, then by nodes and triangles of a batch.

    Attributes
    ----------
    samples : (n, 4) int16
        First and last column, first and last row; first > last where there is nothing.
    nearest : (n,) float64
        Greatest nearness.
    """

    samples: Array
    nearest: Floats


class Batch(NamedTuple):
    """Objects laid out on the screen together.

    Attributes
    ----------
    member : (n,) int64
        The objects, nearest first.
    vertex_start : (n,) int64
        Row of ``vertex`` where the vertices of each mesh begin.
    node_start, triangle_start : (n,) int64
        Place among the reaches where its nodes and its triangles begin.
    vertex : (V, 4) float64
        Projected vertices, see ``corner_of``.
    """

    member: Array
    vertex_start: Array
    node_start: Array
    triangle_start: Array
    vertex: Floats


# ---------------------------------------------------------------- laying out


@jit
def note_reach(reaches: Reaches, place: int, reach: Reach, camera: Camera) -> None:
    """Write down the samples within a reach."""
    samples = reaches.samples
    samples[place, 0], samples[place, 1] = samples_of(reach.left, reach.right, camera.width)
    samples[place, 2], samples[place, 3] = samples_of(reach.top, reach.bottom, camera.height)
    reaches.nearest[place] = reach.nearest


@jit
def reach_objects(scene: Scene, reaches: Reaches) -> None:
    """Find the reach of every object's extent."""
    camera, objects = scene.camera, scene.objects
    for k in range(len(objects.kind)):
        low, high = objects.low[k] - objects.margin[k], objects.high[k] + objects.margin[k]
        reach = reach_box(objects.screen[k], low, high, camera.perspective, camera.near)
        note_reach(reaches, k, reach, camera)


@parallel_jit
def lay_out(
    camera: Camera, objects: Objects, shapes: Shapes, tree: Tree, batch: Batch, reaches: Reaches, tiles: Tiles
) -> None:
    """Project a batch of objects and refit their hierarchies; those hidden lose their reach."""
    for place in prange(len(batch.member)):
        lay_out_member(place, Scene(camera, objects, shapes, tree), batch, reaches, tiles)


@jit
def lay_out_member(place: int, scene: Scene, batch: Batch, reaches: Reaches, tiles: Tiles) -> None:
    """Lay out one object of a batch; see :func:`lay_out`."""
    k = batch.member[place]
    if is_hidden(reaches, k, tiles):
        reaches.samples[k, 1] = -1
    elif scene.objects.kind[k] == MESH:
        project_mesh(scene, batch, place)
        reach_triangles(scene, batch, place, reaches)
        reach_nodes(scene, batch, place, reaches)


@jit
def is_hidden(reaches: Reaches, k: int, tiles: Tiles) -> bool:
    """Whether every tile that object k can reach already shows something nearer."""
    left, right, top, bottom = reaches.samples[k]
    for row in range(top // SIDE, bottom // SIDE + 1):
        for column in range(left // SIDE, right // SIDE + 1):
            if reaches.nearest[k] >= tiles.floor[row * tiles.across + column]:
                return False
    return True


@jit
def project_mesh(scene: Scene, batch: Batch, place: int) -> None:
    """Carry the vertices of a mesh to the screen."""
    k, shapes = batch.member[place], scene.shapes
    mesh, screen = scene.objects.shape[k], scene.objects.screen[k]
    start, target = shapes.vertex_start[mesh], batch.vertex_start[place]
    for v in range(shapes.vertex_start[mesh + 1] - start):
        p = shapes.vertex[start + v]
        corner = corner_of(screen, p[0], p[1], p[2], scene.camera.perspective)
        for i in range(4):
            batch.vertex[target + v, i] = corner[i]


@jit
def reach_triangles(scene: Scene, batch: Batch, place: int, reaches: Reaches) -> None:
    """Find the reach of every triangle of a mesh."""
    camera, shapes = scene.camera, scene.shapes
    mesh = scene.objects.shape[batch.member[place]]
    shift = batch.vertex_start[place] - shapes.vertex_start[mesh]
    start, target = shapes.triangle_start[mesh], batch.triangle_start[place]
    for i in range(shapes.triangle_start[mesh + 1] - start):
        a, b, c = corners_of(shapes.corner, start + i, batch.vertex, shift)
        reach = reach_triangle(a, b, c, camera.perspective, camera.near)
        note_reach(reaches, target + i, reach, camera)


@jit
def corners_of(corner: Ints, triangle: int, vertex: Floats, shift: int) -> tuple[Corner, Corner, Corner]:
    """Return the projected corners of a triangle; ``shift`` leads from a vertex's index to its row."""
    a, b, c = corner[triangle, 0] + shift, corner[triangle, 1] + shift, corner[triangle, 2] + shift
    return (
        (vertex[a, 0], vertex[a, 1], vertex[a, 2], vertex[a, 3]),
        (vertex[b, 0], vertex[b, 1], vertex[b, 2], vertex[b, 3]),
        (vertex[c, 0], vertex[c, 1], vertex[c, 2], vertex[c, 3]),
    )


@jit
def reach_nodes(scene: Scene, batch: Batch, place: int, reaches: Reaches) -> None:
    """Find the reach of every node of a mesh's hierarchy, from the last to the first."""
    shapes, tree = scene.shapes, scene.tree
    mesh = scene.objects.shape[batch.member[place]]
    start = shapes.node_start[mesh]
    to_node = batch.node_start[place] - start
    to_triangle = batch.triangle_start[place] - shapes.triangle_start[mesh]
    for node in range(shapes.node_start[mesh + 1] - 1, start - 1, -1):
        first, count = tree.first[node], tree.count[node]
        if count == INNER:
            join(reaches, node + to_node, first + to_node, 2)
        else:
            join(reaches, node + to_node, first + to_triangle, count)


@jit
def join(reaches: Reaches, place: int, first: int, count: int) -> None:
    """Make one reach of ``count`` that follow each other; empty ones add nothing."""
    left, right, top, bottom, nearest = NONE, -NONE, NONE, -NONE, -np.inf
    for part in range(first, first + count):
        samples = reaches.samples[part]
        if samples[0] <= samples[1] and samples[2] <= samples[3]:
            left, right = min(left, samples[0]), max(right, samples[1])
            top, bottom = min(top, samples[2]), max(bottom, samples[3])
            nearest = max(nearest, reaches.nearest[part])
    reaches.samples[place, 0], reaches.samples[place, 1] = left, right
    reaches.samples[place, 2], reaches.samples[place, 3] = top, bottom
    reaches.nearest[place] = nearest


# ---------------------------------------------------------------- casting


class Tile(NamedTuple):
    """One tile: its number, its first sample, and its last sample within the image."""

    number: int
    column: int
    row: int
    last_column: int
    last_row: int


@parallel_jit
def cast_batch(
    camera: Camera,
    objects: Objects,
    shapes: Shapes,
    tree: Tree,
    batch: Batch,
    reaches: Reaches,
    tiles: Tiles,
    work: Array | None,
) -> None:
    """Cast the rays of all tiles into a batch of objects that is laid out.

    Parameters
    ----------
    work : (STRIPS, COUNTS) int64 or None
        Receives the work done for every share of the image.
    """
    for strip in prange(STRIPS):
        scene = Scene(camera, objects, shapes, tree)
        share = None if work is None else work[strip]
        for tile_row in range(strip, len(tiles.floor) // tiles.across, STRIPS):
            cast_tile_row(tile_row, scene, batch, reaches, tiles, share)


@jit
def cast_tile_row(
    tile_row: int, scene: Scene, batch: Batch, reaches: Reaches, tiles: Tiles, work: Array | None
) -> None:
    """Cast the rays of one row of tiles into a batch of objects."""
    stack = np.empty(STACK, np.int64)
    for place in range(len(batch.member)):
        k = batch.member[place]
        left, right = reaches.samples[k, 0], reaches.samples[k, 1]
        for tile_column in range(left // SIDE, right // SIDE + 1):
            tile = tile_at(tile_row, tile_column, scene.camera, tiles)
            tally(work, EXTENT_TESTS)
            if not can_show(reaches, k, tile, tiles):
                continue
            if scene.objects.kind[k] == MESH:
                cast_into_mesh(tile, scene, batch, place, reaches, tiles, stack, work)
            else:
                cast_into_generic(tile, scene, k, reaches, tiles, work)


@jit
def tile_at(tile_row: int, tile_column: int, camera: Camera, tiles: Tiles) -> Tile:
    """Return the tile at a row and column of tiles."""
    row, column = tile_row * SIDE, tile_column * SIDE
    last_row, last_column = min(row + SIDE, camera.height) - 1, min(column + SIDE, camera.width) - 1
    return Tile(tile_row * tiles.across + tile_column, column, row, last_column, last_row)


@jit
def cast_into_generic(
    tile: Tile, scene: Scene, k: int, reaches: Reaches, tiles: Tiles, work: Array | None
) -> None:
    """Hit a generic object with each ray of a tile that its extent can reach."""
    camera, samples = scene.camera, reaches.samples[k]
    nearness, owner = tiles.nearness[tile.number], tiles.face[tile.number]
    for row in range(max(tile.row, samples[2]), min(tile.last_row, samples[3]) + 1):
        y = row + 0.5 - 0.5 * camera.height
        for column in range(max(tile.column, samples[0]), min(tile.last_column, samples[1]) + 1):
            x = column + 0.5 - 0.5 * camera.width
            sample = (row - tile.row) * SIDE + column - tile.column
            hit = counted(generic_hit(x, y, k, scene), work)
            nearness[sample], owner[sample] = better(hit, Best(nearness[sample], owner[sample]))
    raise_floor(tile, tiles)


@jit
def cast_into_mesh(
    tile: Tile,
    scene: Scene,
    batch: Batch,
    place: int,
    reaches: Reaches,
    tiles: Tiles,
    stack: Array,
    work: Array | None,
) -> None:
    """Walk a tile through the hierarchy of a mesh, the nearer child first."""
    root = scene.shapes.node_start[scene.objects.shape[batch.member[place]]]
    to_reach = batch.node_start[place] - root
    stack[0] = root
    waiting = 1
    while waiting > 0:
        waiting -= 1
        node = stack[waiting]
        tally(work, NODES)
        if not can_show(reaches, node + to_reach, tile, tiles):
            continue
        first, count = scene.tree.first[node], scene.tree.count[node]
        if count != INNER:
            cast_into_leaf(tile, scene, batch, place, node, reaches, tiles, work)
            continue
        second_nearer = reaches.nearest[first + 1 + to_reach] > reaches.nearest[first + to_reach]
        stack[waiting] = first if second_nearer else first + 1
        stack[waiting + 1] = first + 1 if second_nearer else first
        waiting += 2


@jit
def can_show(reaches: Reaches, place: int, tile: Tile, tiles: Tiles) -> bool:
    """Whether something reaches into a tile, and nearer than all that the tile shows."""
    left, right, top, bottom = reaches.samples[place]
    return (
        left <= tile.last_column
        and right >= tile.column
        and top <= tile.last_row
        and bottom >= tile.row
        and reaches.nearest[place] >= tiles.floor[tile.number]
    )


@jit
def cast_into_leaf(
    tile: Tile,
    scene: Scene,
    batch: Batch,
    place: int,
    leaf: int,
    reaches: Reaches,
    tiles: Tiles,
    work: Array | None,
) -> None:
    """Test the triangles of a leaf that reach into a tile."""
    camera, objects, shapes = scene.camera, scene.objects, scene.shapes
    k = batch.member[place]
    mesh = objects.shape[k]
    to_vertex = batch.vertex_start[place] - shapes.vertex_start[mesh]
    to_reach = batch.triangle_start[place] - shapes.triangle_start[mesh]
    first = scene.tree.first[leaf]
    tested = False
    for triangle in range(first, first + scene.tree.count[leaf]):
        if not can_show(reaches, triangle + to_reach, tile, tiles):
            continue
        a, b, c = corners_of(shapes.corner, triangle, batch.vertex, to_vertex)
        facet = facet_of(a, b, c, camera.perspective, objects.cull[k], objects.mirrored[k])
        tally(work, FACE_TESTS)
        if facet.turn == 0.0:
            continue
        face = objects.first_face[k] + shapes.face[triangle]
        samples = reaches.samples[triangle + to_reach]
        for row in range(max(tile.row, samples[2]), min(tile.last_row, samples[3]) + 1):
            cast_into_row(facet, face, row, tile, camera, tiles)
        tested = True
    if tested:
        raise_floor(tile, tiles)


@jit
def cast_into_row(facet: Facet, face: int, row: int, tile: Tile, camera: Camera, tiles: Tiles) -> None:
    """Test one triangle with a row of 16 rays; written without branches, to become vector code."""
    line = row_of(facet, row + 0.5 - 0.5 * camera.height)
    x = tile.column + 0.5 - 0.5 * camera.width
    start = (row - tile.row) * SIDE
    nearness, owner = tiles.nearness[tile.number], tiles.face[tile.number]
    for i in range(SIDE):
        here = covered_nearness(line, x + i, camera.closest)
        best, best_face = nearness[start + i], owner[start + i]
        nearer = (here > best) | ((here == best) & (face < best_face))
        nearness[start + i] = here if nearer else best
        owner[start + i] = face if nearer else best_face


@jit
def raise_floor(tile: Tile, tiles: Tiles) -> None:
    """Work out the least nearness in a tile: sixteen columns side by side, then across."""
    nearness = tiles.nearness[tile.number]
    column = nearness[:SIDE].copy()
    for row in range(1, SIDE):
        for i in range(SIDE):
            here = nearness[row * SIDE + i]
            column[i] = here if here < column[i] else column[i]
    tiles.floor[tile.number] = column.min()


@parallel_jit
def read_out(camera: Camera, tiles: Tiles, image: Image) -> None:
    """Copy the answers of all tiles into the map."""
    for row in prange(camera.height):
        read_row(row, camera, tiles, image)


@jit
def read_row(row: int, camera: Camera, tiles: Tiles, image: Image) -> None:
    """Copy one row of samples into the map."""
    first, start = row // SIDE * tiles.across, row % SIDE * SIDE
    for column in range(camera.width):
        number, sample = first + column // SIDE, start + column % SIDE
        best = Best(tiles.nearness[number, sample], tiles.face[number, sample])
        image.face[row, column], image.depth[row, column] = answer_of(best, camera.perspective)
