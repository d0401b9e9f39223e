"""A model of OpenGL's software driver, stage by stage, down to the last bit.

A picture drawn by OpenGL differs from the exact answer because each stage of the pipeline rounds.
:func:`predict` runs the stages up to a chosen one as the driver does, and those after it as exactly
as float64 allows; with every stage as the driver does it, the prediction is what the driver shows.
A sample's error is caused by the stage from which on the models show what the driver shows.

======================  ==========================================  ==============================
Stage                   As the driver does it                       Before that
======================  ==========================================  ==============================
input rounding          vertices and matrix are float32             (always done)
transform               clip coordinates, float32                   float64
clipping                new corners and fans, float32               homogeneous edges, per sample
vertex snapping         window coordinates, float32, then rounded   homogeneous edges, float64
                        to the sub-pixel grid; edges in integers
fill rule               the driver's, on edges                      left, then top edges own
depth arithmetic        a plane through the float32 window          the plane through the clip
                        coordinates, in float32                     coordinates, in float64
depth format            stored as an integer                        not stored
======================  ==========================================  ==============================

The facts are those of Mesa 22.3, gallium driver llvmpipe: ``draw_llvm.c`` (``generate_viewport``,
``generate_clipmask``), ``draw_pipe_clip.c``, ``draw_pipe_cull.c``, ``lp_setup_tri.c``,
``lp_state_setup.c``, ``lp_bld_interp.c``, ``lp_bld_conv.c``. It fuses a multiplication and an
addition where the processor can, as all of today do.

Window coordinates are OpenGL's: y runs upward, and row 0 of an array is the bottom row until the
very end, where the rows are turned over.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from hsr.arrays import Array, Bools, Floats, Ints
from hsr.kernels import snapped
from hsr.viewing import CULL, View
from hsr.visibility import BACKGROUND


class Stage(IntEnum):
    """The stages of the pipeline, in order."""

    INPUT_ROUNDING = 0
    TRANSFORM = 1
    CLIPPING = 2
    VERTEX_SNAPPING = 3
    FILL_RULE = 4
    DEPTH_ARITHMETIC = 5
    DEPTH_FORMAT = 6


@dataclass(frozen=True)
class Driver:
    """What one OpenGL driver does where OpenGL leaves it free.

    Attributes
    ----------
    subpixel_bits : int
        Corners are rounded to multiples of ``2**-subpixel_bits`` pixels, ties to even.
    bottom_left : bool
        Whether a sample on a horizontal edge belongs to the triangle above it, or to that below.
        On any other edge it belongs to the triangle to its right.
    guard : float
        Triangles are clipped where ``|x|`` or ``|y|`` exceeds ``guard * w``.
    depth_bits : int
        Bits of the integers that the depth buffer holds.
    """

    subpixel_bits: int = 8
    bottom_left: bool = True
    guard: float = 1.0
    depth_bits: int = 24


LLVMPIPE = Driver()
"""Mesa's software driver drawing into a texture, with a depth buffer (without one it has a guard band)."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """What a model shows.

    Attributes
    ----------
    face : (H, W) int32
        Face id of the owner of each sample, -1 for the background. Row 0 is the top row.
    window : (H, W) float64
        Depth in the window, 0 at near and 1 at far; 1 (``+inf`` in models that do not reach the
        depth arithmetic) in the background.
    """

    face: Ints
    window: Floats


def predict(view: View, upto: Stage = Stage.DEPTH_FORMAT, driver: Driver = LLVMPIPE) -> Prediction:
    """Tell what a driver shows if it works as modelled up to a stage, and without error after it.

    Parameters
    ----------
    view : View
        Curved shapes are tessellated.
    upto : Stage
        The last stage that is done as the driver does it.
    driver : Driver

    Returns
    -------
    Prediction
    """
    polygons = view.tessellated().polygons
    triangles = _Triangles(
        _clip_coordinates(polygons.vertices, view.clip_from_world, upto)[polygons.triangle_vertex],
        np.zeros(polygons.triangle_vertex.shape, dtype=np.bool_),
        polygons.cull[polygons.triangle_polygon],
        polygons.triangle_face,
    )
    if upto >= Stage.CLIPPING:
        triangles = _clipped(triangles, driver)
    size = (view.width, view.height)
    if upto >= Stage.VERTEX_SNAPPING:
        return _draw(_snapped(triangles, size, upto, driver), size, upto, driver)
    return _draw(_homogeneous(triangles, size, upto), size, upto, driver)


@dataclass(frozen=True, eq=False)
class _Triangles:
    """Triangles in drawing order.

    clip : (n, 3, 4), made : (n, 3) bool, corners that clipping made; cull : (n,); face : (n,)
    """

    clip: Array
    made: Bools
    cull: Array
    face: Ints

    def of(self, chosen: Array) -> _Triangles:
        return _Triangles(self.clip[chosen], self.made[chosen], self.cull[chosen], self.face[chosen])


@dataclass(frozen=True, eq=False)
class _Outlines:
    """What the kernel draws: see its parameters of the same names."""

    edges: Array
    closed: Bools
    box: Ints
    plane: Floats
    face: Ints


# ---------------------------------------------------------------- transform and clipping


def _clip_coordinates(vertices: Floats, clip_from_world: Floats, upto: Stage) -> Array:
    """Carry vertices to clip space: a sum of the matrix's columns, from the first to the last."""
    number = np.float32 if upto >= Stage.TRANSFORM else np.float64
    x, y, z = vertices.astype(np.float32).astype(number).T[:, :, None]
    columns = clip_from_world.astype(np.float32).astype(number).T
    clip: Array = ((columns[0] * x + columns[1] * y) + columns[2] * z) + columns[3]
    return clip


def _clipped(triangles: _Triangles, driver: Driver) -> _Triangles:
    """Clip triangles that cross a plane, and cut what is left into fans about its first corner."""
    codes = np.empty(3 * len(triangles.clip), dtype=np.int32)
    snapped.outcodes(triangles.clip.reshape(-1, 4), np.float32(driver.guard), codes)
    codes = codes.reshape(-1, 3)
    outside = np.bitwise_or.reduce(codes, axis=1)
    hidden = np.bitwise_and.reduce(codes, axis=1) != 0
    crossing = np.flatnonzero((outside != 0) & ~hidden)

    clip = np.zeros((len(crossing), snapped.MOST_CORNERS, 4), dtype=np.float32)
    made = np.zeros(clip.shape[:2], dtype=np.bool_)
    corners = np.empty(len(crossing), dtype=np.int32)
    clip[:, :3] = triangles.clip[crossing]
    snapped.clip_triangles(clip, made, outside[crossing], np.float32(driver.guard), corners)

    whole = np.flatnonzero(outside == 0)
    order, parts = [whole], [triangles.of(whole)]
    for last in range(2, snapped.MOST_CORNERS):
        left = np.flatnonzero(corners > last)
        fan = [last - 1, last, 0]
        source = crossing[left]
        order.append(source)
        parts.append(
            _Triangles(clip[left][:, fan], made[left][:, fan], triangles.cull[source], triangles.face[source])
        )
    return _joined(parts).of(np.argsort(np.concatenate(order), kind="stable"))


def _joined(parts: list[_Triangles]) -> _Triangles:
    return _Triangles(
        np.concatenate([part.clip for part in parts]),
        np.concatenate([part.made for part in parts]),
        np.concatenate([part.cull for part in parts]),
        np.concatenate([part.face for part in parts]),
    )


def _window(triangles: _Triangles, size: tuple[int, int]) -> Array:
    """Window coordinates (n, 3, 3) float32; a corner that clipping made is rounded once more."""
    half = np.array([size[0] / 2.0, size[1] / 2.0, 0.5], dtype=np.float32)
    clip = triangles.clip.reshape(-1, 4)
    window = np.empty((len(clip), 3), dtype=np.float32)
    snapped.project(clip, half, half, window)
    made = triangles.made.ravel()
    new = clip[made]
    window[made] = new[:, :3] * (np.float32(1.0) / new[:, 3:]) * half + half
    return window.reshape(-1, 3, 3)


# ---------------------------------------------------------------- edges


def _visible(area: Array, cull: Array) -> Bools:
    """Which triangles are drawn: not edge-on, and not of the side that is culled."""
    culled = ((cull == CULL["back"]) & (area < 0)) | ((cull == CULL["front"]) & (area > 0))
    visible: Bools = (area != 0) & ~culled
    return visible


def _snapped(triangles: _Triangles, size: tuple[int, int], upto: Stage, driver: Driver) -> _Outlines:
    """Edges in integers through corners on the sub-pixel grid, counted from the first sample."""
    window = _window(triangles, size)
    one = 1 << driver.subpixel_bits
    grid = np.rint((window[:, :, :2] - np.float32(0.5)) * np.float32(one)).astype(np.int64)

    area = _cross(grid[:, 1] - grid[:, 0], grid[:, 2] - grid[:, 0])
    drawn = _visible(area, triangles.cull) & _passes_cull_stage(triangles, window)
    triangles, window, grid, area = triangles.of(drawn), window[drawn], grid[drawn], area[drawn]

    # The driver turns triangles that run counter-clockwise by swapping their first two corners.
    turned = np.where((area > 0)[:, None], [1, 0, 2], [0, 1, 2])[:, :, None]
    grid = np.take_along_axis(grid, turned, axis=1)
    window = np.take_along_axis(window, turned, axis=1)

    x, y = grid[:, :, 0], grid[:, :, 1]
    dx, dy = x - np.roll(x, -1, axis=1), y - np.roll(y, -1, axis=1)
    edges = np.stack([dy * x - dx * y, -dy * one, dx * one], axis=2)
    from_below = upto < Stage.FILL_RULE or not driver.bottom_left
    closed = (dy < 0) | (dy == 0) & ((dx < 0) if from_below else (dx > 0))
    low, high = grid.min(axis=1), grid.max(axis=1)
    box = _box(low / one, high / one, size)
    if upto >= Stage.DEPTH_ARITHMETIC:
        plane = _float32_plane(window)
    else:
        plane = _plane(triangles.clip.astype(np.float64), size)
    return _Outlines(edges, closed, box, plane, triangles.face)


def _cross(a: Array, b: Array) -> Array:
    """Cross product of vectors in the plane: positive where b lies counter-clockwise of a."""
    product: Array = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return product


def _passes_cull_stage(triangles: _Triangles, window: Array) -> Bools:
    """Of a clipped triangle the driver culls the pieces by their float32 area as well."""
    area = _cross(window[:, 0] - window[:, 2], window[:, 1] - window[:, 2])
    area[area == 0] = -1  # an area of 0 is that of a back
    passes: Bools = ~triangles.made.any(axis=1) | _visible(area, triangles.cull)
    return passes


def _homogeneous(triangles: _Triangles, size: tuple[int, int], upto: Stage) -> _Outlines:
    """Edges straight from clip coordinates, so that no corner need be in front of the eye.

    The edge opposite a corner is the cross product of the other two, taken as vectors (x, y, w); all
    three are positive only where w is (Olano & Greer, "Triangle scan conversion using 2D
    homogeneous coordinates", Graphics Hardware 1997).
    """
    clip = triangles.clip.astype(np.float64)
    area = np.linalg.det(clip[:, :, [0, 1, 3]])
    drawn = _visible(area, triangles.cull)
    clip, area = clip[drawn], area[drawn]
    edges = _per_sample(_opposite_edges(clip) * np.sign(area)[:, None, None], size)
    closed = (edges[:, :, 1] > 0) | (edges[:, :, 1] == 0) & (edges[:, :, 2] < 0)
    plane = _plane(clip, size)
    if upto < Stage.CLIPPING:
        near, far = plane, [1.0, 0.0, 0.0] - plane
        edges = np.concatenate([edges, near[:, None], far[:, None]], axis=1)
        closed = np.concatenate([closed, np.ones((len(clip), 2), dtype=np.bool_)], axis=1)
    return _Outlines(edges, closed, _box_beyond_near(clip, size), plane, triangles.face[drawn])


def _opposite_edges(clip: Floats) -> Floats:
    corners = clip[:, :, [0, 1, 3]]
    return np.cross(np.roll(corners, -1, axis=1), np.roll(corners, -2, axis=1))


def _per_sample(rows: Floats, size: tuple[int, int]) -> Floats:
    """Turn linear expressions in (x, y, 1) of the view volume into such in (1, column, row)."""
    width, height = size
    a, b, c = rows[..., 0], rows[..., 1], rows[..., 2]
    constant = a * (1.0 / width - 1.0) + b * (1.0 / height - 1.0) + c
    return np.stack([constant, a * 2.0 / width, b * 2.0 / height], axis=-1)


def _box(low: Floats, high: Floats, size: tuple[int, int]) -> Ints:
    """First and last column and row whose samples, at whole numbers, lie within bounds."""
    last = np.array(size) - 1
    first_in, last_in = np.clip(np.ceil(low), 0, last + 1), np.clip(np.floor(high), -1, last)
    return np.concatenate([first_in, last_in], axis=1).astype(np.int32)


def _box_beyond_near(clip: Floats, size: tuple[int, int]) -> Ints:
    """Bounds of the part of each triangle beyond the near plane, one sample wider for rounding."""
    beyond = clip[:, :, 2] + clip[:, :, 3]
    following, beyond_following = np.roll(clip, -1, axis=1), np.roll(beyond, -1, axis=1)
    crosses = (beyond < 0) != (beyond_following < 0)
    t = np.divide(beyond, beyond - beyond_following, where=crosses, out=np.zeros_like(beyond))
    points = np.concatenate([clip, clip + t[:, :, None] * (following - clip)], axis=1)
    seen = np.concatenate([beyond >= 0, crosses], axis=1) & (points[:, :, 3] > 0)
    w = np.where(seen, points[:, :, 3], 1.0)[:, :, None]
    sample = (points[:, :, :2] / w + 1.0) * 0.5 * size - 0.5
    low = np.where(seen[:, :, None], sample, np.inf).min(axis=1)
    high = np.where(seen[:, :, None], sample, -np.inf).max(axis=1)
    return _box(low - 1.0, high + 1.0, size)


# ---------------------------------------------------------------- depth


def _plane(clip: Floats, size: tuple[int, int]) -> Floats:
    """Window depth as ``p0 + p1 column + p2 row``, in float64.

    The barycentric weights of a sample are its opposite edges over the determinant, those of
    (x, y, w); weighting z with them gives z / w.
    """
    edges = _opposite_edges(clip)
    determinant = np.einsum("nk,nk->n", clip[:, 0][:, [0, 1, 3]], edges[:, 0])
    z = np.einsum("nk,nkj->nj", clip[:, :, 2], edges) / determinant[:, None]
    return 0.5 * _per_sample(z, size) + [0.5, 0.0, 0.0]


def _float32_plane(window: Array) -> Floats:
    """Window depth as ``p0 + p1 column + p2 row``, reckoned in float32 as the driver does.

    Through the window coordinates *before* they are snapped; p0 is the depth at the first sample
    of the image, however far from the triangle.
    """
    x, y, z = window[:, :, 0], window[:, :, 1], window[:, :, 2]
    dx01, dx20 = x[:, 0] - x[:, 1], x[:, 2] - x[:, 0]
    dy01, dy20 = y[:, 0] - y[:, 1], y[:, 2] - y[:, 0]
    dz01, dz20 = z[:, 0] - z[:, 1], z[:, 2] - z[:, 0]
    with np.errstate(all="ignore"):  # a snapped triangle has an area, the unsnapped one may have none
        scale = np.float32(1.0) / (dx01 * dy20 - dy01 * dx20)
        dzdx = dz01 * (dy20 * scale) - dz20 * (dy01 * scale)
        dzdy = dz20 * (dx01 * scale) - dz01 * (dx20 * scale)
        half = np.float32(0.5)
        z0 = z[:, 0] - (dzdx * (x[:, 0] - half) + dzdy * (y[:, 0] - half))
    return np.stack([z0, dzdx, dzdy], axis=1).astype(np.float64)


def _draw(outlines: _Outlines, size: tuple[int, int], upto: Stage, driver: Driver) -> Prediction:
    width, height = size
    levels = float(2**driver.depth_bits - 1)
    arithmetic, clear, unit = snapped.FLOAT64, np.inf, 1.0
    if upto == Stage.DEPTH_ARITHMETIC:
        arithmetic, clear = snapped.FLOAT32, 1.0
    elif upto == Stage.DEPTH_FORMAT:
        arithmetic, clear, unit = snapped.UNORM, levels, levels
    triangle = np.full((height, width), -1, dtype=np.int32)
    depth = np.full((height, width), clear)
    snapped.draw(
        outlines.edges,
        outlines.closed,
        outlines.box,
        outlines.plane,
        arithmetic,
        np.float32(levels),
        triangle,
        depth,
    )
    face = np.append(outlines.face, np.int32(BACKGROUND))[triangle]
    return Prediction(face[::-1].copy(), depth[::-1] / unit)
