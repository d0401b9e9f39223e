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

from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.base.jit import inline_jit, jit, parallel_jit, prange
from hsr.kernels.zbuffer import fill
from hsr.kernels.zbuffer.fill import EMPTY, TRIANGLES, Image, Limits, Tile, depth_gap, depth_of
from hsr.kernels.zbuffer.setup import (
    BOTTOM,
    CLUSTER,
    CUT,
    FARTHEST,
    LANES,
    LEFT,
    NEAREST,
    PRECISE,
    RIGHT,
    SIDE_BY_SIDE,
    TABLE,
    TOP,
    Eye,
    Matrix,
    entries,
    gather,
    key_depth,
    nearness_error,
    project,
    projected,
    samples_between,
    set_up,
)

LINES, COLUMNS = 128, 512
"""Size in samples of a tile, the piece of work of one thread. Its keys stay in the cache of a core, and a
line of its depths is a page of memory: narrow tiles took three times as long to read out."""

CELL = 8
"""Side in samples of the cells whose farthest depth is known."""

SHARES = 64
"""In which vertices and clusters are laid out: both at once, for it takes time to wake threads."""

SLICES = 2048
"""Of depth, in which things are put in order."""

DRAWN, HIDDEN = 2, 3
"""Further columns of the counts of a tile: clusters looked into, and hidden ones."""

COUNTS = 4

Point = tuple[float, float, float]

Cells = tuple[int, int, int, int]
"""First and end row, first and end column of some cells of a tile."""

Clustered = tuple[Floats, Ints, Array]
"""Projected vertices (V, 4) float64; corners (n, 3) int32 and what to cull (n,) int8 of the triangles, see
:func:`hsr.kernels.zbuffer.setup.gather`."""


# ---------------------------------------------------------------- clusters


@parallel_jit
def lay_out(
    vertices: Floats, low: Floats, high: Floats, rows: Floats, eye: Eye, screen: Floats, extent: Floats
) -> int:
    """Project vertices, and find the samples that clusters may cover, and how near they come.

    Parameters
    ----------
    vertices : (3, V) float64
        World space, coordinate by coordinate.
    low, high : (3, n) float64
        Opposite corners of the boxes around the clusters, likewise.
    rows : (3, 4) float64
        To clip space (x, y, d), see :func:`hsr.kernels.projection.clip_rows`.
    eye : Eye
        Its errors are those of the clip coordinates computed here.
    screen : (V, 4) float64
        Receives X to ERROR of each vertex.
    extent : (n, 5) float64
        Receives first and end column, first and end line, and a bound of the least key depth.

    Returns
    -------
    int
        How many vertices are not certain within ``PRECISE``.
    """
    uncertain, matrix = 0, entries(rows)
    for share in prange(SHARES):
        # Project this share of the vertices.
        first, end = share_of(vertices.shape[1], share)
        for start in range(first, end, SIDE_BY_SIDE):
            stop = min(start + SIDE_BY_SIDE, end)
            uncertain += project(vertices, start, stop, matrix, eye, screen, start)

        # Find what this share of the clusters may cover.
        first, end = share_of(low.shape[1], share)
        for start in range(first, end, SIDE_BY_SIDE):
            reach(low, high, start, min(start + SIDE_BY_SIDE, end), matrix, eye, extent)
    return uncertain


@jit
def share_of(count: int, share: int) -> tuple[int, int]:
    """Return the first and the end of one of ``SHARES`` equal shares."""
    return count * share // SHARES, count * (share + 1) // SHARES


@jit
def reach(low: Floats, high: Floats, first: int, end: int, matrix: Matrix, eye: Eye, extent: Floats) -> None:
    """Find what some boxes may cover, at most SIDE_BY_SIDE of them."""
    count, start = np.uintp(end - first), np.uintp(first)
    parts = np.empty(5 * SIDE_BY_SIDE)
    for i in range(count):
        box_low = low[0, start + i], low[1, start + i], low[2, start + i]
        box_high = high[0, start + i], high[1, start + i], high[2, start + i]
        left, right, top, bottom, nearest = reach_box(box_low, box_high, matrix, eye)
        parts[i], parts[SIDE_BY_SIDE + i], parts[2 * SIDE_BY_SIDE + i] = left, right, top
        parts[3 * SIDE_BY_SIDE + i], parts[4 * SIDE_BY_SIDE + i] = bottom, nearest
    for i in range(count):
        for k in range(np.uintp(5)):
            extent[start + i, k] = parts[np.uintp(SIDE_BY_SIDE) * k + i]


@jit
def reach_box(low: Point, high: Point, matrix: Matrix, eye: Eye) -> tuple[float, float, float, float, float]:
    """Return what one box may cover; one with a corner at or behind the eye, anything."""
    # Project the eight corners: the box covers no more than their bounding box, and is no nearer.
    left, right, top, bottom, nearest, error = np.inf, -np.inf, np.inf, -np.inf, -np.inf, 0.0
    for bits in range(8):
        px = high[0] if bits & 1 else low[0]
        py = high[1] if bits & 2 else low[1]
        pz = high[2] if bits & 4 else low[2]
        x, y, nearness, corner_error = projected(px, py, pz, matrix, eye)
        left, right, top, bottom = min(left, x), max(right, x), min(top, y), max(bottom, y)
        nearest, error = max(nearest, nearness), max(error, corner_error)

    # Count in the errors.
    first_column, end_column = samples_between(left, right, error, eye.width)
    first_line, end_line = samples_between(top, bottom, error, eye.height)
    z = key_depth(nearest, eye) - nearness_error(nearest, eye) * eye.scale
    certain = error <= PRECISE
    return (
        first_column if certain else 0.0,
        end_column if certain else eye.width,
        first_line if certain else 0.0,
        end_line if certain else eye.height,
        z if certain else -np.inf,
    )


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
    place = np.cumsum(place)
    tiles = np.empty((number, 4), np.int64)
    for k, tile in enumerate(to_and_fro(np.argsort(place[:-1] - place[1:], kind="mergesort"), threads)):
        tiles[k] = tile // columns, tile % columns, place[tile], place[tile + 1]

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
    start = np.cumsum(start)
    order = np.empty(start[-1], np.int32)
    for m in range(len(extent)):
        if inside[m] > 0:
            order[start[inside[m] - 1]] = m
            start[inside[m] - 1] += 1
    return order


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
        tile = empty_tile(todo[k, 0], todo[k, 1], image, eye)
        draw_clusters(triangles, extent, listed[todo[k, 2] : todo[k, 3]], tile, eye, room, counts[k])
        finish(tile, crossing, image, eye, room, counts[k])


@jit
def empty_tile(row: int, column: int, image: Image, eye: Eye) -> Tile:
    """Return a tile of the image with nothing in it."""
    faces, face, _ = image
    lines, columns = min(LINES, face.shape[0] - row * LINES), min(COLUMNS, face.shape[1] - column * COLUMNS)
    keys = np.full((lines, columns + LANES), EMPTY, np.int64)
    farthest = np.full((LINES // CELL, COLUMNS // CELL), np.inf)
    return tile_of(row, column, keys, farthest, face.shape[1], len(faces), eye)


@jit
def tile_of(row: int, column: int, keys: Array, farthest: Floats, width: int, pieces: int, eye: Eye) -> Tile:
    """Return a tile of an image so wide, with what it shows, not drawn to yet."""
    mask = fill.depth_mask(pieces)
    stale, drawn = np.zeros(farthest.shape, np.bool_), np.zeros(farthest.shape, np.bool_)
    gap = fill.gap_of(mask, eye.tie)
    return Tile(row * LINES, column * COLUMNS, width, mask, gap, keys, farthest, stale, drawn)


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
        cells = cells_of(extent[m, 0], extent[m, 1], extent[m, 2], extent[m, 3], tile)
        if is_hidden(extent[m, 4], cells, tile):
            counts[HIDDEN] += 1
            continue
        counts[DRAWN] += 1
        n = gather(screen, corner, cull, m * CLUSTER, table)
        set_up(table, n, eye)
        draw_table(table, n, tile, eye, doubts, counts)
        touch(tile, cells)


@jit
def finish(tile: Tile, crossing: Floats, image: Image, eye: Eye, doubts: Array | None, counts: Array) -> None:
    """Draw what no cluster and no hierarchy has, settle what is in doubt, and read the answer out."""
    tile.drawn[:] |= len(crossing) > 0
    for t in range(len(crossing)):
        draw_table(crossing[t], CLUSTER, tile, eye, doubts, counts)
    if doubts is not None:
        fill.settle(tile, doubts, counts)
    show(tile, image, eye)


@jit
def show(tile: Tile, image: Image, eye: Eye) -> None:
    """Read out those cells of a tile that were drawn to; the others show what they showed before."""
    _, face, _ = image
    lines, columns = min(LINES, len(face) - tile.line), min(COLUMNS, face.shape[1] - tile.column)
    for row in range(-(-lines // CELL)):
        start = 0
        while start < columns:
            end = min(end_of_run(tile.drawn[row], start // CELL) * CELL, columns)
            if tile.drawn[row, start // CELL]:
                box = (row * CELL, min((row + 1) * CELL, lines), start, end)
                fill.read_out(tile, box, image, eye)
            start = end


@jit
def end_of_run(drawn: Bools, cell: int) -> int:
    """Return the first cell after one that is not as it is."""
    end = cell + 1
    while end < len(drawn) and drawn[end] == drawn[cell]:
        end += 1
    return end


@jit
def draw_table(table: Floats, n: int, tile: Tile, eye: Eye, doubts: Array | None, counts: Array) -> None:
    """Draw the first n triangles of a table, but for those behind all that their cells were known to show."""
    for i in range(n):
        # Leave out what is left out, outside the tile, or hidden.
        if not table[TOP + i] < table[BOTTOM + i]:
            continue
        cells = cells_of(table[LEFT + i], table[RIGHT + i], table[TOP + i], table[BOTTOM + i], tile)
        if is_behind(table[NEAREST + i], cells, tile):
            continue
        counts[TRIANGLES] += 1

        # Fill the keys, and note what is in doubt.
        if not fill.is_certain(table, i, eye) and doubts is not None:
            fill.suspect(table, i, tile, doubts, counts)
        elif table[CUT + i] != 0.0:
            draw(table, i, tile, fill.limits_of(table, i, eye), doubts, counts)
        else:
            draw(table, i, tile, None, doubts, counts)


@inline_jit
def draw(
    table: Floats, i: int, tile: Tile, limits: Limits | None, doubts: Array | None, counts: Array
) -> None:
    """Draw a triangle that is certain, and note where it is in doubt."""
    doubtful = fill.fill(table, i, tile, limits, None if doubts is None else True)
    if doubts is not None and doubtful:
        fill.note(table, i, tile, limits, doubts, counts)


# ---------------------------------------------------------------- cells


@jit
def cells_of(left: float, right: float, top: float, bottom: float, tile: Tile) -> Cells:
    """Return the cells of the samples of a tile in a box of the image; none if there are none."""
    lines, columns = len(tile.keys), tile.keys.shape[1] - LANES
    first_line, end_line = max(int(top) - tile.line, 0), min(int(bottom) - tile.line, lines)
    first_column, end_column = max(int(left) - tile.column, 0), min(int(right) - tile.column, columns)
    if first_line >= end_line or first_column >= end_column:
        return 0, 0, 0, 0
    first_cell, end_cell = first_column // CELL, (end_column - 1) // CELL + 1
    return first_line // CELL, (end_line - 1) // CELL + 1, first_cell, end_cell


@jit
def touch(tile: Tile, cells: Cells) -> None:
    """Note that some cells were drawn to."""
    tile.stale[cells[0] : cells[1], cells[2] : cells[3]] = True
    tile.drawn[cells[0] : cells[1], cells[2] : cells[3]] = True


@jit
def is_hidden(nearest: float, cells: Cells, tile: Tile) -> bool:
    """Whether a key depth lies behind all that some cells show; looks again at those drawn to since.

    Where there are no cells, it does.
    """
    # Nothing gets farther: what was known of a cell is still a bound.
    z, farthest = nearest - depth_gap(tile.gap), tile.farthest
    for row in range(cells[0], cells[1]):
        for column in range(cells[2], cells[3]):
            if not z > farthest[row, column] and not tile.stale[row, column]:
                return False
    for row in range(cells[0], cells[1]):
        for column in range(cells[2], cells[3]):
            if not z > farthest[row, column]:
                tile.stale[row, column] = False
                farthest[row, column] = farthest_in(tile.keys, row * CELL, column * CELL)
                if not z > farthest[row, column]:
                    return False
    return True


@jit
def is_behind(nearest: float, cells: Cells, tile: Tile) -> bool:
    """Whether a key depth lies behind all that some cells were known to show; if there are none, it does."""
    z = nearest - depth_gap(tile.gap)
    for row in range(cells[0], cells[1]):
        for column in range(cells[2], cells[3]):
            if not z > tile.farthest[row, column]:
                return False
    return True


@jit
def farthest_in(keys: Array, row: int, column: int) -> float:
    """Return the greatest key depth in a cell, ``inf`` if some sample is empty."""
    greatest = np.int64(0)
    for line in range(row, min(row + CELL, len(keys))):
        for lane in range(CELL):
            greatest = max(greatest, keys[line, np.uintp(column + lane)])
    return depth_of(int(greatest)) if greatest != EMPTY else np.inf
