"""The painter's algorithm: what is farther is painted first, and what is nearer over it.

Polygons are sorted by their farthest corner and painted back to front, without a depth buffer. That is the
first step of Newell, Newell and Sancha's depth sort ("A solution to the hidden surface problem",
Proceedings of the ACM Annual Conference, 1972) without its tests and without its splitting: an exhibit of
what depth buffers made unnecessary. No order is right where polygons penetrate or overlap in a cycle, and the
farthest corners need not tell the right one where there is one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr.algorithms import scanline
from hsr.algorithms.backface import PAINT
from hsr.base.arrays import Floats, Ints, ranges
from hsr.kernels.depth_buffer import ALWAYS
from hsr.kernels.projection import clip_rows, to_clip
from hsr.problem.map import Clock, VisibilityMap
from hsr.problem.view import View
from hsr.scene.shapes import Polygons


@dataclass(frozen=True)
class Options:
    """There is nothing to choose."""


def render(view: View, options: Options) -> VisibilityMap:  # noqa: ARG001
    """Sort polygons by depth and paint them over each other.

    Parameters
    ----------
    view : View
        Curved shapes are tessellated; polygons are clipped and culled as the depth buffer does it.
    options : Options

    Returns
    -------
    VisibilityMap
        Of polygons with equally far corners the lower face id is painted first. Each sample shows what was
        painted there last, with its depth. ``work``: ``polygons``.
    """
    clock = Clock()
    with clock("prepare"):
        polygons = view.tessellated().polygons
        clip = to_clip(polygons.vertices, clip_rows(view.clip_from_world, view.depth_row))
    with clock("sort"):
        order = back_to_front(clip, polygons)
    with clock("render"):
        drawn, cull = _in_order(polygons, order), polygons.cull[order]
        face, depth, _, _ = scanline.scan_polygons(view, drawn, clip, cull, PAINT, ALWAYS)
    return VisibilityMap(face, depth, "painter", {"polygons": len(polygons)}, clock.seconds)


def back_to_front(clip: Floats, polygons: Polygons) -> Ints:
    """Return the polygons (P,), that with the farthest corner first.

    Parameters
    ----------
    clip : (V, 3) float64
        The vertices in clip space; the third coordinate is the depth.
    polygons : Polygons
    """
    farthest = np.maximum.reduceat(clip[polygons.corner, 2], polygons.start[:-1])
    return np.argsort(-farthest, kind="stable").astype(np.int32)


def _in_order(polygons: Polygons, order: Ints) -> Polygons:
    """Return the same polygons in another order."""
    which, place = ranges(polygons.start[:-1][order], polygons.start[1:][order])
    start = np.searchsorted(which, np.arange(len(order) + 1)).astype(np.int32)
    return Polygons(polygons.vertices, polygons.corner[place], start, polygons.face[order])
