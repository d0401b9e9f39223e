"""Triangles on the screen as three half-planes and a plane of depth, with proven error bounds.

A sample is inside a triangle if it is on the inner side of all three edges (Pineda, "A Parallel
Algorithm for Polygon Rasterization", SIGGRAPH 1988). Each side is the sign of an edge function, affine
on the screen. All is computed in float64, and every number comes with a bound of its error, so that a
sign beyond the bound is proven (the static filters of Shewchuk, "Adaptive Precision Floating-Point
Arithmetic and Fast Robust Geometric Predicates", 1997). In the derivations u is 2^-53, the relative
error of one rounding; constants are rounded up generously, by a factor of two or so.

On the screen x runs right and y down, in pixels; sample (row r, column c) is ``(c + 0.5, r + 0.5)``.
Depth is nearness: 1 / d under perspective, -d in a parallel view, d along the view axis; the greater,
the nearer; both are affine on the screen for the points of a plane. It is scaled to a *key depth* z
that grows with distance from :data:`CLOSEST`, the nearest that may be seen, to :data:`FARTHEST`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.base.jit import jit, parallel_jit, prange
from hsr.kernels.culling import CULL_BACK, CULL_FRONT
from hsr.kernels.projection import nearness_of

U = 2.0**-53
"""Greatest relative error of one rounding."""

SMALL = 2.0**-969
"""The least normal number, divided by U. A rounding is off by at most U times the magnitude, or U times this
where it underflows."""

CLOSEST, FARTHEST = 1.125, 1.875
"""Key depths of what is nearest and farthest: within [1, 2), where all float64 have one exponent."""

TIE = 2.0**-36
"""Least error of a key depth, in which all that may be seen lies 0.75 apart, that counts as certain."""

COARSE = 2.0**-5
"""Greatest error that does: the farthest keys are further than twice that from the empty one."""

TINY = float(np.finfo(float).tiny)
"""The least normal number: no depth that is certain is less."""

MOST = float(np.finfo(float).max)
"""The greatest number."""

HUGE = 2.0**900
"""An error of clip coordinates beyond which nothing is certain. Where it is less, these are below 2^949."""

PRECISE = 2.0**-4
"""Greatest error of a projected vertex, in pixels, with which its triangles are set up here."""

X, Y, NEARNESS, ERROR = range(4)
"""Columns of the projected vertices: pixels from the top left corner of the image, nearness, and how far
the true x and y may be away: ``ANYWHERE`` for a vertex at or behind the eye."""

ANYWHERE = 2.0**99
"""An error beyond all images."""

SIDE_BY_SIDE = 256
"""Most vertices projected at once."""

SHARES = 64
"""In which vertices and clusters are laid out: both at once, for it takes time to wake threads."""

Point = tuple[float, float, float]

Matrix = tuple[float, float, float, float, float, float, float, float, float, float, float, float]
"""The entries of three rows of four."""

CLUSTER = 32
"""Triangles in a table, set up side by side. Its parts follow each other, CLUSTER numbers each, in one array
of one dimension: so the compiler knows them apart."""

E0, E1, E2, ACROSS0, ACROSS1, ACROSS2, BELOW0, BELOW1, BELOW2, BOUND, AREA = range(0, 11 * CLUSTER, CLUSTER)
"""Where the parts of a table begin: the edge functions at the first sample of a triangle's bounding box,
positive inside, what they grow by from sample to sample to the right and below, a bound of their error, and
twice the area, within the same bound."""

Z, Z_X, Z_Y, Z_ERROR, NEAREST = range(11 * CLUSTER, 16 * CLUSTER, CLUSTER)
"""The key depth there, its growth to the right and below, a bound of its error wherever the triangle is, and
one of the least key depth of its corners."""

LEFT, RIGHT, TOP, BOTTOM, CUT, NUMBER = range(16 * CLUSTER, 22 * CLUSTER, CLUSTER)
"""The first column and row that a triangle may cover, and those after the last (no rows if it is left out);
whether the near or the far plane may cut it; its number."""

GATHERED, CULL = 22 * CLUSTER, 34 * CLUSTER
"""Where the corners gathered for the set-up begin: 12 parts, X to ERROR of each; then what is culled."""

TABLE = 35 * CLUSTER
"""Length of a table."""

LANES = 16
"""Samples tested at once: up to LANES - 1 to the right of a bounding box are tested with it."""


class Eye(NamedTuple):
    """What the kernels know of a view.

    Attributes
    ----------
    perspective : bool
    width, height : float
        Of the image, in pixels.
    error_x, error_y, error_d : float
        Bounds of the errors of clip coordinates.
    closest, farthest : float
        Nearness of the nearest and the farthest that may be seen.
    scale : float
        Key depth is ``CLOSEST + (closest - nearness) * scale``.
    near, far : float
        Key depths of the near and the far plane.
    tie : float
        Greatest error of a key depth that counts as certain; depths further apart than twice that differ.
    """

    perspective: bool
    width: float
    height: float
    error_x: float
    error_y: float
    error_d: float
    closest: float
    farthest: float
    scale: float
    near: float
    far: float
    tie: float


@jit
def eye_around(
    perspective: bool,
    size: tuple[int, int],
    limits: tuple[float, float],
    rows: Floats,
    box: Floats,
    slack: Floats,
) -> Eye:
    """Measure a view of what lies in a box.

    Clip coordinates are sums of three products and an offset, by rows that were divided once, and depth is
    taken for w: fewer than sixteen roundings, each of at most the sum of the magnitudes.

    Parameters
    ----------
    perspective : bool
    size : (width, height)
        Of the image, in pixels.
    limits : (near, far)
        In scene units.
    rows : (3, 4) float64
        From world to clip space (x, y, d), see :func:`hsr.kernels.projection.clip_rows`.
    box : (2, 3) float64
        Opposite corners, world space.
    slack : (3,) float64
        By how much points may be off.
    """
    # Bound what rounding does to each clip coordinate, and what the points may be off.
    error, least, most = np.empty(3), rows[2, 3], rows[2, 3]
    for k in range(3):
        error[k] = 16.0 * U * (abs(rows[k, 3]) + SMALL)
        for axis in range(3):
            bound = abs(rows[k, axis]) + SMALL
            reach = max(abs(box[0, axis]), abs(box[1, axis]))
            error[k] += 16.0 * U * bound * reach + bound * slack[axis]

    # Find the least and the greatest depth of the box.
    for axis in range(3):
        one, other = rows[2, axis] * box[0, axis], rows[2, axis] * box[1, axis]
        least, most = least + min(one, other), most + max(one, other)
    width, height = float(size[0]), float(size[1])
    return eye_between(perspective, (width, height), (error[0], error[1], error[2]), limits, (least, most))


@jit
def eye_between(
    perspective: bool,
    size: tuple[float, float],
    error: tuple[float, float, float],
    limits: tuple[float, float],
    seen: tuple[float, float],
) -> Eye:
    """Measure a view of which all lies between two depths.

    Parameters
    ----------
    perspective : bool
    size : (width, height)
        Of the image, in pixels.
    error : (x, y, d)
        Bounds of the errors of clip coordinates.
    limits : (near, far)
        Depths in scene units, and so are the following.
    seen : (least, most)
    """
    # Where clip coordinates come near to overflow, be certain of nothing.
    x, y, d = error
    least, most = seen
    if not (x < HUGE and y < HUGE and d < HUGE):
        x, y, d = MOST, MOST, MOST
        least, most = limits[0], min(limits[1], MOST)

    # Find the nearness of the nearest and the farthest that may be seen.
    width, height = size
    least = min(max(least, limits[0]), limits[1])
    closest = nearness_at(least, perspective)
    farthest = nearness_at(max(min(most, limits[1]), least), perspective)
    eye = Eye(perspective, width, height, x, y, d, closest, farthest, 0.0, 0.0, 0.0, 0.0)

    # Spread key depths over what may be seen, but not over less than can be told apart.
    slack = nearness_error(closest, eye)
    apart = max(max(closest - farthest, 2.0**-12 * max(abs(closest), abs(farthest))), max(slack, TINY))
    scale = (FARTHEST - CLOSEST) / min(apart, 1.0 / TINY)
    tie = min(max(TIE, 4.0 * slack * scale), COARSE)
    near = CLOSEST + (closest - nearness_at(limits[0], perspective)) * scale
    far = CLOSEST + (closest - nearness_at(limits[1], perspective)) * scale
    return Eye(perspective, width, height, x, y, d, closest, farthest, scale, near, far, tie)


@jit
def nearness_at(depth: float, perspective: bool) -> float:
    """Return the nearness of a depth, but not more than is certain of any."""
    return min(nearness_of(depth, perspective), 1.0 / TINY)


# ---------------------------------------------------------------- vertices and boxes


@jit
def entries(rows: Floats) -> Matrix:
    """Return the entries of a matrix (3, 4), row by row, as numbers that no array can share."""
    x, y, d = rows[0], rows[1], rows[2]
    return x[0], x[1], x[2], x[3], y[0], y[1], y[2], y[3], d[0], d[1], d[2], d[3]


@jit
def project(
    vertices: Floats, first: int, end: int, matrix: Matrix, eye: Eye, screen: Floats, target: int
) -> int:
    """Project some vertices, and bound the errors.

    Parameters
    ----------
    vertices : (3, V) float64
        Coordinate by coordinate: so they are projected side by side.
    first, end : int
        At most SIDE_BY_SIDE of them.
    matrix : Matrix
        To clip space (x, y, d), see :func:`hsr.kernels.projection.clip_rows`.
    eye : Eye
        Its errors are those of the clip coordinates computed here.
    screen : (v, 4) float64
        Receives X to ERROR of each, vertex by vertex: so one is read at once.
    target : int
        Place of the first one there.

    Returns
    -------
    int
        How many are not certain within ``PRECISE``.
    """
    # Project them side by side.
    count, start, uncertain = np.uintp(end - first), np.uintp(first), 0
    parts = np.empty(4 * SIDE_BY_SIDE)
    for i in range(count):
        px, py, pz = vertices[0, start + i], vertices[1, start + i], vertices[2, start + i]
        x, y, nearness, error = projected(px, py, pz, matrix, eye)
        parts[i], parts[SIDE_BY_SIDE + i] = x, y
        parts[2 * SIDE_BY_SIDE + i], parts[3 * SIDE_BY_SIDE + i] = nearness, error
        uncertain += not error <= PRECISE

    # Turn the four parts into one row for each vertex.
    for i in range(count):
        for k in range(np.uintp(4)):
            screen[np.uintp(target) + i, k] = parts[np.uintp(SIDE_BY_SIDE) * k + i]
    return uncertain


@jit
def projected(px: float, py: float, pz: float, matrix: Matrix, eye: Eye) -> tuple[float, float, float, float]:
    """Return X to ERROR of a point."""
    x = matrix[0] * px + matrix[1] * py + matrix[2] * pz + matrix[3]
    y = matrix[4] * px + matrix[5] * py + matrix[6] * pz + matrix[7]
    d = matrix[8] * px + matrix[9] * py + matrix[10] * pz + matrix[11]
    w = (1.0 / d if d != 0.0 else 0.0) if eye.perspective else 1.0
    nearness, error_w = (w, eye.error_d) if eye.perspective else (-d, 0.0)
    x, y = x * w, y * w

    # To first order x / d is off by (error_x + |x / d| error_d) / d and two roundings; scaling it to the
    # image rounds twice more numbers of at most |x / d| + 1. The width taken whole instead of half doubles
    # that, which covers the higher orders if error_d is less than half of d. What overflows may be anywhere.
    error_x = (eye.error_x + abs(x) * error_w) * w + 4.0 * U * (abs(x) + 1.0)
    error_y = (eye.error_y + abs(y) * error_w) * w + 4.0 * U * (abs(y) + 1.0)
    error = max(error_x * eye.width, error_y * eye.height)
    behind = eye.perspective & (not d > 2.0 * eye.error_d)
    certain = (error < ANYWHERE) & (not behind)
    column, row = (1.0 + x) * 0.5 * eye.width, (1.0 - y) * 0.5 * eye.height
    return column, row, nearness, error if certain else ANYWHERE


@jit
def nearness_error(nearness: float, eye: Eye) -> float:
    """Bound the error of a vertex's nearness."""
    if eye.perspective:
        # 1 / d is off by error_d / d^2 to first order, twice that if error_d is less than half of d, and by
        # two roundings.
        return nearness * (2.0 * nearness * eye.error_d + 2.0 * U)
    return eye.error_d


@jit
def key_depth(nearness: float, eye: Eye) -> float:
    """Return the key depth of a nearness."""
    return CLOSEST + (eye.closest - nearness) * eye.scale


@jit
def samples_between(least: float, most: float, error: float, count: float) -> tuple[float, float]:
    """Return the first of ``count`` samples in a row between two places, and the one after the last.

    Each place is within ``error`` of the true one; sample k lies at k + 0.5.
    """
    return np.ceil(max(least - error - 0.5, 0.0)), np.floor(min(most + error - 0.5, count - 1.0)) + 1.0


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


# ---------------------------------------------------------------- triangles


@jit
def gather(screen: Floats, corner: Ints, cull: Array, first: int, table: Floats) -> np.uintp:
    """Gather at most CLUSTER triangles into a table.

    Parameters
    ----------
    screen : (V, 4) float64
    corner : (n, 3) int32
        Counter-clockwise to the eye if seen from the front.
    cull : (n,) int8
        What not to draw: 0 nothing, 1 back faces, 2 front faces.
    first : int
        Number of the first triangle to gather.
    table : (TABLE,) float64
        Receives their corners, what they cull, and their numbers.

    Returns
    -------
    np.uintp
        How many there are: unsigned indices cannot count from the end, which would be tested at each.
    """
    n, start = np.uintp(min(len(corner) - first, CLUSTER)), np.uintp(first)
    for i in range(n):
        for k in range(np.uintp(3)):
            vertex, place = screen[np.uintp(corner[start + i, k])], np.uintp(GATHERED + 4 * CLUSTER * k) + i
            for part in range(np.uintp(4)):
                table[place + part * np.uintp(CLUSTER)] = vertex[part]
        table[np.uintp(CULL) + i], table[np.uintp(NUMBER) + i] = cull[start + i], start + i
    return n


@jit
def set_up(table: Floats, count: np.uintp, eye: Eye) -> None:
    """Set up the gathered triangles of a table side by side; without branches, to become vector code.

    Parameters
    ----------
    table : (TABLE,) float64
        Receives the other parts. Left out is what is culled, beyond near or far, beside the image, and what
        has a corner that is not certain within ``PRECISE``. Where AREA is not above BOUND, a triangle may be
        edge-on, or turned the other way; such are not culled.
    count : int
        How many triangles there are.
    eye : Eye
    """
    for i in range(count):
        ax, ay = table[GATHERED + i], table[GATHERED + CLUSTER + i]
        az, a_error = table[GATHERED + 2 * CLUSTER + i], table[GATHERED + 3 * CLUSTER + i]
        bx, by = table[GATHERED + 4 * CLUSTER + i], table[GATHERED + 5 * CLUSTER + i]
        bz, b_error = table[GATHERED + 6 * CLUSTER + i], table[GATHERED + 7 * CLUSTER + i]
        cx, cy = table[GATHERED + 8 * CLUSTER + i], table[GATHERED + 9 * CLUSTER + i]
        cz, c_error = table[GATHERED + 10 * CLUSTER + i], table[GATHERED + 11 * CLUSTER + i]
        t = max(max(a_error, b_error), c_error)

        # Find the samples that it may cover.
        least_x, most_x = min(min(ax, bx), cx), max(max(ax, bx), cx)
        least_y, most_y = min(min(ay, by), cy), max(max(ay, by), cy)
        left, right = samples_between(least_x, most_x, t, eye.width)
        top, bottom = samples_between(least_y, most_y, t, eye.height)

        # Take the edge functions of a -> b, b -> c and c -> a, turned inside out where the area is negative:
        # that of a front is, for y runs down.
        x, y = left + 0.5, top + 0.5
        ux, uy, vx, vy, wx, wy = bx - ax, by - ay, cx - bx, cy - by, ax - cx, ay - cy
        area = uy * wx - ux * wy
        turn = -1.0 if area < 0.0 else 1.0
        table[E0 + i] = turn * (ux * (y - ay) - uy * (x - ax))
        table[E1 + i] = turn * (vx * (y - by) - vy * (x - bx))
        table[E2 + i] = turn * (wx * (y - cy) - wy * (x - cx))
        table[ACROSS0 + i], table[ACROSS1 + i], table[ACROSS2 + i] = -turn * uy, -turn * vy, -turn * wy
        table[BELOW0 + i], table[BELOW1 + i], table[BELOW2 + i] = turn * ux, turn * vx, turn * wx

        # Bound the error of the edge functions. Moving the corners by t changes one, a sum of two products of
        # differences, by at most 3 t (w + h) + 4 t^2, and t is at most PRECISE; its roundings add up to less
        # than 16 u w h. Both with a margin for the samples beside the bounding box that are tested together
        # with those within.
        w, h = most_x - least_x, most_y - least_y
        bound = 4.0 * t * (w + h + 20.0) + 32.0 * U * (w + 18.0) * (h + 2.0)
        table[BOUND + i], table[AREA + i] = bound, turn * area

        # Take the plane of depth through the corners.
        uz, wz = (az - bz) * eye.scale, (cz - az) * eye.scale
        per_area = 1.0 / area if area != 0.0 else 0.0
        z_x, z_y = (uy * wz - wy * uz) * per_area, (wx * uz - ux * wz) * per_area
        table[Z + i] = key_depth(az, eye) + ((x - ax) * z_x + (y - ay) * z_y)
        table[Z_X + i], table[Z_Y + i] = z_x, z_y

        # Bound the error of depth. A point in a triangle is a mean of its corners, whatever they are exactly.
        # So moving the corners by t moves the depth there by at most t (|z_x| + |z_y|), and the errors of
        # their depths count as they are. Rounding changes the area by at most 4 u w h, and z_x, z_y by that
        # relative to the area, and as much again for the numerators, products of h or w and a difference of
        # depths, which is at most w |z_x| + h |z_y|.
        nearest, farthest = max(max(az, bz), cz), min(min(az, bz), cz)
        slack = nearness_error(nearest, eye) * eye.scale
        range_of_z = w * abs(z_x) + h * abs(z_y)
        rounding = 128.0 * U * (1.0 + w * h * abs(per_area) * range_of_z)
        table[Z_ERROR + i] = slack + t * (abs(z_x) + abs(z_y)) + rounding

        # Leave out what is not certain enough, culled, beyond near or far, or beside all samples.
        least_z, most_z = key_depth(nearest, eye), key_depth(farthest, eye)
        # The key depth of a corner rounds three times more.
        least_z -= slack + 8.0 * U * (1.0 + abs(least_z))
        most_z += slack + 8.0 * U * (1.0 + abs(most_z))
        table[NEAREST + i] = least_z
        table[CUT + i] = 1.0 if (least_z < eye.near) | (most_z > eye.far) else 0.0
        culled = (table[CULL + i] == (CULL_FRONT if area < 0.0 else CULL_BACK)) & (abs(area) > bound)
        shown = (t <= PRECISE) & (least_z <= eye.far) & (most_z >= eye.near) & (left < right)
        table[LEFT + i], table[RIGHT + i], table[TOP + i] = left, right, top
        table[BOTTOM + i] = bottom if shown & ~culled else top
