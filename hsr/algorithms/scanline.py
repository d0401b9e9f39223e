"""The depth buffer: polygons scan converted one after the other, the nearest kept at each sample.

The stages are the textbook's: world points go to clip space, polygons are clipped, what is left is
divided by w and mapped to the screen, the polygon table is set up (culling what the scene says), and the
polygons are scan converted. :mod:`hsr.kernels.scanline` says who owns a sample on an edge and who wins
between equal depths; the limit rule that decides ties exactly is not applied.

A face of more than three corners is one polygon here, and taken to be planar and convex up to rounding.

Most variants differ in what the kernel is given: corners on a grid, a picture upside down, another function
of depth (:mod:`hsr.algorithms.prepare.depth_formats`).
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr.algorithms.prepare import choices
from hsr.algorithms.prepare.depth_formats import FORMATS, Depths, Real, depths_of
from hsr.base.arrays import Array, Floats, Ints
from hsr.base.errors import MethodError
from hsr.kernels.clipping import clip_polygons, view_volume
from hsr.kernels.culling import CULL_BACK, CULL_BOTH, CULL_FRONT
from hsr.kernels.depth_buffer import FRAGMENTS, LESS, LESS_EQUAL, PASSED, SCAN_LINES, SPANS
from hsr.kernels.polygon_table import FATE, polygon_table
from hsr.kernels.projection import clip_rows, to_clip, to_screen
from hsr.kernels.strips import scan_convert
from hsr.problem.map import Clock, VisibilityMap
from hsr.problem.view import View
from hsr.scene.shapes import Polygons

ARITHMETIC: dict[str, Real] = {"float64": np.float64, "float32": np.float32, "fixed": np.float64}
FILL_RULES = {"top-left": False, "bottom-left": True}
"""Whether the picture is scan converted upside down."""
TESTS = {"less": LESS, "less-equal": LESS_EQUAL}

GUARD_BITS = 24
"""The most there are: a depth of 24 + 24 bits leaves room below ``2**53`` for what lies outside [0, 1]."""

CHOICES: dict[str, Collection[Any]] = {
    "stepping": ("incremental", "direct"),
    "arithmetic": ARITHMETIC,
    "guard_bits": range(GUARD_BITS + 1),
    "subpixel_bits": (None, 4, 8, 12),
    "fill_rule": FILL_RULES,
    "depth_format": FORMATS,
    "depth_test": TESTS,
}
"""What each option may be."""

FATES = ("clipped_away", "missed", "edge_on", "culled", "set_up")
"""What became of polygons, in the order of the kernels."""

MIRRORED = np.array([1.0, -1.0, 1.0])
"""Turns clip space upside down; negating a number is exact."""

OTHER_SIDE = np.array([0, CULL_FRONT, CULL_BACK, CULL_BOTH], np.int8)
"""What to cull in a mirrored picture, where counter-clockwise has become clockwise."""


@dataclass(frozen=True)
class Options:
    """How polygons are scan converted, and in which numbers.

    Attributes
    ----------
    stepping : {"incremental", "direct"}
        Whether sides and depths go on by increments, as textbooks have it, or are evaluated anew for
        every scan line and every sample.
    arithmetic : {"float64", "float32", "fixed"}
        Of everything after the viewport: screen coordinates are computed in float64 and rounded to
        this type; planes, edges and spans are in it throughout. ``fixed`` steps depth in whole numbers,
        in units of ``2**-guard_bits`` depth steps: the plane is set up in float64, then the depth at the
        top of each edge and at the first sample of each span and the increments ``-A/C`` and
        ``-(A/m + B)/C`` are rounded to the nearest of them. x stays in float64.
    guard_bits : int
        With ``fixed``, the bits that stepped depth has beyond those stored, 0 to 24.
    subpixel_bits : {None, 4, 8, 12}
        If given, x and y of the corners on the screen are rounded to multiples of ``2**-subpixel_bits``
        pixels, halves to even, before anything is set up. The plane of depth goes through the moved
        corners, with the depths they had; culling asks for the facing after the move.
    fill_rule : {"top-left", "bottom-left"}
        Which horizontal edges own the samples on them. For ``bottom-left`` y is negated in clip space,
        which is exact, and the picture scan converted upside down.
    depth_format : {"float64", "d16", "d24", "d32f", "d32f-reversed", "w16", "w24", "1/w"}
        What the depth buffer holds; every fragment's depth is brought to it before the test.
        ``float64``, ``d32f``: window depth, 0 at near and 1 at far, rounded to that type.
        ``d16``, ``d24``: window depth clamped to [0, 1], as the nearest n of ``n / (2**N - 1)``, halves
        up; with ``fixed`` the upper 24 of 24 + guard_bits bits. The buffer starts with the greatest n,
        as far as the far plane, which passes the test *less* no more.
        ``d32f-reversed``: 1 minus window depth, 1 at near and 0 at far, computed without cancellation and
        rounded to float32; the greater is the nearer.
        ``w16``, ``w24``: linear depth ``(d - near) / (far - near)``, stored like d16 and d24. It is not
        affine on the screen: ``-1 / d`` is interpolated, and every fragment costs a division. If far is
        infinite, the deepest corner of what is drawn is given the level before the greatest.
        ``1/w``: ``1 / d`` rounded to float32; the greater is the nearer. Perspective views only.
    depth_test : {"less", "less-equal"}
        Whether of equal stored depths the lower face id stays, or the higher comes.
    count : bool
        Count the work, in kernels compiled for that.
    """

    stepping: str = "incremental"
    arithmetic: str = "float64"
    guard_bits: int = 0
    subpixel_bits: int | None = None
    fill_rule: str = "top-left"
    depth_format: str = "float64"
    depth_test: str = "less"
    count: bool = False

    def __post_init__(self) -> None:
        choices.check("scanline", self, CHOICES)
        if self.arithmetic == "fixed" and (self.stepping, self.depth_format) != ("incremental", "d24"):
            raise MethodError(
                f"scanline: fixed arithmetic is incremental and stored as d24, not {self.stepping} and "
                f"{self.depth_format}; choose both, or another arithmetic"
            )
        if self.guard_bits and self.arithmetic != "fixed":
            raise MethodError(f"scanline: {self.arithmetic} has no guard bits; choose the arithmetic fixed")

    @property
    def directly(self) -> bool:
        """Whether sides and depths are evaluated anew."""
        return self.stepping == "direct"

    @property
    def upside_down(self) -> bool:
        """Whether the picture is scan converted upside down."""
        return FILL_RULES[self.fill_rule]


def render(view: View, options: Options) -> VisibilityMap:
    """Render a view with a depth buffer.

    Parameters
    ----------
    view : View
        Curved shapes are tessellated.
    options : Options

    Returns
    -------
    VisibilityMap
        ``seconds``: ``prepare`` puts the polygons into world space, once a view; ``render`` is all the
        rest. ``work``: ``polygons`` and ``buffer_bytes``, of depths and face ids together; if counted, also
        what became of the polygons (``clipped_away``, ``cut``, ``missed``: no sample in their bounding
        box, ``edge_on``, ``culled``, ``set_up``), their ``scan_lines``, ``spans`` and ``fragments``,
        ``depth_passed`` and ``depth_failed``, and ``overdraw``: what was written and overwritten later.

    Raises
    ------
    MethodError
        If the depth format does not work in this view.
    """
    clock = Clock()
    with clock("prepare"):
        view = view.tessellated()
        polygons = view.polygons
    with clock("render"):
        clip = to_clip(polygons.vertices, clip_rows(view.clip_from_world, view.depth_row))
        drawn = view, polygons, clip, polygons.cull
        face, depth, work, depths = scan_polygons(*drawn, options, TESTS[options.depth_test])
    stored = depths.note(ARITHMETIC[options.arithmetic])
    return VisibilityMap(face, depth, "scanline", work, clock.seconds, {"depth_format": stored})


def scan_polygons(
    view: View, polygons: Polygons, clip: Floats, cull: Array, options: Options, test: int
) -> tuple[Ints, Floats, dict[str, int], Depths]:
    """Take polygons from clip space to the buffers.

    Parameters
    ----------
    view : View
        For its camera and size.
    polygons : Polygons
        In the order in which they are drawn.
    clip : (V, 3) float64
        Their vertices in clip space.
    cull : (P,) int8
        What not to draw: 0 nothing, 1 back faces, 2 front faces, 3 both.
    options : Options
        Its depth test is not heeded.
    test : int
        The depth test, see :class:`hsr.kernels.depth_buffer.Form`.

    Returns
    -------
    face : (H, W) int32
    depth : (H, W) float64
    work : dict of str to int
    depths : Depths
        The depth format in this view.
    """
    size = (view.width, view.height)
    planes = view_volume(view.near, view.far, view.perspective)
    points, corner, start = clip_polygons(clip, polygons.corner, polygons.start, planes)
    depths = depths_in(view, points, corner, options)
    screen = screen_of(view, points, depths, options)
    table = polygon_table(screen, corner, start, polygons.face, cull_on_screen(cull, options), size)
    form = depths.form(test)
    z, face, counts = scan_convert(table, size, options.directly, options.count, depths.held, form)
    work = {"polygons": len(polygons), "buffer_bytes": z.nbytes + face.nbytes}
    if counts is not None:
        cut = _cut_polygons(corner, start, len(clip))
        fates = np.bincount(table.row[:, FATE], minlength=len(FATES)).tolist()
        work |= {"cut": cut} | dict(zip(FATES, fates, strict=True))
        work |= _counts(counts, int(np.count_nonzero(face >= 0)))
    depth = depths.distance(z, face)
    return upright(face, options), upright(depth, options), work, depths


def depths_in(view: View, points: Floats, corner: Ints, options: Options) -> Depths:
    """Return the depth format in a view of which these corners of these points, in clip space, are drawn."""
    deepest = float(points[corner, 2].max(initial=view.near))
    guard = options.guard_bits if options.arithmetic == "fixed" else None
    return depths_of(options.depth_format, guard, view, deepest)


def screen_of(view: View, points: Floats, depths: Depths, options: Options) -> Array:
    """Carry points (V, 3) from clip space to the screen, in the numbers that are chosen.

    Returns
    -------
    (V, 3) float64 or float32
        x right, y down (up for the fill rule bottom-left), in pixels, and what of depth is interpolated.
    """
    points = points * MIRRORED if options.upside_down else points
    size = (view.width, view.height)
    screen = to_screen(points, view.perspective, size, (view.near, view.far))
    screen[:, 2] = depths.interpolated(screen[:, 2], points[:, 2])
    if options.subpixel_bits is not None:
        grid = 2.0**options.subpixel_bits
        screen[:, :2] = np.rint(screen[:, :2] * grid) / grid
    return screen.astype(ARITHMETIC[options.arithmetic], copy=False)


def cull_on_screen(cull: Array, options: Options) -> Array:
    """Return what not to draw (P,) of the polygons as they are scan converted."""
    return OTHER_SIDE[cull] if options.upside_down else cull


def upright(picture: Array, options: Options) -> Array:
    """Turn a picture (H, W) over if it has been scan converted upside down."""
    return picture[::-1].copy() if options.upside_down else picture


def _cut_polygons(corner: Ints, start: Ints, vertices: int) -> int:
    """Count the polygons with vertices of their own, which clipping made."""
    whole = np.diff(start) > 0
    return int(np.count_nonzero(corner[start[:-1][whole]] >= vertices))


def _counts(counts: Array, covered: int) -> dict[str, int]:
    fragments, passed = int(counts[FRAGMENTS]), int(counts[PASSED])
    return {
        "scan_lines": int(counts[SCAN_LINES]),
        "spans": int(counts[SPANS]),
        "fragments": fragments,
        "depth_passed": passed,
        "depth_failed": fragments - passed,
        "overdraw": passed - covered,
    }
