"""Coherent rays: the image is cut into tiles, and the rays of a tile go through the hierarchies together.

A tile's rays share their way down a hierarchy. For that the hierarchy is refitted to the screen: each node
gets the rectangle of samples that it may cover and the least key depth that it may have (bottom-up, as in
Wald, Boulos & Shirley, "Ray Tracing Deformable Scenes Using Dynamic Bounding Volume Hierarchies", ACM
Transactions on Graphics 26(1), 2007). A node is passed by if its rectangle misses the tile, or if it is
behind all that the tile shows there, cell by cell. In the leaves a ray meets a triangle where its sample is
inside the projected edges; those tests, and what they leave in doubt, are those of the depth buffer
(:mod:`hsr.kernels.zbuffer.setup`, :mod:`hsr.kernels.zbuffer.fill`). Spheres and cylinders are met
by each ray itself (:mod:`hsr.kernels.raytiles.curved`).

Objects are laid out on the screen in batches, nearest first, and forgotten afterwards, so that this memory
does not grow with the number of instances. Tiles are shared out among threads; neither that nor the order of
what they meet leaves a trace.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.base.jit import jit, parallel_jit, prange
from hsr.kernels.hierarchy import INNER, STACK
from hsr.kernels.raytiles.curved import cast_into_quadric
from hsr.kernels.zbuffer import fill
from hsr.kernels.zbuffer.fill import CELL, COLUMNS, LINES, Image, Tile, depth_gap
from hsr.kernels.zbuffer.setup import (
    CLUSTER,
    CULL,
    ERROR,
    GATHERED,
    NEARNESS,
    NUMBER,
    PRECISE,
    TABLE,
    Eye,
    X,
    Y,
    entries,
    key_depth,
    nearness_error,
    project,
    reach_box,
    samples_between,
    set_up,
)

NODES, EXTENTS = 2, 3
"""Further columns of the counts of a tile: nodes visited, and objects looked at."""

COUNTS = 4

NO_QUADRIC = -1

MEMBER = np.dtype(
    [
        ("object", np.int64),
        ("cull", np.int64),
        ("piece", np.int64),
        ("quadric", np.int64),
        ("vertex", np.int64),
        ("triangle", np.int64),
        ("node", np.int64),
        ("vertices", np.int64),
        ("triangles", np.int64),
        ("nodes", np.int64),
        ("to_screen", np.int64),
        ("to_extent", np.int64),
    ]
)
"""An object of a batch.

object : its index.
piece : number of its first piece.
quadric : row of a sphere or cylinder among the quadrics, ``NO_QUADRIC`` for a mesh.
vertex, triangle, node : where the vertices, triangles and nodes of its mesh begin.
vertices, triangles, nodes : how many it has.
to_screen, to_extent : where its projected vertices, and the extents of its nodes, begin.
"""

SHARE = np.dtype([("member", np.int64), ("start", np.int64), ("end", np.int64)])
"""Some vertices or nodes of a member, counted from its first."""

Shapes = tuple[Floats, Ints, Ints, Ints]
"""Of all meshes: vertices (3, V), object space; corners (n, 3) and numbers among the fans (n,) of the
triangles, in the order of the leaves; ``first`` and ``count`` (N, 2) of the nodes. Each counts from the start
of its own mesh."""

Kept = tuple[Array, Floats]
"""Keys (rows, columns, LINES, COLUMNS + LANES) int64 of all tiles, and the farthest key depth of each of
their cells (rows, columns, cells down, cells across)."""

Laid = tuple[Array, Floats, Floats, Floats]
"""A batch: members (m,) MEMBER, nearest first, and their extents (m, 5): first and end column, first and end
line, and a bound of the least key depth; projected vertices (v, 4), see ``setup.lay_out``; the extents
(e, 5) of nodes."""


# ---------------------------------------------------------------- laying out


@jit
def reach_objects(box: Floats, rows: Floats, eye: Eye, extent: Floats) -> None:
    """Find the samples that objects may cover, and how near they come.

    Parameters
    ----------
    box : (n, 2, 3) float64
        Opposite corners of the boxes around them, object space.
    rows : (n, 3, 4) float64
        From there to clip space (x, y, d).
    eye : Eye
    extent : (n, 5) float64
        Receives first and end column, first and end line, and a bound of the least key depth.
    """
    for k in range(len(box)):
        low, high = (box[k, 0, 0], box[k, 0, 1], box[k, 0, 2]), (box[k, 1, 0], box[k, 1, 1], box[k, 1, 2])
        reached = reach_box(low, high, entries(rows[k]), eye)
        for part in range(5):
            extent[k, part] = reached[part]


@jit
def may_show(extent: Floats, gap: int, farthest: Floats) -> Array:
    """Tell of which objects (n,) some cell does not already show something nearer, by more than a key gap."""
    seen = np.zeros(len(extent), np.bool_)
    for k in range(len(extent)):
        left, right, top, bottom = extent[k, 0], extent[k, 1], extent[k, 2], extent[k, 3]
        for line in range(int(top) // CELL * CELL, int(bottom), CELL):
            for column in range(int(left) // CELL * CELL, int(right), CELL):
                tile = farthest[line // LINES, column // COLUMNS]
                cell = tile[line % LINES // CELL, column % COLUMNS // CELL]
                seen[k] |= not extent[k, 4] - depth_gap(gap) > cell
    return seen


@parallel_jit
def lay_out(
    shapes: Shapes, rows: Floats, eye: Eye, vertex_shares: Array, node_shares: Array, laid: Laid
) -> None:
    """Project the meshes of a batch, and refit their hierarchies to the screen.

    Parameters
    ----------
    shapes : Shapes
    rows : (n, 3, 4) float64
        From the space of each object to clip space (x, y, d).
    eye : Eye
    vertex_shares, node_shares : (s,) SHARE
        All vertices, and all nodes, of the members.
    laid : Laid
        Receives projected vertices and extents.
    """
    vertices, corner, _, tree = shapes
    members, _, screen, extent = laid
    for k in prange(len(vertex_shares)):
        share = vertex_shares[k]
        project_share(vertices, rows, eye, members[share["member"]], share, screen)
    for k in prange(len(node_shares)):
        share = node_shares[k]
        reach_leaves(corner, tree, eye, members[share["member"]], share, screen, extent)
    for k in prange(len(members)):
        reach_inner(tree, members[k], extent)


@jit
def project_share(vertices: Floats, rows: Floats, eye: Eye, member: Any, share: Any, screen: Floats) -> None:
    """Carry some vertices of a mesh to the screen."""
    matrix, source, target = entries(rows[member["object"]]), member["vertex"], member["to_screen"]
    first, end = share["start"], share["end"]
    project(vertices, source + first, source + end, matrix, eye, screen, target + first)


@jit
def reach_leaves(
    corner: Ints, tree: Ints, eye: Eye, member: Any, share: Any, screen: Floats, extent: Floats
) -> None:
    """Find the extent of some leaves of a mesh, but for triangles with corners that are not certain."""
    for k in range(share["start"], share["end"]):
        first, count = tree[member["node"] + k, 0], tree[member["node"] + k, 1]
        if count == INNER:
            continue

        # Join the corners of its triangles.
        left, right, top, bottom, nearest, error = np.inf, -np.inf, np.inf, -np.inf, -np.inf, 0.0
        for triangle in range(member["triangle"] + first, member["triangle"] + first + count):
            a = member["to_screen"] + corner[triangle, 0]
            b = member["to_screen"] + corner[triangle, 1]
            c = member["to_screen"] + corner[triangle, 2]
            worst = max(max(screen[a, ERROR], screen[b, ERROR]), screen[c, ERROR])
            if worst <= PRECISE:
                error = max(error, worst)
                left = min(min(left, screen[a, X]), min(screen[b, X], screen[c, X]))
                right = max(max(right, screen[a, X]), max(screen[b, X], screen[c, X]))
                top = min(min(top, screen[a, Y]), min(screen[b, Y], screen[c, Y]))
                bottom = max(max(bottom, screen[a, Y]), max(screen[b, Y], screen[c, Y]))
                nearest = max(
                    max(nearest, screen[a, NEARNESS]), max(screen[b, NEARNESS], screen[c, NEARNESS])
                )

        # Note the samples that they may cover, and how near they come.
        noted = extent[member["to_extent"] + k]
        noted[1] = 0.0
        if left <= right:
            noted[0], noted[1] = samples_between(left, right, error, eye.width)
            noted[2], noted[3] = samples_between(top, bottom, error, eye.height)
            noted[4] = key_depth(nearest, eye) - nearness_error(nearest, eye) * eye.scale
        else:
            noted[0] = eye.width
        if not (noted[0] < noted[1] and noted[2] < noted[3]):
            # What covers nothing adds nothing where extents are joined.
            noted[0], noted[1], noted[2], noted[3], noted[4] = eye.width, 0.0, eye.height, 0.0, np.inf


@jit
def reach_inner(tree: Ints, member: Any, extent: Floats) -> None:
    """Join the extents of the nodes of a mesh below each, from the last to the first."""
    for k in range(member["nodes"] - 1, -1, -1):
        first, count = tree[member["node"] + k, 0], tree[member["node"] + k, 1]
        if count != INNER:
            continue
        whole, one = extent[member["to_extent"] + k], extent[member["to_extent"] + first]
        two = extent[member["to_extent"] + first + 1]
        whole[0], whole[1] = min(one[0], two[0]), max(one[1], two[1])
        whole[2], whole[3] = min(one[2], two[2]), max(one[3], two[3])
        whole[4] = min(one[4], two[4])


# ---------------------------------------------------------------- casting


@parallel_jit
def cast(
    shapes: Shapes,
    laid: Laid,
    special: tuple[Array, Floats],
    listed: Ints,
    todo: Array,
    eye: Eye,
    kept: Kept,
    image: Image,
    doubts: Array | None,
    counts: Array,
) -> None:
    """Cast the rays of tiles into a batch of objects that is laid out.

    Parameters
    ----------
    shapes, laid
    special : tuple
        Quadrics (q,) QUADRIC, and tables (t, TABLE) float64, all full, of the triangles of which a corner is
        not certain.
    listed : (l,) int32
        Members, list after list, nearest first.
    todo : (k, 4) int64
        Tiles: row and column, where the list of each begins and where it ends.
    eye : Eye
    kept : Kept
        What the tiles show from batch to batch; of no tiles if there is one batch.
    image : Image
        It shows the background, or what earlier batches left.
    doubts : (k, room) DOUBT or None
    counts : (k, COUNTS) int64
    """
    for k in prange(len(todo)):
        room = None if doubts is None else doubts[k]
        tile = tile_before(todo[k, 0], todo[k, 1], kept, image, eye)
        cast_tile(shapes, laid, special[0], listed[todo[k, 2] : todo[k, 3]], tile, eye, room, counts[k])
        fill.finish(tile, special[1], image, eye, room, counts[k])
        if len(kept[0]) > 0:
            remember(tile)


@jit
def tile_before(row: int, column: int, kept: Kept, image: Image, eye: Eye) -> Tile:
    """Return a tile of the image as earlier batches left it."""
    if len(kept[0]) == 0:
        return fill.empty_tile(row, column, image, eye)
    keys, farthest = kept[0][row, column], kept[1][row, column]
    return fill.tile_of(row, column, keys, farthest, image[1].shape[1], len(image[0]), eye)


@jit
def remember(tile: Tile) -> None:
    """Note for the next batch how far a tile shows where it was drawn to."""
    for row in range(tile.drawn.shape[0]):
        for column in range(tile.drawn.shape[1]):
            if tile.drawn[row, column]:
                tile.farthest[row, column] = fill.farthest_in(tile.keys, row * CELL, column * CELL)


@jit
def cast_tile(
    shapes: Shapes,
    laid: Laid,
    quadrics: Array,
    listed: Ints,
    tile: Tile,
    eye: Eye,
    doubts: Array | None,
    counts: Array,
) -> None:
    """Cast the rays of one tile into the listed members, nearest first, but for the hidden ones."""
    members, extent = laid[0], laid[1]
    for m in listed:
        counts[EXTENTS] += 1
        cells = fill.cells_of(extent[m, 0], extent[m, 1], extent[m, 2], extent[m, 3], tile)
        if fill.is_hidden(extent[m, 4], cells, tile):
            continue
        if members[m]["quadric"] == NO_QUADRIC:
            cast_into_mesh(shapes, laid, members[m], tile, eye, doubts, counts)
        else:
            cast_into_quadric(quadrics[members[m]["quadric"]], tile, eye, doubts, counts)
            fill.touch(tile, cells)


@jit
def cast_into_mesh(
    shapes: Shapes, laid: Laid, member: Any, tile: Tile, eye: Eye, doubts: Array | None, counts: Array
) -> None:
    """Walk the rays of a tile through the hierarchy of a mesh, the nearer child first."""
    _, corner, number, tree = shapes
    _, _, screen, extent = laid
    root, to_extent, start = member["node"], member["to_extent"], member["triangle"]
    stack, table = np.empty(STACK, np.int64), np.empty(TABLE)
    stack[0] = 0
    waiting = 1
    while waiting > 0:
        # Take the next node, unless something nearer hides it.
        waiting -= 1
        k = stack[waiting]
        counts[NODES] += 1
        here = to_extent + k
        cells = fill.cells_of(extent[here, 0], extent[here, 1], extent[here, 2], extent[here, 3], tile)
        if fill.is_hidden(extent[here, 4], cells, tile):
            continue

        # Go on to its children, or draw its triangles.
        first, count = tree[root + k, 0], tree[root + k, 1]
        if count == INNER:
            second_nearer = extent[to_extent + first + 1, 4] < extent[to_extent + first, 4]
            stack[waiting] = first if second_nearer else first + 1
            stack[waiting + 1] = first + 1 if second_nearer else first
            waiting += 2
        else:
            n = np.uintp(count)
            gather_leaf(screen, corner, number, member, start + first, n, table)
            set_up(table, n, eye)
            fill.draw_table(table, n, tile, eye, doubts, counts)
            fill.touch(tile, cells)


@jit
def gather_leaf(
    screen: Floats, corner: Ints, number: Ints, member: Any, first: int, n: np.uintp, table: Floats
) -> None:
    """Gather the triangles of a leaf into a table."""
    to_screen, piece, cull = member["to_screen"], member["piece"], float(member["cull"])
    for i in range(n):
        triangle = first + np.int64(i)
        for k in range(3):
            for part in range(4):
                table[GATHERED + (4 * k + part) * CLUSTER + i] = screen[to_screen + corner[triangle, k], part]
        table[CULL + i], table[NUMBER + i] = cull, piece + number[triangle]
