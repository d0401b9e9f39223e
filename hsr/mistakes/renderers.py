"""Renderers in the open, in which the classic mistakes are planted.

They exist to be wrong where theory says so, or where a test should notice: a depth buffer, and ray casters by
the formulas of a first draft. None of them clips.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.kernels.projection import clip_rows
from hsr.problem.map import BACKGROUND, VisibilityMap
from hsr.problem.view import Placement, View

Real = type[np.floating[Any]]
Stored = Callable[[View, Floats], Array]
"""What a buffer keeps of the depths (n,) of a view, ascending."""

GRID = 256
"""Fractions of a pixel on which ``whole`` edge functions put their corners."""


def samples(width: int, height: int, centre: tuple[float, float] = (0.5, 0.5)) -> tuple[Floats, Floats]:
    """Return x and y (H, W) of the samples, in pixels from the middle of the picture, y up.

    They lie ``centre`` (down, right) from the upper left corners of their pixels, from 0 to 1.
    """
    y, x = np.mgrid[:height, :width]
    return x + centre[1] - 0.5 * width, 0.5 * height - centre[0] - y


Box = tuple[slice, slice]
"""Rows and columns of an image."""


@dataclass(frozen=True)
class Buffer:
    """A depth buffer, triangle by triangle; each field but its default is a mistake, or a depth format.

    Triangles are not clipped at the eye; those that reach behind it come out wrong.

    Attributes
    ----------
    stored : callable, optional
        What is kept of the depths (n,) of a view, ascending; depths themselves by default.
    real : type
        Of the matrix, the vertices and their product.
    composed : bool
        Whether depth is read off z and w of the one matrix that has the near distance in it.
    divided : bool
        Whether depth is interpolated as its inverse, as perspective demands.
    grid : float
        Steps a pixel to which corners are truncated; 0 leaves them.
    centre : tuple of 2 float
        Where in a pixel its sample lies: (down, right) from its upper left corner, from 0 to 1.
    epsilon : float
        How far outside an edge, as a multiple of its length in pixels, a sample may lie and still be covered;
        less than a pixel.
    inclusive : bool
        Whether both neighbours own the samples on their edge, and not the left and top ones alone.
    degenerate : bool
        Whether triangles without area are drawn: none of their edges has an outside.
    whole : type, optional
        Integer type of edge functions, of corners on a grid of 1/256 pixel; it may wrap around.
    short_box : bool
        Whether the last row and column of a triangle's bounding box are left out.
    swapped : bool
        Whether front and back are taken for each other.
    anchored : bool
        Whether the plane of depth is evaluated from the corner of the picture, and in float32.
    near_clip, after_near : bool
        Whether what lies in front of the near plane is left out, and whether what lies exactly on it is.
    unscaled : bool
        Whether depths of different objects are compared in their own units.
    nearest, later_wins : bool
        Whether the nearest face is seen, and not the first drawn; and of equal depths the last drawn.
    upside_down : bool
        Whether row 0 is the bottom row.
    """

    stored: Stored | None = None
    real: Real = np.float64
    composed: bool = False
    divided: bool = True
    grid: float = 0.0
    centre: tuple[float, float] = (0.5, 0.5)
    epsilon: float = 0.0
    inclusive: bool = False
    degenerate: bool = False
    whole: type[np.signedinteger[Any]] | None = None
    short_box: bool = False
    swapped: bool = False
    anchored: bool = False
    near_clip: bool = True
    after_near: bool = False
    unscaled: bool = False
    nearest: bool = True
    later_wins: bool = False
    upside_down: bool = False

    def __call__(self, view: View) -> Ints:
        """Return the face (H, W) of every sample."""
        return self.render(view, "").face

    def render(self, view: View, name: str) -> VisibilityMap:
        """Draw a view without curved shapes, and call the map that of method ``name``."""
        x, y = samples(view.width, view.height, self.centre)
        face = np.full(x.shape, BACKGROUND, np.int32)
        depth, best = np.full(x.shape, np.inf), np.full(x.shape, np.inf)
        with np.errstate(all="ignore"):
            for corners, owner, thing in self._triangles(view):
                box = self._box(view, corners)
                here = self._depth(view, corners, x[box], y[box])
                key = self._key(view, here, thing)
                nearer = self._covered(corners, thing.cull, x[box], y[box]) & (here <= view.far)
                nearer &= (key <= best[box]) if self.later_wins else (key < best[box])
                if self.near_clip:
                    nearer &= here > view.near if self.after_near else here >= view.near
                face[box][nearer], depth[box][nearer], best[box][nearer] = owner, here[nearer], key[nearer]
        if self.upside_down:
            face, depth = face[::-1].copy(), depth[::-1].copy()
        return VisibilityMap(face, depth, name)

    def _triangles(self, view: View) -> Iterator[tuple[Floats, int, Placement]]:
        """Return corners (3, 3), face and object; corners in pixels from the middle, y up, and depth."""
        rows = clip_rows(view.clip_from_world, view.depth_row).astype(self.real)
        vertices = view.polygons.vertices.astype(self.real)
        clip = (vertices @ rows[:, :3].T + rows[:, 3]).astype(np.float64)
        if self.composed:
            z, w = (vertices @ row[:3] + row[3] for row in view.clip_from_world[2:].astype(self.real))
            clip[:, 2] = 2.0 * view.near / (1.0 - z / w)  # without a far plane z / w is 1 - 2 near / d
        half = 0.5 * np.array([view.width, view.height])
        clip[:, :2] *= half / clip[:, 2:] if view.perspective else half
        if self.grid:
            from_upper_left = _from_upper_left(view, clip)
            clip[:, :2] = (np.trunc(from_upper_left * self.grid) / self.grid - half) * [1.0, -1.0]
        corners, faces = clip[view.polygons.triangle_vertex], view.triangle_face
        things = (view.placements[k] for k in view.object_of(faces))
        return zip(corners, faces.tolist(), things, strict=True)

    def _box(self, view: View, corners: Floats) -> Box:
        """Return what holds all samples of a triangle, and no less than the reach of a wrong test."""
        size = np.array([view.width, view.height])
        corner = _from_upper_left(view, corners)
        low, high = corner.min(axis=0) - 2.0, corner.max(axis=0) + 2.0
        behind = view.perspective and (corners[:, 2] <= 0.0).any()
        if behind or self.degenerate or self.whole is not None:
            low, high = 0.0 * size, size
        if self.short_box:
            high = np.minimum(high, np.floor(corner.max(axis=0)))
        (left, top), (right, bottom) = np.clip([np.floor(low), np.ceil(high)], 0, size).astype(int).tolist()
        return slice(top, bottom), slice(left, right)

    def _covered(self, corners: Floats, cull: int, x: Floats, y: Floats) -> Bools:
        """Tell which samples a triangle covers; left and top edges own theirs."""
        screen = corners[:, :2]
        if self.whole is not None:
            kind = self.whole
            screen, x, y = (np.rint(a * GRID).astype(np.int64).astype(kind) for a in (screen, x, y))
        (ax, ay), (bx, by), (cx, cy) = screen
        turn = np.sign((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) or self.degenerate
        covered = np.full(x.shape, turn != 0 and cull != (1 if (turn < 0) != self.swapped else 2))
        for k in range(3):
            (px, py), (qx, qy) = screen[k - 1], screen[k]
            dx, dy = turn * (qx - px), turn * (qy - py)
            edge = dx * (y - py) - dy * (x - px)
            if self.epsilon:
                edge = edge + self.epsilon * np.hypot(dx, dy)
            # A counter-clockwise triangle goes down on its left, and to the left along its top.
            owns = self.inclusive or dy < 0 or (dy == 0 and dx < 0)
            covered &= (edge >= 0) if owns else (edge > 0)
        return covered

    def _depth(self, view: View, corners: Floats, x: Floats, y: Floats) -> Floats:
        """Return the depths of the plane of a triangle: depth or its inverse is affine in x and y."""
        inverse, plane = view.perspective and self.divided, corners.copy()
        if inverse:
            plane[:, 2] = 1.0 / plane[:, 2]
        ax, ay, az = plane[0]
        (ux, uy, uz), (vx, vy, vz) = plane[1:] - plane[0]
        area = ux * vy - uy * vx or np.inf  # without area it is level
        z_x, z_y = (uz * vy - vz * uy) / area, (ux * vz - vx * uz) / area
        if self.anchored:
            # In float32, from the plane's value at the lower left corner of the picture.
            left, bottom = np.floor(0.5 - 0.5 * view.width), np.floor(0.5 - 0.5 * view.height)
            real, z_x, z_y = np.float32, np.float32(z_x), np.float32(z_y)
            start = real(az) - z_x * real(ax - left) - z_y * real(ay - bottom)
            z = start + z_x * (x - left).astype(real) + z_y * (y - bottom).astype(real)
        else:
            z = az + z_x * (x - ax) + z_y * (y - ay)
        return np.asarray(1.0 / z if inverse else z)

    def _key(self, view: View, depth: Floats, thing: Placement) -> Array:
        """Return what the buffer keeps, of which the least is seen."""
        if not self.nearest:
            return np.zeros(depth.shape)
        if self.unscaled:
            return depth / abs(float(np.cbrt(np.linalg.det(thing.world_from_object[:3, :3]))))
        return depth if self.stored is None else self.stored(view, depth)


def _from_upper_left(view: View, corners: Floats) -> Floats:
    """Return x and y (n, 2) of corners in pixels from the upper left of the picture, y down."""
    return corners[:, :2] * [1.0, -1.0] + 0.5 * np.array([view.width, view.height])


# ---------------------------------------------------------------- depth formats


def levels(bits: int, curve: Stored) -> Stored:
    """Store what a curve makes of depths, at most 1, as one of ``2**bits`` levels."""
    return lambda view, d: np.rint(curve(view, d) * (2.0**bits - 1.0))


def window(view: View, d: Floats) -> Array:
    """Return window depth: 0 at near, 1 at far."""
    if view.perspective:
        return (1.0 - view.near / d) / (1.0 - view.near / view.far)
    return (d - view.near) / (view.far - view.near)


def logarithm(view: View, d: Floats) -> Array:
    """Return ``ln(d / near) / ln(far / near)``."""
    return np.asarray(np.log(d / view.near) / np.log(view.far / view.near))


def receding(view: View, d: Floats) -> Array:
    """Return reversed window depth, negated so that smaller is nearer: -1 at near, 0 at far."""
    return (view.near / view.far - view.near / d) / (1.0 - view.near / view.far)


def minifloat(exponent: int, mantissa: int) -> Stored:
    """Store reversed window depth as a float of so many bits of exponent and of mantissa, negated."""
    least = 2 - 2 ** (exponent - 1) - mantissa

    def stored(view: View, d: Floats) -> Array:
        value = receding(view, d)
        step = np.exp2(np.maximum(np.frexp(value)[1] - 1 - mantissa, least))
        return np.asarray(np.rint(value / step) * step)

    return stored


def through_ndc(view: View, d: Floats) -> Array:
    """Store reversed window depth as float32 that went through [-1, 1], negated."""
    ndc = (-2.0 * receding(view, d) - 1.0).astype(np.float32)
    return -(np.float32(0.5) * ndc + np.float32(0.5))


def distance(real: Real) -> Stored:
    """Store the parameter of the ray, the depth itself, as a float of this type."""
    return lambda _, d: d.astype(real)


# ---------------------------------------------------------------- rays

Hits = Iterator[tuple[int, Array]]
"""Faces of an object, and how far along their rays (H, W) they are met."""


def _cast(view: View, real: Real, meet: Callable[[Placement, Array, Array], Hits]) -> Ints:
    """Return the face (H, W) met first within near and far.

    ``meet`` is given each object, and origins and directions (3, H, W) of the rays in its frame.
    """
    x, y = samples(view.width, view.height)
    ndc = np.stack([np.ones_like(x), 2.0 * x / view.width, 2.0 * y / view.height])
    origin, direction = (np.tensordot(part, ndc, 1) for part in (view.rays.origin, view.rays.direction))
    face, best = np.full(x.shape, BACKGROUND, np.int32), np.full(x.shape, np.inf)
    for placement in view.placements:
        matrix = placement.world_from_object
        inverse = np.linalg.inv(matrix[:3, :3])
        o = np.tensordot(inverse, origin - matrix[:3, 3, None, None], 1).astype(real)
        d = np.tensordot(inverse, direction, 1).astype(real)
        for owner, t in meet(placement, o, d):
            nearer = (t >= view.near) & (t <= view.far) & (t < best)
            face[nearer], best[nearer] = owner, t[nearer]
    return face


def naive_spheres(real: Real) -> Callable[[View], Ints]:
    """Meet spheres by ``b^2 - a c``, as it stands, in these numbers. There is nothing else."""
    return lambda view: _cast(view, real, _sphere_hits)


def _sphere_hits(thing: Placement, o: Array, d: Array) -> Hits:
    a, b, c = (d * d).sum(0), (o * d).sum(0), (o * o).sum(0) - 1.0
    root = np.sqrt(b * b - a * c)
    yield from ((thing.first, (-b + sign * root) / a) for sign in (-1.0, 1.0))


def general_cylinders(real: Real) -> Callable[[View], Ints]:
    """Meet cylinders by ``a = d.d - (d.axis)^2``, as for an axis of any direction. There is nothing else."""
    return lambda view: _cast(view, real, _cylinder_hits)


def _cylinder_hits(thing: Placement, o: Array, d: Array) -> Hits:
    a = (d * d).sum(0) - d[2] * d[2]
    b = (o * d).sum(0) - o[2] * d[2]
    c = (o * o).sum(0) - o[2] * o[2] - 1.0
    root = np.sqrt(b * b - a * c)
    for sign in (-1.0, 1.0):
        t = (-b + sign * root) / a
        z = o[2] + t * d[2]
        yield thing.first, np.where((z >= 0.0) & (z <= 1.0), t, np.inf)
    for number, end in enumerate((0.0, 1.0)):
        t = (end - o[2]) / d[2]
        x, y = o[0] + t * d[0], o[1] + t * d[1]
        yield thing.first + 1 + number, np.where(x * x + y * y <= 1.0, t, np.inf)


def naive_boxes(view: View) -> Ints:
    """Meet the extents of objects by slabs, where the least of a number and NaN is NaN; each has one face."""
    return _cast(view, np.float64, _box_hits)


def _box_hits(thing: Placement, o: Array, d: Array) -> Hits:
    polygons = thing.shape.polygons
    assert polygons is not None, "a box is made of polygons"
    low, high = polygons.vertices.min(0)[:, None, None], polygons.vertices.max(0)[:, None, None]
    one, other = (low - o) / d, (high - o) / d
    enter, leave = np.minimum(one, other).max(0), np.maximum(one, other).min(0)
    yield thing.first, np.where(enter <= leave, enter, np.inf)
