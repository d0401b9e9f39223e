"""A model of OpenGL's software driver, stage by stage, down to the last bit.

A picture drawn by OpenGL differs from the exact answer because the stages of its pipeline round.
:func:`predict` does the stages up to a chosen one as the driver does, and those after it as exactly
as float64 allows; with every stage done as the driver does it, the prediction is what the driver
shows. The cause of a wrong sample is the stage from which on the models show what the driver shows.

================  ============================================  ====================================
Stage             As the driver does it                         When only earlier stages are
================  ============================================  ====================================
input rounding    vertices and matrix rounded to float32        (done in every model)
transform         clip coordinates in float32                   in float64
clipping          new corners in float32, fans of triangles     near and far tested at each sample
vertex snapping   float32 window, corners rounded to a grid,    edges from clip coordinates in
                  edges in integers                             float64, nothing divided
fill rule         the driver's                                  left and top edges own their samples
depth arithmetic  the plane through float32 window corners,     the plane through clip corners,
                  float32, drawn if nearer than 1               float64
depth format      rounded to integers, if it has any            kept as it is
================  ============================================  ====================================

Culling is part of the scene, not a stage: it goes by the corners that the model has.

The facts are those of Mesa 22.3, gallium driver llvmpipe, measured against it, and found in its
files ``draw_llvm.c``, ``draw_pipe_clip.c``, ``draw_pipe_cull.c``, ``draw_pt_vsplit.c``,
``lp_setup_tri.c``, ``lp_state_setup.c``, ``lp_bld_interp.c`` and ``lp_bld_conv.c``. Where it fuses a
multiplication with an addition, the processor is taken to have that instruction.

Window coordinates are OpenGL's, y upward: row 0 is the bottom row until the rows are turned over at
the very end.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.gl.depth import D24, DepthBuffer
from hsr.models.llvmpipe import float32
from hsr.models.stages import Cause
from hsr.problem.map import BACKGROUND
from hsr.problem.view import CULL, View

XYW = [0, 1, 3]
"""The clip coordinates that decide where on the screen a point is."""


STAGES = tuple(Cause)[Cause.INPUT_ROUNDING : Cause.DEPTH_FORMAT + 1]
"""The stages of the pipeline, in order."""


SUBPIXEL_BITS = 8
"""Corners are rounded to multiples of ``2**-SUBPIXEL_BITS`` pixels, ties to even."""

BATCH = 341
"""So many triangles at a time are tested for clipping."""


class Prediction(NamedTuple):
    """What a model shows.

    Attributes
    ----------
    face : (H, W) int32
        Face id of the owner of each sample, -1 for the background. Row 0 is the top row.
    window : (H, W) float64
        Depth in the window: 0 at near, 1 at far, or reversed, affine on the screen. In the background
        what the buffer is cleared to, or infinite in models that end before the depth arithmetic.
    """

    face: Ints
    window: Floats


def predict(
    view: View, upto: Cause = Cause.DEPTH_FORMAT, buffer: DepthBuffer = D24, samples: Array | None = None
) -> Prediction:
    """Tell what a driver shows that works as modelled up to a stage, and without error after it.

    Parameters
    ----------
    view : View
        Curved shapes are tessellated.
    upto : Cause
        The last of :data:`STAGES` that is done as the driver does it.
    buffer : DepthBuffer
    samples : (n,) int64, optional
        Numbers ``row * W + column`` of those that are asked about; others may be told wrong.

    Returns
    -------
    Prediction
    """
    levels = 2.0**buffer.bits - 1.0
    # The kernel shows the least depth. Negating is exact, and rounds what follows alike.
    sign = -1.0 if buffer.reversed else 1.0
    arithmetic, clear, step = float32.FLOAT64, np.inf, 1.0
    if upto >= Cause.DEPTH_ARITHMETIC:
        arithmetic, clear = float32.FLOAT32, sign * buffer.cleared_to
    if upto == Cause.DEPTH_FORMAT and buffer.bits:
        arithmetic, clear, step = float32.UNORM, levels, 1.0 / levels
    triangle = np.full((view.height, view.width), -1, dtype=np.int32)
    depth = np.full((view.height, view.width), clear)
    edges, closed, box, plane, faces = _outlines(view, upto, buffer, _counted(view, samples))
    float32.draw(edges, closed, box, sign * plane, arithmetic, np.float32(levels), triangle, depth)
    face = np.append(faces, np.int32(BACKGROUND))[triangle]
    return Prediction(np.ascontiguousarray(face[::-1]), sign * step * depth[::-1])


class Drawn(NamedTuple):
    """How the driver sees one triangle at one sample.

    Attributes
    ----------
    inside : float
        Distance in pixels from the sample to the nearest of the snapped edges, negative outside.
    level : int
        The depth there, as the integer that the buffer would hold.
    """

    inside: float
    level: int


def drawn_at(view: View, face: int, sample: int) -> Drawn | None:
    """Tell how the driver sees the triangle of a face that a sample lies deepest within.

    Parameters
    ----------
    view : View
        Curved shapes are tessellated.
    face : int
    sample : int
        ``row * W + column``; row 0 is the top row.

    Returns
    -------
    Drawn or None
        None if it draws no triangle of the face.
    """
    edges, _, _, plane, faces = _all_drawn(view)
    # Faces not one after the other, or a number of another type, would have all copied each time.
    first, end = (np.searchsorted(faces, faces.dtype.type(face), side=side) for side in ("left", "right"))
    if first == end:
        return None
    column, up = sample % view.width, view.height - 1 - sample // view.width
    distance = edges[first:end] @ [1, column, up] / np.hypot(edges[first:end, :, 1], edges[first:end, :, 2])
    inside = distance.min(axis=1)
    best = int(inside.argmax())
    levels = np.float32(2.0**D24.bits - 1.0)
    level = float32.depth_at(plane[first + best], column, up, float32.UNORM, levels)
    return Drawn(float(inside[best]), int(level))


@lru_cache(maxsize=1)
def _all_drawn(view: View) -> _Outlines:
    """Return all that the driver draws of a view; kept for the next samples of it."""
    return _outlines(view, Cause.DEPTH_FORMAT, D24, _counted(view, None))


def _counted(view: View, samples: Array | None) -> Array:
    """Count the samples (H + 1, W + 1) asked about in the rows below and columns before those given."""
    asked = np.zeros((view.height + 1, view.width + 1), dtype=np.int64)
    asked[:0:-1, 1:].flat[slice(None) if samples is None else samples] = 1
    return np.asarray(asked.cumsum(axis=0).cumsum(axis=1))


def _covering(box: Ints, counted: Array) -> Bools:
    """Tell which boxes (n,) hold a sample that is asked about."""
    left, bottom, right, top = np.maximum(box + np.array([0, 0, 1, 1]), 0).T
    above, below = counted[top, right] - counted[top, left], counted[bottom, right] - counted[bottom, left]
    return np.asarray((left < right) & (bottom < top) & (above > below))


def _outlines(view: View, upto: Cause, buffer: DepthBuffer, counted: Array) -> _Outlines:
    # What lies behind the eye divides by zero, and is clipped away.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        triangles = _clip(view, buffer) if upto >= Cause.CLIPPING else _input(view, upto, buffer)
        outlines = _snapped if upto >= Cause.VERTEX_SNAPPING else _homogeneous
        return outlines(triangles, (view.width, view.height), upto, buffer, counted)


class _Outlines(NamedTuple):
    """What the kernel draws (see its parameters of the same names), and the face of each triangle."""

    edges: Array
    closed: Bools
    box: Ints
    plane: Floats
    face: Ints


# ---------------------------------------------------------------- transform and clipping


def _input(view: View, upto: Cause, buffer: DepthBuffer) -> Array:
    """Carry the corners of all triangles to clip coordinates.

    A corner is the sum of the matrix's columns, weighted, from the first to the last.

    Returns
    -------
    (n,) record
        Triangles in drawing order: their corners ``clip`` (3, 4), float32 or, before the transform rounds,
        float64; which of them clipping ``made``; whether the triangle is ``staged``, of a batch in which
        something is clipped, and so runs through more of the pipeline; ``cull`` and ``face``.
    """
    polygons = view.tessellated().polygons
    number = np.float32 if upto >= Cause.TRANSFORM else np.float64
    x, y, z = polygons.vertices.astype(np.float32).astype(number).T[:, :, None]
    columns = buffer.clip_from_world(view).astype(np.float32).astype(number).T
    clip = ((columns[0] * x + columns[1] * y) + columns[2] * z) + columns[3]
    kept = [
        ("clip", number, (3, 4)),
        ("made", bool, 3),
        ("staged", bool),
        ("cull", np.int8),
        ("face", np.int32),
    ]
    triangles = np.zeros(len(polygons.triangle_vertex), kept)
    triangles["clip"], triangles["face"] = clip[polygons.triangle_vertex], polygons.triangle_face
    triangles["cull"] = polygons.cull[polygons.triangle_polygon]
    return triangles


@lru_cache(maxsize=1)
def _clip(view: View, buffer: DepthBuffer) -> Array:
    """Return all triangles clipped; kept for the next stages."""
    return _clipped(_input(view, Cause.CLIPPING, buffer), buffer)


def _clipped(triangles: Array, buffer: DepthBuffer) -> Array:
    """Clip the triangles that cross a plane; what is left becomes a fan about its first corner."""
    # How far from 0 each clip plane is, in w.
    reach = np.array([1.0] * 4 + [0.0 if buffer.zero_to_one else 1.0, 1.0], dtype=np.float32)
    codes = np.empty(triangles["made"].shape, dtype=np.int32)
    float32.outcodes(triangles["clip"].reshape(-1, 4), reach, codes.reshape(-1))
    a, b, c = codes.T
    outside, hidden = a | b | c, (a & b & c) != 0
    triangles["staged"] = _batched(outside != 0, triangles["cull"])

    crossing = np.flatnonzero((outside != 0) & ~hidden)
    clip = np.zeros((len(crossing), float32.MOST_CORNERS, 4), dtype=np.float32)
    made = np.zeros(clip.shape[:2], dtype=np.bool_)
    corners = np.empty(len(crossing), dtype=np.int32)
    clip[:, :3] = triangles["clip"][crossing]
    float32.clip_triangles(clip, made, outside[crossing], reach, corners)

    source = [np.flatnonzero(outside == 0)]
    parts = [triangles[source[0]]]
    for last in range(2, float32.MOST_CORNERS):
        left, fan = np.flatnonzero(corners > last), [last - 1, last, 0]
        source.append(crossing[left])
        parts.append(triangles[crossing[left]])
        parts[-1]["clip"], parts[-1]["made"] = clip[left][:, fan], made[left][:, fan]
    return np.concatenate(parts)[np.argsort(np.concatenate(source), kind="stable")]


def _batched(outside: Bools, cull: Array) -> Bools:
    """Which triangles are in one batch with one that has a corner outside.

    A batch is so many triangles in a row, and ends where other sides begin to be culled.
    """
    number = np.arange(len(cull))
    begins = np.append(True, np.diff(cull) != 0)
    first = np.maximum.accumulate(np.where(begins, number, 0))
    batch = np.cumsum((number - first) % BATCH == 0) - 1
    return np.asarray(np.bincount(batch, outside)[batch] > 0)


# ---------------------------------------------------------------- edges on the sub-pixel grid


def _snapped(
    triangles: Array, size: tuple[int, int], upto: Cause, buffer: DepthBuffer, counted: Array
) -> _Outlines:
    """Edges in integers, through corners on the sub-pixel grid counted from the first sample."""
    window = _window(triangles, size, buffer)
    one = 1 << SUBPIXEL_BITS
    grid = np.rint((window[:, :, :2] - np.float32(0.5)) * np.float32(one)).astype(np.int64)
    low, high = _extent(grid)
    box = _box(low / one, high / one, size)
    near_by = np.flatnonzero(_covering(box, counted))
    triangles, window, grid, box = triangles[near_by], window[near_by], grid[near_by], box[near_by]

    area = _area(grid)
    drawn = (area != 0) & ~_culled(area, triangles["cull"])
    # A batch in which something is clipped is culled by the area in float32 first.
    drawn &= ~(triangles["staged"] & _culled(_area(window), triangles["cull"]))
    triangles, window, grid, area, box = (of[drawn] for of in (triangles, window, grid, area, box))

    # The driver makes all run clockwise: it swaps the first two corners of those that do not.
    clockwise = np.where((area > 0)[:, None], [1, 0, 2], [0, 1, 2])[:, :, None]
    window = np.take_along_axis(window, clockwise, axis=1)
    grid = np.take_along_axis(grid, clockwise, axis=1)

    edges, closed = _integer_edges(grid, one, upto >= Cause.FILL_RULE)
    exact = upto < Cause.DEPTH_ARITHMETIC
    plane = _clip_plane(triangles["clip"], size, buffer) if exact else _window_plane(window)
    return _Outlines(edges, closed, box, plane, triangles["face"].copy())


def _to_window(buffer: DepthBuffer) -> tuple[float, float]:
    """Return the factor and the shift that carry normalised depth to [0, 1]."""
    return (1.0, 0.0) if buffer.zero_to_one else (0.5, 0.5)


def _window(triangles: Array, size: tuple[int, int], buffer: DepthBuffer) -> Array:
    """Window coordinates (n, 3, 3) float32; those of a corner that clipping made round twice."""
    scale, move = (np.array([size[0] / 2, size[1] / 2, z], dtype=np.float32) for z in _to_window(buffer))
    clip = triangles["clip"].reshape(-1, 4)
    window = np.empty((len(clip), 3), dtype=np.float32)
    float32.project(clip, scale, move, window)
    made = triangles["made"].ravel()
    new = clip[made]
    window[made] = new[:, :3] * (np.float32(1.0) / new[:, 3:]) * scale + move
    return window.reshape(-1, 3, 3)


def _area(corners: Array) -> Array:
    """Twice the area of triangles (n, 3, 2 or more): positive where they run counter-clockwise."""
    a, b = corners[:, 0] - corners[:, 2], corners[:, 1] - corners[:, 2]
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _culled(area: Array, cull: Array) -> Bools:
    """Which triangles show the side that is culled; an area of 0 counts as the back."""
    return np.asarray(((cull == CULL["back"]) & (area <= 0)) | ((cull == CULL["front"]) & (area > 0)))


def _integer_edges(grid: Array, one: int, bottom: bool) -> tuple[Array, Bools]:
    """Edge functions of clockwise triangles, and which of them own their samples.

    Left edges do, and horizontal ones at the bottom, or else at the top.
    """
    x, y = grid[:, :, 0], grid[:, :, 1]
    dx, dy = x - np.roll(x, -1, axis=1), y - np.roll(y, -1, axis=1)
    edges = np.stack([dy * x - dx * y, -dy * one, dx * one], axis=2)
    closed = (dy < 0) | (dy == 0) & ((dx > 0) if bottom else (dx < 0))
    return edges, closed


def _window_plane(window: Array) -> Floats:
    """Depth as ``p0 + p1 column + p2 row``, in float32.

    Through the corners as they were before snapping. p0 is the depth at the first sample of the
    image, however far away that is.
    """
    dx01, dy01, dz01 = (window[:, 0] - window[:, 1]).T
    dx20, dy20, dz20 = (window[:, 2] - window[:, 0]).T
    per_area = np.float32(1.0) / (dx01 * dy20 - dy01 * dx20)
    dzdx = dz01 * (dy20 * per_area) - dz20 * (dy01 * per_area)
    dzdy = dz20 * (dx01 * per_area) - dz01 * (dx20 * per_area)
    (x, y, z), half = window[:, 0].T, np.float32(0.5)
    start = z - (dzdx * (x - half) + dzdy * (y - half))
    return np.stack([start, dzdx, dzdy], axis=1).astype(np.float64)


# ---------------------------------------------------------------- edges from clip coordinates


def _homogeneous(
    triangles: Array, size: tuple[int, int], upto: Cause, buffer: DepthBuffer, counted: Array
) -> _Outlines:
    """Edges from clip coordinates, for which no corner need lie in front of the eye.

    With a triangle's corners as vectors (x, y, w), the edge opposite a corner is the cross product
    of the other two. Where all three edges are positive, w is (Olano & Greer, "Triangle scan
    conversion using 2D homogeneous coordinates", Graphics Hardware 1997).
    """
    clip = triangles["clip"].astype(np.float64)
    box = _box_beyond_near(clip, size, buffer)
    near_by = np.flatnonzero(_covering(box, counted))
    area = np.linalg.det(clip[near_by][:, :, XYW])
    drawn = (area != 0) & ~_culled(area, triangles["cull"][near_by])
    near_by, area = near_by[drawn], area[drawn]
    clip, box, face = clip[near_by], box[near_by], triangles["face"][near_by]
    edges = _per_sample(_opposite_edges(clip) * np.sign(area)[:, None, None], size)
    closed = (edges[:, :, 1] > 0) | (edges[:, :, 1] == 0) & (edges[:, :, 2] < 0)
    plane = _clip_plane(clip, size, buffer)
    if upto < Cause.CLIPPING:
        # Window depth is at least 0 and at most 1: beyond near and before far, or the other way round.
        above, below = plane, [1.0, 0.0, 0.0] - plane
        edges = np.concatenate([edges, np.stack([above, below], axis=1)], axis=1)
        closed = np.concatenate([closed, np.ones((len(clip), 2), dtype=np.bool_)], axis=1)
    return _Outlines(edges, closed, box, plane, face)


def _opposite_edges(clip: Floats) -> Floats:
    corners = clip[:, :, XYW]
    return np.cross(np.roll(corners, -1, axis=1), np.roll(corners, -2, axis=1))


def _clip_plane(clip: Array, size: tuple[int, int], buffer: DepthBuffer) -> Floats:
    """Depth as ``p0 + p1 column + p2 row``, in float64, from corners in clip coordinates.

    At a sample, opposite edges divided by the determinant of the (x, y, w) weigh the corners so
    that they add up to (x / w, y / w, 1); their z then add up to z / w.
    """
    clip = clip.astype(np.float64)
    edges = _opposite_edges(clip)
    determinant = np.einsum("nk,nk->n", clip[:, 0, XYW], edges[:, 0])
    z = np.einsum("nk,nkj->nj", clip[:, :, 2], edges) / determinant[:, None]
    factor, shift = _to_window(buffer)
    return factor * _per_sample(z, size) + [shift, 0.0, 0.0]


def _per_sample(rows: Floats, size: tuple[int, int]) -> Floats:
    """Turn expressions in (x, y, 1) of normalised device coordinates into such in (1, column, row)."""
    width, height = size
    a, b, c = rows[..., 0], rows[..., 1], rows[..., 2]
    constant = a * (1.0 / width - 1.0) + b * (1.0 / height - 1.0) + c
    return np.stack([constant, a * 2.0 / width, b * 2.0 / height], axis=-1)


def _box_beyond_near(clip: Floats, size: tuple[int, int], buffer: DepthBuffer) -> Ints:
    """Bounds of what lies beyond the near plane; a sample wider, so that no rounding counts."""
    z, w = clip[:, :, 2], clip[:, :, 3]
    beyond = w - z if buffer.reversed else z + w
    box = np.empty((len(clip), 4), dtype=np.int32)
    whole = ((beyond >= 0) & (w > 0)).all(axis=1)
    sample = (clip[whole, :, :2] / w[whole, :, None] + 1.0) * 0.5 * size - 0.5
    low, high = _extent(sample)
    box[whole] = _box(low - 1.0, high + 1.0, size)
    box[~whole] = _box_of_cut(clip[~whole], beyond[~whole], size)
    return box


def _box_of_cut(clip: Floats, beyond: Floats, size: tuple[int, int]) -> Ints:
    """Do so for triangles whose corners do not all lie beyond the near plane."""
    beyond_next = np.roll(beyond, -1, axis=1)
    crosses = (beyond < 0) != (beyond_next < 0)
    t = np.where(crosses, beyond / (beyond - beyond_next), 0.0)[:, :, None]
    cuts = clip + t * (np.roll(clip, -1, axis=1) - clip)
    points = np.concatenate([clip, cuts], axis=1)
    seen = np.concatenate([beyond >= 0, crosses], axis=1) & (points[:, :, 3] > 0)
    sample = (points[:, :, :2] / points[:, :, 3:] + 1.0) * 0.5 * size - 0.5
    low = np.where(seen[:, :, None], sample, np.inf).min(axis=1)
    high = np.where(seen[:, :, None], sample, -np.inf).max(axis=1)
    return _box(low - 1.0, high + 1.0, size)


# ---------------------------------------------------------------- samples


def _extent(corners: Array) -> tuple[Array, Array]:
    """Return the least and the greatest coordinates of triangles (n, 3, 2)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]  # a reduction along three takes longer
    return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)


def _box(low: Floats, high: Floats, size: tuple[int, int]) -> Ints:
    """First and last column and row within bounds (n, 2) and the image."""
    last = np.array(size) - 1
    first_in, last_in = np.clip(np.ceil(low), 0, last + 1), np.clip(np.floor(high), -1, last)
    return np.concatenate([first_in, last_in], axis=1).astype(np.int32)
