"""The depth buffer, stage by stage.

================  =============================================================================
Stage             Model: the exact answer for
================  =============================================================================
tessellation      curved shapes replaced by polygons
input rounding    the polygons in world space, as rounded
transform         the polygons in clip space, as rounded
clipping          the clipped polygons in clip space, as rounded
vertex snapping   the clipped polygons on the screen, as snapped, and rounded to float64 or float32
fill rule         those of the same polygons that the method itself draws at the sample; of equal
                  depths the one that its depth test keeps
depth arithmetic  (the method itself, but that depths are stored as they are interpolated)
depth format      (the method itself)
================  =============================================================================

A buffer that holds the numbers of the arithmetic rounds nothing, and the last two agree. The last model is
the method run once more: that it shows the same proves that the method does not depend on chance, and
the other models say at which stage it leaves the truth.

For the fill rule bottom-left the screen is the mirrored one, y counted from the bottom.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from fractions import Fraction

import numpy as np

from hsr.algorithms.prepare.depth_formats import unrounded
from hsr.algorithms.scanline import TESTS, Options, cull_on_screen, depths_in, render, screen_of, upright
from hsr.base.arrays import Array, Floats, Ints
from hsr.exact.oracle import owners
from hsr.kernels.clipping import clip_polygons, view_volume
from hsr.kernels.polygon_table import PolygonTable, polygon_table
from hsr.kernels.projection import clip_rows, to_clip
from hsr.kernels.strips import scan_convert
from hsr.models.rounded import (
    TESSELLATED,
    fractions,
    of_polygons,
    seen_along_third,
    seen_from_front,
)
from hsr.models.stages import Cause, ending, named, rerun
from hsr.problem.map import BACKGROUND
from hsr.problem.view import View, WorldPolygons

# ---------------------------------------------------------------- up to the screen


def input_rounding(view: View, options: Options, samples: Array) -> Ints:
    """Model the rounding of world points."""
    view = view.tessellated()
    return _judged(view, view.polygons, view, options, samples)


def transform(view: View, options: Options, samples: Array) -> Ints:
    """Model the rounding of clip coordinates."""
    view = view.tessellated()
    polygons = replace(view.polygons, vertices=_clip(view))
    return _judged(seen_along_third(view), polygons, view, options, samples)


def clipping(view: View, options: Options, samples: Array) -> Ints:
    """Model the rounding of the corners that clipping makes."""
    view = view.tessellated()
    return _judged(seen_along_third(view), _clipped(view), view, options, samples)


def vertex_snapping(view: View, options: Options, samples: Array) -> Ints:
    """Model the snapping and rounding of screen coordinates."""
    view = view.tessellated()
    polygons = on_screen(view, options)
    # The depths have been cut to near and far in clip space, and are not cut again.
    drawn = polygons.vertices[polygons.corner, 2]
    near, far = float(drawn.min(initial=0.0)) - 1.0, float(drawn.max(initial=0.0)) + 1.0
    seen = seen_from_front(view, near, far, y_up=options.upside_down)
    return _judged(seen, polygons, view, options, samples)


def _judged(seen: View, polygons: WorldPolygons, view: View, options: Options, samples: Array) -> Ints:
    """Return the exact owners of samples if these polygons are all there is to see.

    Only those are looked at that the method may draw there, and those that it clips away: none of the
    roundings moves a polygon by a pixel.
    """
    drawn = on_screen(view, options)
    chosen = np.diff(drawn.start) < 3
    chosen[_reaching(view, drawn, _scanned(view, options, samples))[0]] = True
    return owners(of_polygons(seen, polygons, chosen), samples)


def _clip(view: View) -> Floats:
    return to_clip(view.polygons.vertices, clip_rows(view.clip_from_world, view.depth_row))


def _clipped(view: View) -> WorldPolygons:
    """Return the polygons in clip space, cut to the view volume."""
    polygons, planes = view.polygons, view_volume(view.near, view.far, view.perspective)
    vertices, corner, start = clip_polygons(_clip(view), polygons.corner, polygons.start, planes)
    return replace(polygons, vertices=vertices, corner=corner, start=start)


def on_screen(view: View, options: Options) -> WorldPolygons:
    """Return the clipped polygons as they are scan converted, of the type of the arithmetic."""
    clipped = _clipped(view)
    depths = depths_in(view, clipped.vertices, clipped.corner, options)
    screen = screen_of(view, clipped.vertices, depths, options)
    return replace(clipped, vertices=screen)


def _scanned(view: View, options: Options, samples: Array) -> Array:
    """Return the numbers of samples in the picture as it is scan converted."""
    number = np.arange(view.height * view.width).reshape(view.height, view.width)
    return np.asarray(upright(number, options).ravel()[samples])


def _reaching(view: View, polygons: WorldPolygons, samples: Array) -> tuple[Array, Array]:
    """Find the polygons that can be drawn at one of the samples.

    Returns
    -------
    number : (n,) int64
    box : (n, 4) int64
        First row and column, and end row and column, that each can be drawn at.
    """
    whole = np.flatnonzero(np.diff(polygons.start) >= 3)
    box = _boxes(view, polygons, polygons.start[whole])
    asked = np.zeros((view.height + 1, view.width + 1), dtype=np.int64)
    row, column = np.divmod(samples, view.width)
    asked[row + 1, column + 1] = 1
    above_left = asked.cumsum(axis=0).cumsum(axis=1)
    top, left, bottom, right = box.T
    inside = above_left[bottom, right] - above_left[top, right]
    inside += above_left[top, left] - above_left[bottom, left]
    return whole[inside > 0], box[inside > 0]


def _boxes(view: View, polygons: WorldPolygons, first: Ints) -> Array:
    """Return the rows and columns (n, 4) that the polygons whose corners begin at ``first`` can cover.

    x, below 2 W with the guard band, goes down a side in at most H steps. Each rounds it by at most half
    an ulp, which is at most W eps; the slope's own rounding adds as much once, and everything before
    the first step less than a pixel.
    """
    points = polygons.vertices[polygons.corner, 1::-1].astype(np.float64)
    slack = 1.0 + view.width * (view.height + 1) * float(np.finfo(polygons.vertices.dtype).eps)
    ends = np.array([view.height, view.width])
    low = np.clip(np.floor(np.minimum.reduceat(points, first) - slack), 0, ends)
    high = np.clip(np.ceil(np.maximum.reduceat(points, first) + slack), 0, ends)
    return np.concatenate([low, high], axis=1).astype(np.int64)


# ---------------------------------------------------------------- scan conversion


def fill_rule(view: View, options: Options, samples: Array) -> Ints:
    """Model the coverage: of the polygons that the method draws at a sample, the nearest."""
    view, samples = view.tessellated(), _scanned(view, options, samples)
    polygons = on_screen(view, options)
    drawn = _drawn(view, polygons, layers_of(view, polygons, samples), options)
    return nearest_drawn(view, polygons, drawn, samples, later=options.depth_test == "less-equal")


def nearest_drawn(
    view: View, polygons: WorldPolygons, drawn: Iterable[Ints], samples: Array, later: bool = False
) -> Ints:
    """Return the face of the nearest polygon drawn at each sample.

    Parameters
    ----------
    view : View
    polygons : WorldPolygons
        On the screen.
    drawn : iterable of (H, W) int32
        For each layer the polygon drawn at each sample, or -1.
    samples : (n,) int64
    later : bool
        Whether of equal depths the higher face is shown, or the lower.

    Returns
    -------
    (n,) int32
    """
    planes: dict[int, tuple[Fraction, Fraction, Fraction]] = {}
    nearest: list[tuple[Fraction | float, int]] = [(math.inf, BACKGROUND)] * len(samples)
    order = -1 if later else 1
    row, column = np.divmod(samples, view.width)
    for layer in drawn:
        number = layer[row, column]
        for k in np.flatnonzero(number >= 0):
            i = int(number[k])
            if i not in planes:
                planes[i] = _plane(polygons, i)
            constant, z_x, z_y = planes[i]
            z = constant + z_x * int(2 * column[k] + 1) + z_y * int(2 * row[k] + 1)
            nearest[k] = min(nearest[k], (z, order * int(polygons.face[i])))
    return np.array([BACKGROUND if z == math.inf else order * face for z, face in nearest], dtype=np.int32)


def layers_of(view: View, polygons: WorldPolygons, samples: Array) -> list[list[int]]:
    """Share out the polygons so that no two of a layer can be drawn at the same one of the samples."""
    first_free = np.full((view.height, view.width), -1, dtype=np.int64)
    first_free.ravel()[samples] = 0
    layers: list[list[int]] = []
    for i, (top, left, bottom, right) in zip(*_reaching(view, polygons, samples), strict=True):
        within = first_free[top:bottom, left:right]
        layer = int(within.max())
        within[within >= 0] = layer + 1
        layers.extend([] for _ in range(layer + 1 - len(layers)))
        layers[layer].append(int(i))
    return layers


def _drawn(
    view: View, polygons: WorldPolygons, layers: Iterable[list[int]], options: Options
) -> Iterator[Ints]:
    """Scan convert each layer of polygons by itself, and yield the number (H, W) of that at each sample."""
    size, number = (view.width, view.height), np.arange(len(polygons), dtype=np.int32)
    table = _table(polygons, number, options, size)
    for layer in layers:
        some = table._replace(plane=table.plane[layer], row=table.row[layer])
        yield scan_convert(some, size, options.directly)[1]


def _table(polygons: WorldPolygons, number: Ints, options: Options, size: tuple[int, int]) -> PolygonTable:
    screen, cull = polygons.vertices, cull_on_screen(polygons.cull, options)
    return polygon_table(screen, polygons.corner, polygons.start, number, cull, size)


def _plane(polygons: WorldPolygons, i: int) -> tuple[Fraction, Fraction, Fraction]:
    """Return p, q and r of the depth ``p + q (2 column + 1) + r (2 row + 1)`` of a polygon, exact.

    The plane through its first corner, with the normal of Newell's method. A polygon that only rounding
    keeps from being edge-on has its first corner's depth.
    """
    points = fractions(polygons.vertices[polygons.corner[polygons.start[i] : polygons.start[i + 1]]])
    (x, y, z), sides = points[0], points[1:] - points[0]
    a, b, c = np.cross(sides[:-1], sides[1:]).sum(axis=0)
    z_x, z_y = (-a / c, -b / c) if c else (Fraction(0), Fraction(0))
    return z - z_x * x - z_y * y, z_x / 2, z_y / 2


# ---------------------------------------------------------------- the method itself


def depth_arithmetic(view: View, options: Options, samples: Array) -> Ints:
    """Run the method without rounding depths to what the buffer holds."""
    view, samples = view.tessellated(), _scanned(view, options, samples)
    polygons, size = on_screen(view, options), (view.width, view.height)
    form = unrounded(TESTS[options.depth_test], options.arithmetic == "fixed")
    table = _table(polygons, polygons.face, options, size)
    face = scan_convert(table, size, options.directly, form=form)[1]
    return np.asarray(face.ravel()[samples])


MODELS = named(input_rounding, transform, clipping, vertex_snapping, fill_rule, depth_arithmetic)
PIPELINE = ending(rerun(render), Cause.DEPTH_FORMAT, TESSELLATED, *MODELS)
