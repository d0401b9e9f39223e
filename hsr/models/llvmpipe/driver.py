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

from dataclasses import dataclass, replace

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


@dataclass(frozen=True)
class Driver:
    """What a driver does where OpenGL leaves it free.

    Attributes
    ----------
    subpixel_bits : int
        Corners are rounded to multiples of ``2**-subpixel_bits`` pixels, ties to even.
    bottom_left : bool
        Whether a sample on a horizontal edge belongs to the triangle above the edge, or to that
        below. On any other edge it belongs to the triangle to the right.
    guard : float
        Triangles are clipped where ``|x|`` or ``|y|`` exceeds ``guard * w``.
    batch : int
        So many triangles at a time are tested for clipping.
    depth : DepthBuffer
    """

    subpixel_bits: int = 8
    bottom_left: bool = True
    guard: float = 1.0
    batch: int = 341
    depth: DepthBuffer = D24

    @property
    def reach(self) -> Array:
        """How far from 0 each clip plane is, in w; see :func:`hsr.models.llvmpipe.float32.outcodes`."""
        near = 0.0 if self.depth.zero_to_one else 1.0
        return np.array([self.guard] * 4 + [near, 1.0], dtype=np.float32)

    @property
    def to_window(self) -> tuple[float, float]:
        """The factor and the shift that carry normalised depth to [0, 1]."""
        return (1.0, 0.0) if self.depth.zero_to_one else (0.5, 0.5)


LLVMPIPE = Driver()
"""Mesa's software driver, drawing into a texture with a depth buffer of 24 bits."""


@dataclass(frozen=True, eq=False)
class Prediction:
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


def predict(view: View, upto: Cause = Cause.DEPTH_FORMAT, driver: Driver = LLVMPIPE) -> Prediction:
    """Tell what a driver shows that works as modelled up to a stage, and without error after it.

    Parameters
    ----------
    view : View
        Curved shapes are tessellated.
    upto : Cause
        The last of :data:`STAGES` that is done as the driver does it.
    driver : Driver

    Returns
    -------
    Prediction
    """
    return _drawn(_outlines(view, upto, driver), (view.width, view.height), upto, driver)


@dataclass(frozen=True)
class Drawn:
    """How the driver sees one triangle at one sample.

    Attributes
    ----------
    face : int
    inside : float
        Distance in pixels from the sample to the nearest of the snapped edges, negative outside.
    level : int
        The depth there, as the integer that the buffer would hold.
    """

    face: int
    inside: float
    level: int


class Drawing:
    """How the driver sees the triangles of a view at single samples.

    Parameters
    ----------
    view : View
        Curved shapes are tessellated.
    driver : Driver
    """

    def __init__(self, view: View, driver: Driver = LLVMPIPE) -> None:
        self._outlines = _outlines(view, Cause.DEPTH_FORMAT, driver)
        self._size = view.width, view.height
        self._levels = np.float32(2.0**driver.depth.bits - 1.0)

    def at(self, face: int, sample: int) -> Drawn | None:
        """Tell how the driver sees the triangle of a face that a sample lies deepest within.

        Parameters
        ----------
        face : int
        sample : int
            ``row * W + column``; row 0 is the top row.

        Returns
        -------
        Drawn or None
            None if it draws no triangle of the face.
        """
        faces = self._outlines.face
        first, end = (np.searchsorted(faces, np.int32(face), side=side) for side in ("left", "right"))
        if first == end:
            return None
        row, column = divmod(sample, self._size[0])
        up = self._size[1] - 1 - row
        edges = self._outlines.edges[first:end]
        inside = (edges @ [1, column, up] / np.hypot(edges[:, :, 1], edges[:, :, 2])).min(axis=1)
        best = int(inside.argmax())
        plane = self._outlines.plane[first + best]
        level = float32.depth_at(plane, column, up, float32.UNORM, self._levels)
        return Drawn(face, float(inside[best]), int(level))


def _outlines(view: View, upto: Cause, driver: Driver) -> _Outlines:
    size = (view.width, view.height)
    # What lies behind the eye divides by zero, and is clipped away.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        triangles = _input(view, upto, driver)
        if upto >= Cause.CLIPPING:
            triangles = _clipped(triangles, driver)
        if upto >= Cause.VERTEX_SNAPPING:
            return _snapped(triangles, size, upto, driver)
        return _homogeneous(triangles, size, upto, driver)


@dataclass(frozen=True, eq=False)
class _Triangles:
    """Triangles in drawing order.

    Attributes
    ----------
    clip : (n, 3, 4) float32, or float64 before the transform rounds
    made : (n, 3) bool
        Corners that clipping made.
    staged : (n,) bool
        Triangles of a batch in which something is clipped: it runs through more of the pipeline.
    cull : (n,) int8
    face : (n,) int32
    """

    clip: Array
    made: Bools
    staged: Bools
    cull: Array
    face: Ints

    def of(self, chosen: Array) -> _Triangles:
        return _Triangles(*(array[chosen] for array in vars(self).values()))

    @staticmethod
    def joined(parts: list[_Triangles]) -> _Triangles:
        arrays = zip(*(vars(part).values() for part in parts), strict=True)
        return _Triangles(*(np.concatenate(array) for array in arrays))


@dataclass(frozen=True, eq=False)
class _Outlines:
    """What the kernel draws (see its parameters of the same names), and the face of each triangle."""

    edges: Array
    closed: Bools
    box: Ints
    plane: Floats
    face: Ints


# ---------------------------------------------------------------- transform and clipping


def _input(view: View, upto: Cause, driver: Driver) -> _Triangles:
    """Carry the corners of all triangles to clip coordinates.

    A corner is the sum of the matrix's columns, weighted, from the first to the last.
    """
    polygons = view.tessellated().polygons
    number = np.float32 if upto >= Cause.TRANSFORM else np.float64
    x, y, z = polygons.vertices.astype(np.float32).astype(number).T[:, :, None]
    columns = driver.depth.clip_from_world(view).astype(np.float32).astype(number).T
    clip = ((columns[0] * x + columns[1] * y) + columns[2] * z) + columns[3]
    corner = polygons.triangle_vertex
    return _Triangles(
        clip[corner],
        np.zeros(corner.shape, dtype=np.bool_),
        np.zeros(len(corner), dtype=np.bool_),
        polygons.cull[polygons.triangle_polygon],
        polygons.triangle_face,
    )


def _clipped(triangles: _Triangles, driver: Driver) -> _Triangles:
    """Clip the triangles that cross a plane; what is left becomes a fan about its first corner."""
    codes = np.empty(triangles.made.shape, dtype=np.int32)
    float32.outcodes(triangles.clip.reshape(-1, 4), driver.reach, codes.reshape(-1))
    outside = np.bitwise_or.reduce(codes, axis=1)
    hidden = np.bitwise_and.reduce(codes, axis=1) != 0
    triangles = replace(triangles, staged=_batched(outside != 0, triangles.cull, driver.batch))

    crossing = np.flatnonzero((outside != 0) & ~hidden)
    clip = np.zeros((len(crossing), float32.MOST_CORNERS, 4), dtype=np.float32)
    made = np.zeros(clip.shape[:2], dtype=np.bool_)
    corners = np.empty(len(crossing), dtype=np.int32)
    clip[:, :3] = triangles.clip[crossing]
    float32.clip_triangles(clip, made, outside[crossing], driver.reach, corners)

    source = [np.flatnonzero(outside == 0)]
    parts = [triangles.of(source[0])]
    for last in range(2, float32.MOST_CORNERS):
        left, fan = np.flatnonzero(corners > last), [last - 1, last, 0]
        source.append(crossing[left])
        parts.append(replace(triangles.of(crossing[left]), clip=clip[left][:, fan], made=made[left][:, fan]))
    return _Triangles.joined(parts).of(np.argsort(np.concatenate(source), kind="stable"))


def _batched(outside: Bools, cull: Array, size: int) -> Bools:
    """Which triangles are in one batch with one that has a corner outside.

    A batch is so many triangles in a row, and ends where other sides begin to be culled.
    """
    number = np.arange(len(cull))
    begins = np.append(True, np.diff(cull) != 0)
    first = np.maximum.accumulate(np.where(begins, number, 0))
    batch = np.cumsum((number - first) % size == 0) - 1
    batched: Bools = np.bincount(batch, outside)[batch] > 0
    return batched


# ---------------------------------------------------------------- edges on the sub-pixel grid


def _snapped(triangles: _Triangles, size: tuple[int, int], upto: Cause, driver: Driver) -> _Outlines:
    """Edges in integers, through corners on the sub-pixel grid counted from the first sample."""
    window = _window(triangles, size, driver)
    one = 1 << driver.subpixel_bits
    grid = np.rint((window[:, :, :2] - np.float32(0.5)) * np.float32(one)).astype(np.int64)

    area = _area(grid)
    drawn = (area != 0) & ~_culled(area, triangles.cull)
    # A batch in which something is clipped is culled by the area in float32 first.
    drawn &= ~(triangles.staged & _culled(_area(window), triangles.cull))
    triangles, window, grid, area = triangles.of(drawn), window[drawn], grid[drawn], area[drawn]

    # The driver makes all run clockwise: it swaps the first two corners of those that do not.
    clockwise = np.where((area > 0)[:, None], [1, 0, 2], [0, 1, 2])[:, :, None]
    window = np.take_along_axis(window, clockwise, axis=1)
    grid = np.take_along_axis(grid, clockwise, axis=1)

    bottom = upto >= Cause.FILL_RULE and driver.bottom_left
    edges, closed = _integer_edges(grid, one, bottom)
    plane = _window_plane(window)
    if upto < Cause.DEPTH_ARITHMETIC:
        plane = _clip_plane(triangles.clip, size, driver)
    box = _box(grid.min(axis=1) / one, grid.max(axis=1) / one, size)
    return _Outlines(edges, closed, box, plane, triangles.face)


def _window(triangles: _Triangles, size: tuple[int, int], driver: Driver) -> Array:
    """Window coordinates (n, 3, 3) float32; those of a corner that clipping made round twice."""
    factor, shift = driver.to_window
    scale = np.array([size[0] / 2.0, size[1] / 2.0, factor], dtype=np.float32)
    move = np.array([size[0] / 2.0, size[1] / 2.0, shift], dtype=np.float32)
    clip = triangles.clip.reshape(-1, 4)
    window = np.empty((len(clip), 3), dtype=np.float32)
    float32.project(clip, scale, move, window)
    made = triangles.made.ravel()
    new = clip[made]
    window[made] = new[:, :3] * (np.float32(1.0) / new[:, 3:]) * scale + move
    return window.reshape(-1, 3, 3)


def _area(corners: Array) -> Array:
    """Twice the area of triangles (n, 3, 2 or more): positive where they run counter-clockwise."""
    a, b = corners[:, 0] - corners[:, 2], corners[:, 1] - corners[:, 2]
    area: Array = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return area


def _culled(area: Array, cull: Array) -> Bools:
    """Which triangles show the side that is culled; an area of 0 counts as the back."""
    culled: Bools = ((cull == CULL["back"]) & (area <= 0)) | ((cull == CULL["front"]) & (area > 0))
    return culled


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
    x, y, z = window[:, :, 0], window[:, :, 1], window[:, :, 2]
    dx01, dx20 = x[:, 0] - x[:, 1], x[:, 2] - x[:, 0]
    dy01, dy20 = y[:, 0] - y[:, 1], y[:, 2] - y[:, 0]
    dz01, dz20 = z[:, 0] - z[:, 1], z[:, 2] - z[:, 0]
    per_area = np.float32(1.0) / (dx01 * dy20 - dy01 * dx20)
    dzdx = dz01 * (dy20 * per_area) - dz20 * (dy01 * per_area)
    dzdy = dz20 * (dx01 * per_area) - dz01 * (dx20 * per_area)
    half = np.float32(0.5)
    z0 = z[:, 0] - (dzdx * (x[:, 0] - half) + dzdy * (y[:, 0] - half))
    return np.stack([z0, dzdx, dzdy], axis=1).astype(np.float64)


# ---------------------------------------------------------------- edges from clip coordinates


def _homogeneous(triangles: _Triangles, size: tuple[int, int], upto: Cause, driver: Driver) -> _Outlines:
    """Edges from clip coordinates, for which no corner need lie in front of the eye.

    With a triangle's corners as vectors (x, y, w), the edge opposite a corner is the cross product
    of the other two. Where all three edges are positive, w is (Olano & Greer, "Triangle scan
    conversion using 2D homogeneous coordinates", Graphics Hardware 1997).
    """
    clip = triangles.clip.astype(np.float64)
    area = np.linalg.det(clip[:, :, XYW])
    drawn = (area != 0) & ~_culled(area, triangles.cull)
    clip, area = clip[drawn], area[drawn]
    edges = _per_sample(_opposite_edges(clip) * np.sign(area)[:, None, None], size)
    closed = (edges[:, :, 1] > 0) | (edges[:, :, 1] == 0) & (edges[:, :, 2] < 0)
    plane = _clip_plane(clip, size, driver)
    if upto < Cause.CLIPPING:
        # Window depth is at least 0 and at most 1: beyond near and before far, or the other way round.
        above, below = plane, [1.0, 0.0, 0.0] - plane
        edges = np.concatenate([edges, np.stack([above, below], axis=1)], axis=1)
        closed = np.concatenate([closed, np.ones((len(clip), 2), dtype=np.bool_)], axis=1)
    return _Outlines(edges, closed, _box_beyond_near(clip, size, driver), plane, triangles.face[drawn])


def _opposite_edges(clip: Floats) -> Floats:
    corners = clip[:, :, XYW]
    return np.cross(np.roll(corners, -1, axis=1), np.roll(corners, -2, axis=1))


def _clip_plane(clip: Array, size: tuple[int, int], driver: Driver) -> Floats:
    """Depth as ``p0 + p1 column + p2 row``, in float64, from corners in clip coordinates.

    At a sample, opposite edges divided by the determinant of the (x, y, w) weigh the corners so
    that they add up to (x / w, y / w, 1); their z then add up to z / w.
    """
    clip = clip.astype(np.float64)
    edges = _opposite_edges(clip)
    determinant = np.einsum("nk,nk->n", clip[:, 0, XYW], edges[:, 0])
    z = np.einsum("nk,nkj->nj", clip[:, :, 2], edges) / determinant[:, None]
    factor, shift = driver.to_window
    return factor * _per_sample(z, size) + [shift, 0.0, 0.0]


def _per_sample(rows: Floats, size: tuple[int, int]) -> Floats:
    """Turn expressions in (x, y, 1) of normalised device coordinates into such in (1, column, row)."""
    width, height = size
    a, b, c = rows[..., 0], rows[..., 1], rows[..., 2]
    constant = a * (1.0 / width - 1.0) + b * (1.0 / height - 1.0) + c
    return np.stack([constant, a * 2.0 / width, b * 2.0 / height], axis=-1)


def _box_beyond_near(clip: Floats, size: tuple[int, int], driver: Driver) -> Ints:
    """Bounds of what lies beyond the near plane; a sample wider, so that no rounding counts."""
    z, w = clip[:, :, 2], clip[:, :, 3]
    beyond = w - z if driver.depth.reversed else z + w
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


def _box(low: Floats, high: Floats, size: tuple[int, int]) -> Ints:
    """First and last column and row within bounds (n, 2) and the image."""
    last = np.array(size) - 1
    first_in, last_in = np.clip(np.ceil(low), 0, last + 1), np.clip(np.floor(high), -1, last)
    return np.concatenate([first_in, last_in], axis=1).astype(np.int32)


def _drawn(outlines: _Outlines, size: tuple[int, int], upto: Cause, driver: Driver) -> Prediction:
    buffer = driver.depth
    levels = 2.0**buffer.bits - 1.0
    # The kernel shows the least depth. Negating is exact, and rounds what follows alike.
    sign = -1.0 if buffer.reversed else 1.0
    arithmetic, clear, step = float32.FLOAT64, np.inf, 1.0
    if upto >= Cause.DEPTH_ARITHMETIC:
        arithmetic, clear = float32.FLOAT32, sign * buffer.cleared_to
    if upto == Cause.DEPTH_FORMAT and buffer.bits:
        arithmetic, clear, step = float32.UNORM, levels, 1.0 / levels
    triangle = np.full(size[::-1], -1, dtype=np.int32)
    depth = np.full(size[::-1], clear)
    float32.draw(
        outlines.edges,
        outlines.closed,
        outlines.box,
        sign * outlines.plane,
        arithmetic,
        np.float32(levels),
        triangle,
        depth,
    )
    face = np.append(outlines.face, np.int32(BACKGROUND))[triangle]
    return Prediction(np.ascontiguousarray(face[::-1]), sign * step * depth[::-1])
