"""Renderers in the open, in which the classic mistakes are planted.

They exist to be wrong where theory says so: a depth buffer that tries every triangle at every sample, and a
ray caster of spheres and cylinders by the formulas of a first draft. Neither clips.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.kernels.projection import clip_rows
from hsr.problem.map import BACKGROUND
from hsr.problem.view import Placement, View

Real = type[np.floating[Any]]

GRID = 256
"""Fractions of a pixel on which ``whole`` edge functions put their corners."""


def samples(width: int, height: int) -> tuple[Floats, Floats]:
    """Return x and y (H, W) of the samples, in pixels from the middle of the picture, y up."""
    y, x = np.mgrid[:height, :width]
    return x + 0.5 - 0.5 * width, 0.5 * height - 0.5 - y


@dataclass(frozen=True)
class Buffer:
    """A depth buffer in NumPy; each field but its default is a mistake, or a depth format.

    Attributes
    ----------
    stored : callable, optional
        What is kept of the depths (n,) of a view, ascending; depths themselves by default.
    real : type
        Of the matrix, the vertices and their product.
    composed : bool
        Whether depth is read off z and w of the one matrix that has the near distance in it.
    epsilon : float
        How far outside an edge, as a multiple of its length in pixels, a sample may lie and still be covered.
    inclusive : bool
        Whether both neighbours own the samples on their edge, and triangles without area their edges.
    whole : type, optional
        Integer type of edge functions, of corners on a grid of 1/256 pixel; it may wrap around.
    anchored : bool
        Whether the plane of depth is evaluated from the corner of the picture, and in float32.
    after_near : bool
        Whether what lies exactly on the near plane is lost.
    """

    stored: Callable[[View, Floats], Array] | None = None
    real: Real = np.float64
    composed: bool = False
    epsilon: float = 0.0
    inclusive: bool = False
    whole: type[np.signedinteger[Any]] | None = None
    anchored: bool = False
    after_near: bool = False

    def __call__(self, view: View) -> Ints:
        """Return the face (H, W) of every sample."""
        x, y = samples(view.width, view.height)
        face, best = np.full(x.shape, BACKGROUND, np.int32), np.full(x.shape, np.inf)
        for screen, owner in zip(self._screen(view), view.triangle_face, strict=True):
            covered = self._covered(screen, x, y)
            depth = self._depth(screen, x, y, view.perspective)
            covered &= (depth > view.near if self.after_near else depth >= view.near) & (depth <= view.far)
            key = depth if self.stored is None else self.stored(view, depth)
            nearer = covered & (key < best)
            face[nearer], best[nearer] = owner, key[nearer]
        return face

    def _screen(self, view: View) -> Floats:
        """Return the corners (n, 3, 3): pixels from the middle of the picture, y up, and depth."""
        rows = clip_rows(view.clip_from_world, view.depth_row).astype(self.real)
        vertices = view.polygons.vertices.astype(self.real)
        clip = (vertices @ rows[:, :3].T + rows[:, 3]).astype(np.float64)
        if self.composed:
            z, w = (vertices @ row[:3] + row[3] for row in view.clip_from_world[2:].astype(self.real))
            clip[:, 2] = 2.0 * view.near / (1.0 - z / w)  # without a far plane z / w is 1 - 2 near / d
        half = 0.5 * np.array([view.width, view.height])
        clip[:, :2] *= half / clip[:, 2:] if view.perspective else half
        return clip[view.polygons.triangle_vertex]

    def _covered(self, screen: Floats, x: Floats, y: Floats) -> Bools:
        """Tell which samples (H, W) a triangle covers; left and top edges own theirs."""
        if self.whole is not None:
            kind = self.whole
            screen, x, y = (np.rint(a * GRID).astype(np.int64).astype(kind) for a in (screen[:, :2], x, y))
        (ax, ay), (bx, by), (cx, cy) = screen[:, :2]
        turn = np.sign((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) or self.inclusive
        covered = np.full(x.shape, turn != 0)
        for k in range(3):
            (px, py), (qx, qy) = screen[k - 1, :2], screen[k, :2]
            dx, dy = turn * (qx - px), turn * (qy - py)
            edge = dx * (y - py) - dy * (x - px)
            if self.epsilon:
                edge = edge + self.epsilon * np.hypot(dx, dy)
            # A counter-clockwise triangle goes down on its left, and to the left along its top.
            owns = self.inclusive or dy < 0 or (dy == 0 and dx < 0)
            covered &= (edge >= 0) if owns else (edge > 0)
        return covered

    def _depth(self, screen: Floats, x: Floats, y: Floats, perspective: bool) -> Floats:
        """Return the depth (H, W) of the plane of a triangle: depth or its inverse is affine in x and y."""
        plane = screen.copy()
        if perspective:
            plane[:, 2] = 1.0 / plane[:, 2]
        (ax, ay, az), b, c = plane
        (ux, uy, uz), (vx, vy, vz) = b - plane[0], c - plane[0]
        area = ux * vy - uy * vx or np.inf  # without area it is level
        z_x, z_y = (uz * vy - vz * uy) / area, (ux * vz - vx * uz) / area
        z = az + z_x * (x - ax) + z_y * (y - ay)
        if self.anchored:
            z = _from_the_corner(x, y, (ax, ay, az), (z_x, z_y))
        return np.asarray(1.0 / z if perspective else z)


def _from_the_corner(
    x: Floats, y: Floats, at: tuple[float, float, float], slope: tuple[float, float]
) -> Floats:
    """Evaluate a plane in float32 from its value at the lower left corner of the picture."""
    left, bottom = np.floor(x.min()), np.floor(y.min())
    z_x, z_y = np.float32(slope[0]), np.float32(slope[1])
    start = np.float32(at[2]) - z_x * np.float32(at[0] - left) - z_y * np.float32(at[1] - bottom)
    return np.asarray(start + z_x * (x - left).astype(np.float32) + z_y * (y - bottom).astype(np.float32))


# ---------------------------------------------------------------- depth formats


def levels_of_logarithm(bits: int) -> Callable[[View, Floats], Array]:
    """Store ``ln(d / near) / ln(far / near)`` as one of ``2**bits`` levels."""
    top = 2.0**bits - 1.0
    return lambda view, d: np.floor(np.log(d / view.near) / np.log(view.far / view.near) * top + 0.5)


def levels_of_reversed(bits: int) -> Callable[[View, Floats], Array]:
    """Store reversed window depth as one of ``2**bits`` levels, negated so that smaller is nearer."""
    top = 2.0**bits - 1.0
    return lambda view, d: -np.floor(reversed_window(view, d) * top + 0.5)


def minifloat(exponent: int, mantissa: int) -> Callable[[View, Floats], Array]:
    """Store reversed window depth as a float of so many bits of exponent and of mantissa, negated."""
    least = 2 - 2 ** (exponent - 1) - mantissa

    def stored(view: View, d: Floats) -> Array:
        value = reversed_window(view, d)
        step = np.exp2(np.maximum(np.frexp(value)[1] - 1 - mantissa, least))
        return np.asarray(-np.rint(value / step) * step)

    return stored


def reversed_through_ndc(view: View, d: Floats) -> Array:
    """Store reversed window depth as float32 that went through [-1, 1], negated."""
    ndc = (2.0 * reversed_window(view, d) - 1.0).astype(np.float32)
    return -(np.float32(0.5) * ndc + np.float32(0.5))


def reversed_window(view: View, d: Floats) -> Floats:
    """Return 1 minus window depth: 1 at near, 0 at far."""
    return (view.near / d - view.near / view.far) / (1.0 - view.near / view.far)


def distance(real: Real) -> Callable[[View, Floats], Array]:
    """Store the parameter of the ray, the depth itself, as a float of this type."""
    return lambda _, d: d.astype(real)


# ---------------------------------------------------------------- rays


def _object_rays(view: View, real: Real) -> Iterator[tuple[Placement, Array, Array]]:
    """Yield every object, and origins and directions (3, H, W) of the rays in its frame."""
    x, y = samples(view.width, view.height)
    ndc = np.stack([np.ones_like(x), 2.0 * x / view.width, 2.0 * y / view.height])
    origin, direction = (np.tensordot(part, ndc, 1) for part in (view.rays.origin, view.rays.direction))
    for placement in view.placements:
        matrix = placement.world_from_object
        inverse = np.linalg.inv(matrix[:3, :3])
        o = np.tensordot(inverse, origin - matrix[:3, 3, None, None], 1)
        d = np.tensordot(inverse, direction, 1)
        yield placement, o.astype(real), d.astype(real)


def _nearest(view: View, hits: Iterator[tuple[int, Array]]) -> Ints:
    """Return the face (H, W) of the least t within near and far, among faces and their t (H, W)."""
    face = np.full((view.height, view.width), BACKGROUND, np.int32)
    best = np.full(face.shape, np.inf)
    for owner, t in hits:
        nearer = (t >= view.near) & (t <= view.far) & (t < best)
        face[nearer], best[nearer] = owner, t[nearer]
    return face


def naive_spheres(real: Real) -> Callable[[View], Ints]:
    """Meet spheres by ``b^2 - a c``, as it stands, in these numbers. There is nothing else."""

    def hits(view: View) -> Iterator[tuple[int, Array]]:
        for placement, o, d in _object_rays(view, real):
            a, b, c = (d * d).sum(0), (o * d).sum(0), (o * o).sum(0) - real(1.0)
            root = np.sqrt(b * b - a * c)
            yield from ((placement.first, (-b + sign * root) / a) for sign in (real(-1.0), real(1.0)))

    return lambda view: _nearest(view, hits(view))


def general_cylinders(real: Real) -> Callable[[View], Ints]:
    """Meet cylinders by ``a = d.d - (d.axis)^2``, as for an axis of any direction. There is nothing else."""

    def hits(view: View) -> Iterator[tuple[int, Array]]:
        for placement, o, d in _object_rays(view, real):
            a = (d * d).sum(0) - d[2] * d[2]
            b = (o * d).sum(0) - o[2] * d[2]
            c = (o * o).sum(0) - o[2] * o[2] - real(1.0)
            root = np.sqrt(b * b - a * c)
            for sign in (real(-1.0), real(1.0)):
                t = (-b + sign * root) / a
                z = o[2] + t * d[2]
                yield placement.first, np.where((z >= 0.0) & (z <= 1.0), t, np.inf)
            for number, end in enumerate((real(0.0), real(1.0))):
                t = (end - o[2]) / d[2]
                x, y = o[0] + t * d[0], o[1] + t * d[1]
                yield placement.first + 1 + number, np.where(x * x + y * y <= 1.0, t, np.inf)

    return lambda view: _nearest(view, hits(view))


def naive_boxes(view: View) -> Ints:
    """Meet the extents of objects by slabs, where the least of a number and NaN is NaN; each has one face."""

    def hits() -> Iterator[tuple[int, Array]]:
        for placement, o, d in _object_rays(view, np.float64):
            polygons = placement.shape.polygons
            assert polygons is not None, "a box is made of polygons"
            low, high = polygons.vertices.min(0)[:, None, None], polygons.vertices.max(0)[:, None, None]
            one, other = (low - o) / d, (high - o) / d
            enter, leave = np.minimum(one, other).max(0), np.maximum(one, other).min(0)
            yield placement.first, np.where(enter <= leave, enter, np.inf)

    return _nearest(view, hits())
