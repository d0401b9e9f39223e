"""Half-space rasterisation by tiles of the image, with hierarchical depth.

Triangles come in clusters, neighbours on the surface, and clusters in order of their nearest point. The
screen is cut into cells, of which the farthest depth is known; a cluster behind all cells that it crosses is
hidden, and not looked into (Greene, Kass & Miller, "Hierarchical Z-Buffer Visibility", SIGGRAPH 1993). The
others are drawn triangle by triangle, see :mod:`hsr.kernels.zbuffer.setup` and
:mod:`hsr.kernels.zbuffer.fill`, in this order.

The tiles are shared out among threads. Neither their number nor the order of clusters leaves a trace.
"""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.base.jit import jit, parallel_jit, prange
from hsr.kernels.hierarchy import radix_sort
from hsr.kernels.zbuffer import fill
from hsr.kernels.zbuffer.fill import COLUMNS, LINES, Image, Tile
from hsr.kernels.zbuffer.setup import CLUSTER, FARTHEST, TABLE, Eye, gather, set_up

SLICES = 2048
"""Of depth, in which things are put in order."""

DRAWN, HIDDEN = 2, 3
"""Further columns of the counts of a tile: clusters looked into, and hidden ones."""

COUNTS = 4

Clustered = tuple[Floats, Ints, Array]
"""Projected vertices (V, 4) float64; corners (n, 3) int32 and what to cull (n,) int8 of the triangles, see
:func:`hsr.kernels.zbuffer.setup.gather`."""


@jit
def deal(extent: Floats, width: int, height: int, threads: int) -> tuple[Ints, Array]:
    """List for each tile of the image what may cover some of it, nearest first.

    Parameters
    ----------
    extent : (n, 5) float64
        First and end column, first and end line of each thing, and its least key depth.
    width, height : int
    threads : int

    Returns
    -------
    listed : (m,) int32
        List after list.
    tiles : (T, 4) int64
        Row and column of a tile, where its list begins and where it ends. Each thread takes one run of them,
        all as long: in this order each run holds long lists and short ones, as long as all are drawn.
    """
    columns = -(-width // COLUMNS)
    number = -(-height // LINES) * columns
    # Count what each tile gets.
    order = nearest_first(extent)
    place = np.zeros(number + 1, np.int64)
    for m in order:
        first_row, end_row, first_column, end_column = tiles_of(extent[m])
        for row in range(first_row, end_row):
            for tile in range(row * columns + first_column, row * columns + end_column):
                place[tile + 1] += 1

    # Deal the tiles to the threads, those with the longest lists first.
    shortness = np.empty(number, np.uint32)
    for tile in range(number):
        shortness[tile] = len(extent) - place[tile + 1]
    add_up(place)
    tiles = np.empty((number, 4), np.int64)
    for k, tile in enumerate(to_and_fro(radix_sort(shortness)[1], threads)):
        tiles[k, 0], tiles[k, 1] = tile // columns, tile % columns
        tiles[k, 2], tiles[k, 3] = place[tile], place[tile + 1]

    # Write the lists.
    listed = np.empty(place[-1], np.int32)
    for m in order:
        first_row, end_row, first_column, end_column = tiles_of(extent[m])
        for row in range(first_row, end_row):
            for tile in range(row * columns + first_column, row * columns + end_column):
                listed[place[tile]] = m
                place[tile] += 1
    return listed, tiles


@jit
def nearest_first(extent: Floats) -> Ints:
    """Return what may cover some sample, the nearest first: by slices of depth, and in one as they come."""
    # Count what each slice of depth has.
    inside = np.zeros(len(extent), np.int32)
    start = np.zeros(SLICES + 1, np.int64)
    for m in range(len(extent)):
        if extent[m, 0] < extent[m, 1] and extent[m, 2] < extent[m, 3]:
            # Whose depth is not a number may be anywhere.
            z = extent[m, 4] if extent[m, 4] > 1.0 else 1.0
            inside[m] = 1 + int((min(z, FARTHEST) - 1.0) * (SLICES - 1))
            start[inside[m]] += 1

    # Put everything in its slice.
    add_up(start)
    order = np.empty(start[-1], np.int32)
    for m in range(len(extent)):
        if inside[m] > 0:
            order[start[inside[m] - 1]] = m
            start[inside[m] - 1] += 1
    return order


@jit
def add_up(counts: Array) -> None:
    """Add to each count those before it."""
    for k in range(1, len(counts)):
        counts[k] += counts[k - 1]


@jit
def to_and_fro(pieces: Array, threads: int) -> Array:
    """Deal pieces of work (n,), the largest first, to threads, to and fro; return hand after hand."""
    hands, k = np.empty_like(pieces), 0
    for thread in range(threads):
        for i in range(len(pieces)):
            turn = i % (2 * threads)
            if min(turn, 2 * threads - 1 - turn) == thread:
                hands[k] = pieces[i]
                k += 1
    return hands


@jit
def tiles_of(extent: Floats) -> tuple[int, int, int, int]:
    """Return the first and end row, first and end column of the tiles in an extent."""
    return (
        int(extent[2]) // LINES,
        (int(extent[3]) - 1) // LINES + 1,
        int(extent[0]) // COLUMNS,
        (int(extent[1]) - 1) // COLUMNS + 1,
    )


# ---------------------------------------------------------------- tiles


@parallel_jit
def rasterise(
    triangles: Clustered,
    extent: Floats,
    listed: Ints,
    todo: Array,
    crossing: Floats,
    eye: Eye,
    image: Image,
    doubts: Array | None,
    counts: Array,
) -> None:
    """Draw all triangles tile by tile.

    Parameters
    ----------
    triangles : Clustered
    extent : (clusters, 5) float64
    listed, todo
        Lists and tiles of :func:`deal`.
    crossing : (t, TABLE) float64
        Tables of the triangles that ``set_up`` leaves out, all full.
    eye : Eye
    image : Image
        It shows the background.
    doubts : (T, room) DOUBT or None
    counts : (T, COUNTS) int64
    """
    for k in prange(len(todo)):
        room = None if doubts is None else doubts[k]
        tile = fill.empty_tile(todo[k, 0], todo[k, 1], image, eye)
        draw_clusters(triangles, extent, listed[todo[k, 2] : todo[k, 3]], tile, eye, room, counts[k])
        fill.finish(tile, crossing, image, eye, room, counts[k])


@jit
def draw_clusters(
    triangles: Clustered,
    extent: Floats,
    listed: Ints,
    tile: Tile,
    eye: Eye,
    doubts: Array | None,
    counts: Array,
) -> None:
    """Draw the listed clusters into a tile, nearest first, but for the hidden ones."""
    screen, corner, cull = triangles
    table = np.empty(TABLE)
    for m in listed:
        cells = fill.cells_of(extent[m, 0], extent[m, 1], extent[m, 2], extent[m, 3], tile)
        if fill.is_hidden(extent[m, 4], cells, tile):
            counts[HIDDEN] += 1
            continue
        counts[DRAWN] += 1
        n = gather(screen, corner, cull, m * CLUSTER, table)
        set_up(table, n, eye)
        fill.draw_table(table, n, tile, eye, doubts, counts)
        fill.touch(tile, cells)
