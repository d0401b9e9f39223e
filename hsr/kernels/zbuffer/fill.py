"""Tiles of the image: where triangles certainly are, the nearest; what is in doubt; the answer.

Depth and owner of a sample share one integer of 63 bits, the *key*: depth in the upper bits, the number of
the triangle in the lower ones. The nearest triangle has the least key, and one minimum does the depth test
and both writes. Sixteen samples of a scan line are tested at once.

What float64 cannot decide is not decided here: only certain coverage enters the keys. A sample on an edge,
within the error of the edge functions, or two depths within their error, is a *doubt*: every triangle that
might own the sample is noted, unless something certain is certainly nearer. When all is drawn, the doubts are
settled: at a sample without any the key is right, and at one with some the owner is among what was noted. The
order in which triangles come leaves no trace.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.base.jit import inline_jit, jit
from hsr.kernels.zbuffer.setup import (
    ACROSS0,
    ACROSS1,
    ACROSS2,
    AREA,
    BELOW0,
    BELOW1,
    BELOW2,
    BOTTOM,
    BOUND,
    CLOSEST,
    CLUSTER,
    CUT,
    E0,
    E1,
    E2,
    LANES,
    LEFT,
    NEAREST,
    NUMBER,
    RIGHT,
    TOP,
    Z_ERROR,
    Z_X,
    Z_Y,
    Eye,
    Z,
)

EMPTY = np.int64(2**63 - 1)
"""The key of a sample that no triangle owns."""

SHIFT = np.int64(11)
"""By how much the 52 bits after the binary point of a key depth are shifted, to be the upper ones of 63."""

ONE = np.float64(1.0).view(np.int64)
"""Sign and exponent of every key depth."""

LINES, COLUMNS = 128, 512
"""Size in samples of a tile, the piece of work of one thread. Its keys stay in the cache of a core, and a
line of its depths is a page of memory: narrow tiles took three times as long to read out."""

CELL = 8
"""Side in samples of the cells whose farthest depth is known."""

WIDE = 3 * LANES
"""From this width on, the samples of a scan line that a triangle can cover are worked out first."""

DOUBT = np.dtype([("sample", np.int64), ("key", np.int64), ("sure", np.bool_)])
"""A triangle that may own a sample, by its key; whether it certainly covers it."""

USED, TRIANGLES = 0, 1
"""Columns of the counts of a tile: doubts noted, whether or not there was room; triangles drawn."""

Image = tuple[Ints, Ints, Floats]
"""The face (n,) int32 of each triangle or piece; face (H, W) int32 and depth (H, W) float64 of the image."""

OnLine = tuple[float, float, float, float, float, float, float, float]
"""A triangle on a scan line: three edge functions and the key depth at the first sample of its bounding box,
each with its growth from sample to sample."""

Box = tuple[int, int, int, int]
"""First and end line, first and end column of some samples."""

Cells = tuple[int, int, int, int]
"""First and end row, first and end column of some cells of a tile."""

Limits = tuple[float, float, float]
"""Key depths of near and far, and what makes their errors those of an edge function."""


class Tile(NamedTuple):
    """A part of the image that is being drawn.

    Attributes
    ----------
    line, column : int
        Its first in the image.
    end_line, end_column : int
        Those after its last.
    width : int
        Columns of the image.
    mask : int
        The bits of a key that are depth.
    gap : int
        By how much keys differ at most whose depths may be equal.
    keys : (lines, columns + LANES) int64
        Those beyond the last column are not used.
    farthest : (cells down, cells across) float64
        The farthest key depth that a cell was known to show.
    stale, drawn : (cells down, cells across) bool
        Whether a cell was drawn to since then, and whether it was at all.
    """

    line: int
    column: int
    end_line: int
    end_column: int
    width: int
    mask: int
    gap: int
    keys: Array
    farthest: Floats
    stale: Bools
    drawn: Bools


# ---------------------------------------------------------------- keys


@jit
def depth_mask(triangles: int) -> int:
    """Return the bits of a key that are depth; the others tell so many triangles apart."""
    bits = SHIFT
    while triangles >> bits > 0:
        bits += 1
    return int((EMPTY >> np.int64(bits)) << np.int64(bits))


@jit
def key_of(z: float, mask: int, number: int) -> int:
    """Return the key of a triangle at a key depth within [1, 2)."""
    return int(((np.float64(z).view(np.int64) << SHIFT) & mask) | number)


@jit
def depth_of(key: int) -> float:
    """Return the key depth of a key."""
    return np.int64((key >> SHIFT) | ONE).view(np.float64)


@jit
def gap_of(mask: int, tie: float) -> int:
    """Return by how much keys differ at most whose depths, each within ``tie``, may be equal."""
    return int(tie * 2.0**64) + 2 * int(EMPTY - mask) + 2


@jit
def depth_gap(gap: int) -> float:
    """Return by how much key depths differ at least if their keys, cut off, differ by more than ``gap``."""
    return gap * 2.0**-63


# ---------------------------------------------------------------- tiles


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
    mask = depth_mask(pieces)
    stale, drawn = np.zeros(farthest.shape, np.bool_), np.zeros(farthest.shape, np.bool_)
    line, left, gap = row * LINES, column * COLUMNS, gap_of(mask, eye.tie)
    end_line, end_column = line + keys.shape[0], left + keys.shape[1] - LANES
    return Tile(line, left, end_line, end_column, width, mask, gap, keys, farthest, stale, drawn)


@jit
def cells_of(left: float, right: float, top: float, bottom: float, tile: Tile) -> Cells:
    """Return the cells of the samples of a tile in a box of the image; none if there are none."""
    first_line, end_line = max(int(top), tile.line) - tile.line, min(int(bottom), tile.end_line) - tile.line
    first_column = max(int(left), tile.column) - tile.column
    end_column = min(int(right), tile.end_column) - tile.column
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
    z, keys, farthest, stale = nearest - depth_gap(tile.gap), tile.keys, tile.farthest, tile.stale
    for row in range(cells[0], cells[1]):
        for column in range(cells[2], cells[3]):
            if not z > farthest[row, column] and not stale[row, column]:
                return False
    for row in range(cells[0], cells[1]):
        for column in range(cells[2], cells[3]):
            if not z > farthest[row, column]:
                stale[row, column] = False
                farthest[row, column] = farthest_in(keys, row * CELL, column * CELL)
                if not z > farthest[row, column]:
                    return False
    return True


@jit
def is_behind(nearest: float, cells: Cells, tile: Tile) -> bool:
    """Whether a key depth lies behind all that some cells were known to show; if there are none, it does."""
    z, farthest = nearest - depth_gap(tile.gap), tile.farthest
    for row in range(cells[0], cells[1]):
        for column in range(cells[2], cells[3]):
            if not z > farthest[row, column]:
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


# ---------------------------------------------------------------- drawing


@jit
def draw_table(table: Floats, n: np.uintp, tile: Tile, eye: Eye, doubts: Array | None, counts: Array) -> None:
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
        if not is_certain(table, i, eye) and doubts is not None:
            suspect(table, i, tile, doubts, counts)
        elif table[CUT + i] != 0.0:
            draw(table, i, tile, limits_of(table, i, eye), doubts, counts)
        else:
            draw(table, i, tile, None, doubts, counts)


@inline_jit
def draw(
    table: Floats, i: int, tile: Tile, limits: Limits | None, doubts: Array | None, counts: Array
) -> None:
    """Draw a triangle that is certain, and note where it is in doubt."""
    doubtful = fill(table, i, tile, limits, None if doubts is None else True)
    if doubts is not None and doubtful:
        note(table, i, tile, limits, doubts, counts)


@jit
def is_certain(table: Floats, i: int, eye: Eye) -> bool:
    """Whether it is certain which way a triangle of a table is turned, and how deep it is."""
    return bool(table[AREA + i] > table[BOUND + i] and table[Z_ERROR + i] <= eye.tie)


@jit
def limits_of(table: Floats, i: int, eye: Eye) -> Limits:
    """Return the limits of a triangle's depth."""
    return eye.near, eye.far, table[BOUND + i] / eye.tie


@inline_jit
def fill(table: Floats, i: int, tile: Tile, limits: Limits | None, certify: bool | None) -> bool:
    """Take a triangle into the keys of a tile: where it is certainly inside, and certainly nearer.

    Parameters
    ----------
    table : (TABLE,) float64
    i : int
        Its place in the table.
    tile : Tile
    limits : Limits or None
        Of its depth, if it may be cut.
    certify : bool or None
        None leaves doubts alone: what is undecided goes to the side it seems to be on.

    Returns
    -------
    bool
        Whether it has doubts, see :func:`note`.
    """
    left, top = int(table[LEFT + i]), int(table[TOP + i])
    begin, end = columns_of(table, i, tile)
    bound = 0.0 if certify is None else table[BOUND + i]
    gap = np.int64(0) if certify is None else tile.gap
    keys, mask, number, doubtful = tile.keys, tile.mask, int(table[NUMBER + i]), False
    for line in lines_of(table, i, tile):
        # Find the part of the line that the triangle can cover.
        row = row_of(table, i, float(line - top))
        here = keys[line - tile.line]
        first, last = begin, end
        if end - begin > WIDE:
            first, last = span_of(row, bound, left, begin, end)

        # Keep the lesser key wherever the triangle is certainly inside, LANES samples at once.
        for start in range(first, last, LANES):
            here_doubtful = False
            for lane in range(LANES):
                inner, z = at(row, float(start - left + lane), limits)
                key = key_of(z, mask, number)
                place = np.uintp(start - tile.column + lane)
                old = here[place]
                inside, nearer_by = inner >= bound, old - key
                here[place] = key if inside & (nearer_by > gap) else old
                if certify is not None:
                    here_doubtful |= (abs(inner) < bound) | (inside & (abs(nearer_by) <= gap))
            doubtful |= here_doubtful
    return doubtful


@jit
def lines_of(table: Floats, i: int, tile: Tile) -> range:
    """Return the lines of a tile that a triangle may cover."""
    return range(max(int(table[TOP + i]), tile.line), min(int(table[BOTTOM + i]), tile.end_line))


@jit
def columns_of(table: Floats, i: int, tile: Tile) -> tuple[int, int]:
    """Return the first column of a tile that a triangle may cover, and the one after the last."""
    return max(int(table[LEFT + i]), tile.column), min(int(table[RIGHT + i]), tile.end_column)


@jit
def row_of(table: Floats, i: int, down: float) -> OnLine:
    """Return a triangle on the scan line that is ``down`` below the first of its bounding box."""
    return (
        table[E0 + i] + down * table[BELOW0 + i],
        table[ACROSS0 + i],
        table[E1 + i] + down * table[BELOW1 + i],
        table[ACROSS1 + i],
        table[E2 + i] + down * table[BELOW2 + i],
        table[ACROSS2 + i],
        table[Z + i] + down * table[Z_Y + i],
        table[Z_X + i],
    )


@jit
def at(row: OnLine, right: float, limits: Limits | None) -> tuple[float, float]:
    """Return the least of what must be positive inside, and the key depth."""
    inner = min(min(row[0] + right * row[1], row[2] + right * row[3]), row[4] + right * row[5])
    z = row[6] + right * row[7]
    if limits is not None:
        inner = min(inner, min((z - limits[0]) * limits[2], (limits[1] - z) * limits[2]))
    return inner, z


@jit
def span_of(row: OnLine, bound: float, left: int, begin: int, end: int) -> tuple[int, int]:
    """Return the columns from begin to end at which no edge function is below ``-bound``."""
    # An edge function e + right * across is, on one side of -(e + bound) / across. The quotient is off by a
    # few ulp, less than a sample within any image; one sample is added at either end.
    low, high = float(begin - left), float(end - left)
    for edge in range(3):
        e, across = (row[0], row[1]) if edge == 0 else (row[2], row[3]) if edge == 1 else (row[4], row[5])
        if across > 0.0:
            low = max(low, -(e + bound) / across - 1.0)
        elif across < 0.0:
            high = min(high, -(e + bound) / across + 2.0)
        elif e < -bound:
            high = low
    low = min(low, float(end - left))
    return left + int(low), left + int(max(high, low))


# ---------------------------------------------------------------- doubts


@jit
def note(table: Floats, i: int, tile: Tile, limits: Limits | None, doubts: Array, counts: Array) -> None:
    """Note the doubts of a triangle that has just been taken into the keys.

    What it ties with need not be written down: either the keys still show it in the end, see :func:`settle`,
    or it is certainly hidden.
    """
    left, top, bound = int(table[LEFT + i]), int(table[TOP + i]), table[BOUND + i]
    begin, end = columns_of(table, i, tile)
    keys, gap, number = tile.keys, tile.gap, int(table[NUMBER + i])
    for line in lines_of(table, i, tile):
        row = row_of(table, i, float(line - top))
        for column in range(begin, end):
            inner, z = at(row, float(column - left), limits)
            key, old = key_of(z, tile.mask, number), keys[line - tile.line, column - tile.column]
            sample = line * tile.width + column

            # Note an edge that rounding decides, and a depth that may be equal to what is shown.
            if abs(inner) < bound:
                if not is_farther(key, old, gap):
                    write(doubts, counts, sample, key, False)
            elif inner >= bound and key != old and abs(old - key) <= gap:
                write(doubts, counts, sample, key, True)


@jit
def suspect(table: Floats, i: int, tile: Tile, doubts: Array, counts: Array) -> None:
    """Note a triangle of which little is certain wherever it may be.

    It may be turned either way, and is taken to be as near as its nearest corner.
    """
    left, top, bound = int(table[LEFT + i]), int(table[TOP + i]), table[BOUND + i]
    begin, end = columns_of(table, i, tile)
    key = key_of(max(table[NEAREST + i], 1.0), tile.mask, int(table[NUMBER + i]))
    for line in lines_of(table, i, tile):
        row = row_of(table, i, float(line - top))
        for column in range(begin, end):
            right = float(column - left)
            e0, e1, e2 = row[0] + right * row[1], row[2] + right * row[3], row[4] + right * row[5]
            may_cover = min(min(e0, e1), e2) > -bound or max(max(e0, e1), e2) < bound
            old = tile.keys[line - tile.line, column - tile.column]
            if may_cover and not is_farther(key, old, tile.gap):
                write(doubts, counts, line * tile.width + column, key, False)


@jit
def is_farther(key: int, old: int, gap: int) -> bool:
    """Whether a key is certainly farther than what is there."""
    return bool(key - old > gap)


@jit
def write(doubts: Array, counts: Array, sample: int, key: int, sure: bool) -> None:
    """Note one doubt, if there is room."""
    if counts[USED] < len(doubts):
        doubt = doubts[counts[USED]]
        doubt["sample"], doubt["key"], doubt["sure"] = sample, key, sure
    counts[USED] += 1


@jit
def settle(tile: Tile, doubts: Array, counts: Array) -> None:
    """Forget doubts about what is certainly hidden; where some are left, add what the keys show."""
    if counts[USED] > len(doubts):
        return
    # Forget what is certainly hidden.
    kept = 0
    for k in range(counts[USED]):
        doubt = doubts[k]
        line, column = divmod(doubt["sample"], tile.width)
        if not is_farther(doubt["key"], tile.keys[line - tile.line, column - tile.column], tile.gap):
            left = doubts[kept]
            left["sample"], left["key"], left["sure"] = doubt["sample"], doubt["key"], doubt["sure"]
            kept += 1
    counts[USED] = kept

    # Add what is shown wherever a doubt is left: it is a candidate, too.
    for k in range(kept):
        sample = doubts[k]["sample"]
        line, column = divmod(sample, tile.width)
        key = tile.keys[line - tile.line, column - tile.column]
        if key != EMPTY:
            write(doubts, counts, sample, key, True)


# ---------------------------------------------------------------- reading out


@jit
def finish(tile: Tile, crossing: Floats, image: Image, eye: Eye, doubts: Array | None, counts: Array) -> None:
    """Draw what no cluster and no hierarchy has, settle what is in doubt, and read the answer out."""
    if len(crossing) > 0:
        tile.drawn[:] = True
    for t in range(len(crossing)):
        draw_table(crossing[t], np.uintp(CLUSTER), tile, eye, doubts, counts)
    if doubts is not None:
        settle(tile, doubts, counts)
    show(tile, image, eye)


@jit
def show(tile: Tile, image: Image, eye: Eye) -> None:
    """Read out those cells of a tile that were drawn to; the others show what they showed before."""
    _, face, _ = image
    lines, columns = min(LINES, len(face) - tile.line), min(COLUMNS, face.shape[1] - tile.column)
    for row in range(-(-lines // CELL)):
        start = int(np.int64(0))
        while start < columns:
            end = min(end_of_run(tile.drawn[row], start // CELL) * CELL, columns)
            if tile.drawn[row, start // CELL]:
                box = (row * CELL, min((row + 1) * CELL, lines), start, end)
                read_out(tile, box, image, eye)
            start = end


@jit
def end_of_run(drawn: Bools, cell: int) -> int:
    """Return the first cell after one that is not as it is."""
    end = cell + 1
    while end < len(drawn) and drawn[end] == drawn[cell]:
        end += 1
    return end


@jit
def read_out(tile: Tile, box: Box, image: Image, eye: Eye) -> None:
    """Split the keys of a box of samples of a tile into faces and depths of the image."""
    # Depths were cut off below the bits of the mask: on average by half a step. What keys cannot tell from
    # infinity is as far as what is farthest.
    step, half = 1.0 / eye.scale, 0.5 * (depth_of(int(EMPTY - tile.mask)) - 1.0)
    first, end, left = np.uintp(box[2]), np.uintp(box[3]), np.uintp(tile.column)
    faces, face, depth = image
    for line in range(box[0], box[1]):
        here, faces_here, depths_here = tile.keys[line], face[tile.line + line], depth[tile.line + line]

        # Turn keys into depths.
        for column in range(first, end):
            key = here[column]
            nearness = max(eye.closest - (depth_of(key & tile.mask) + half - CLOSEST) * step, eye.farthest)
            seen = 1.0 / nearness if eye.perspective else -nearness
            depths_here[left + column] = seen if key != EMPTY else np.inf

        # Turn keys into faces.
        for column in range(first, end):
            key = here[column]
            owner = faces[np.uintp(key & ~tile.mask)] if key != EMPTY else np.int32(-1)
            faces_here[left + column] = owner
