"""The depth buffer again, by another kernel: half-space tests on sixteen samples at once.

The same contract as :mod:`hsr.algorithms.zbuffer`, up to the viewport the same steps, and the same rules
of who owns a sample and who wins. :mod:`hsr.kernels.tiles` does the rest, several times faster than a walk
along scan lines.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr.arrays import Array, Floats, Ints
from hsr.kernels.clipping import clip_polygons, view_volume
from hsr.kernels.projection import clip_rows, to_clip, to_depth, to_screen
from hsr.kernels.tiles import rasterise
from hsr.scene.shapes import Polygons
from hsr.viewing import View
from hsr.visibility import Clock, VisibilityMap, depth_format


@dataclass(frozen=True)
class Options:
    """Nothing to choose."""


def render(view: View, options: Options) -> VisibilityMap:  # noqa: ARG001
    """Render a view with a depth buffer filled by half-space tests.

    Parameters
    ----------
    view : View
        Curved shapes are tessellated.
    options : Options

    Returns
    -------
    VisibilityMap
        ``seconds``: ``prepare`` puts the polygons into world space, once a view; ``render`` is all the
        rest. ``work``: ``polygons``, ``triangles`` after clipping, and ``buffer_bytes``.
    """
    clock = Clock()
    with clock("prepare"):
        view = view.tessellated()
        polygons = view.polygons
    depths, size = (view.near, view.far), (view.width, view.height)
    with clock("render"):
        clip = to_clip(polygons.vertices, clip_rows(view.clip_from_world, view.depth_row))
        planes = view_volume(*depths, view.perspective)
        points, corner, start = clip_polygons(clip, polygons.corner, polygons.start, planes)
        screen = to_screen(points, view.perspective, size, depths)
        triangle, polygon = fans(screen, corner, start)
        face, z, step = rasterise(screen, triangle, polygons.face[polygon], polygons.cull[polygon], size)
        depth = to_depth(z, view.perspective, depths)
    work = {"polygons": len(polygons), "triangles": len(triangle), "buffer_bytes": face.nbytes + z.nbytes}
    stored = depth_format("window", step, view.near, view.far, view.perspective)
    return VisibilityMap(face, depth, "zbuffer-tiles", work, clock.seconds, {"depth_format": stored})


def fans(screen: Floats, corner: Ints, start: Ints) -> tuple[Ints, Array]:
    """Fan out what clipping left of the polygons: corners (n, 3), and the polygon (n,) of each."""
    left = np.flatnonzero(np.diff(start))
    rest = Polygons(screen, corner, np.append(start[left], start[-1]), left.astype(np.int32))
    return rest.triangle_vertex, rest.triangle_face
