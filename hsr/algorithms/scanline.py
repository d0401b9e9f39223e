"""The depth buffer: polygons scan converted one after the other, the nearest kept at each sample.

The stages are the textbook's: world points go to clip space, polygons are clipped, what is left is
divided by w and mapped to the screen, the polygon table is set up (culling what the scene says), and the
polygons are scan converted. :mod:`hsr.kernels.scanline` says who owns a sample on an edge and who wins
between equal depths; the limit rule that decides ties exactly is not applied.

A face of more than three corners is one polygon here, and taken to be planar and convex up to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr.arrays import Array, Floats, Ints
from hsr.errors import MethodError
from hsr.kernels import scanline
from hsr.kernels.clipping import clip_polygons, view_volume
from hsr.kernels.projection import clip_rows, to_clip, to_depth, to_screen
from hsr.viewing import View
from hsr.visibility import Clock, VisibilityMap, depth_format

STEPPING = {"incremental": scanline.INCREMENTAL, "direct": scanline.DIRECT}
ARITHMETIC: dict[str, type[np.floating[Any]]] = {"float64": np.float64, "float32": np.float32}


@dataclass(frozen=True)
class Options:
    """How polygons are scan converted.

    Attributes
    ----------
    stepping : {"incremental", "direct"}
        Whether sides and depths go on by increments, as textbooks have it, or are evaluated anew for
        every scan line and every sample.
    arithmetic : {"float64", "float32"}
        Of everything after the viewport: screen coordinates are computed in float64 and rounded to
        this type; planes, edges, spans and the depth buffer are in it throughout.
    count : bool
        Count the work, in kernels compiled for that.
    """

    stepping: str = "incremental"
    arithmetic: str = "float64"
    count: bool = False

    def __post_init__(self) -> None:
        for name, known in (("stepping", STEPPING), ("arithmetic", ARITHMETIC)):
            value = getattr(self, name)
            if value not in known:
                raise MethodError(f"scanline has no {name} {value!r}; choose from {', '.join(known)}")


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
        rest. ``work``: ``polygons`` and ``buffer_bytes``; if counted, also what became of the polygons
        (``clipped_away``, ``cut``, ``missed``: no sample in their bounding box, ``edge_on``, ``culled``,
        ``set_up``), their ``scan_lines``, ``spans`` and ``fragments``, ``depth_passed`` and
        ``depth_failed``, and ``overdraw``: what was written and overwritten later.
    """
    clock = Clock()
    with clock("prepare"):
        view = view.tessellated()
        polygons = view.polygons
    real = ARITHMETIC[options.arithmetic]
    with clock("render"):
        clip = to_clip(polygons.vertices, clip_rows(view.clip_from_world, view.depth_row))
        face, depth, work = scan_polygons(
            view, clip, polygons.cull, STEPPING[options.stepping], real, options.count
        )
    stored = depth_format("window", float(np.finfo(real).epsneg), view.near, view.far, view.perspective)
    return VisibilityMap(face, depth, "scanline", work, clock.seconds, {"depth_format": stored})


def scan_polygons(
    view: View, clip: Floats, cull: Array, mode: int, real: type[np.floating[Any]], count: bool
) -> tuple[Ints, Floats, dict[str, int]]:
    """Take the polygons of a view from clip space to the buffers.

    Parameters
    ----------
    view : View
        Without curved shapes.
    clip : (V, 3) float64
        The vertices of ``view.polygons`` in clip space.
    cull : (P,) int8
        What not to draw: 0 nothing, 1 back faces, 2 front faces, 3 both.
    mode, real, count
        See :func:`hsr.kernels.scanline.scan_convert`.

    Returns
    -------
    face : (H, W) int32
    depth : (H, W) float64
    work : dict of str to int
    """
    polygons, depths, size = view.polygons, (view.near, view.far), (view.width, view.height)
    planes = view_volume(*depths, view.perspective)
    points, corner, start = clip_polygons(clip, polygons.corner, polygons.start, planes)
    screen = to_screen(points, view.perspective, size, depths, real)
    slope, table = scanline.polygon_table(screen, corner, start, polygons.face, cull, size)
    z, face, counts = scanline.scan_convert(screen, corner, slope, table, size, mode, count)
    work = {"polygons": len(polygons), "buffer_bytes": z.nbytes + face.nbytes}
    if counts is not None:
        cut = _cut_polygons(corner, start, len(clip))
        work |= {"cut": cut} | _fates(table) | _counts(counts, int(np.count_nonzero(face >= 0)))
    return face, to_depth(z, view.perspective, depths), work


def _cut_polygons(corner: Ints, start: Ints, vertices: int) -> int:
    """Count the polygons with vertices of their own, which clipping made."""
    whole = np.diff(start) > 0
    return int(np.count_nonzero(corner[start[:-1][whole]] >= vertices))


def _fates(table: Ints) -> dict[str, int]:
    fate = np.bincount(table[:, scanline.FATE], minlength=5)
    return {
        "clipped_away": int(fate[scanline.CLIPPED]),
        "missed": int(fate[scanline.MISSED]),
        "edge_on": int(fate[scanline.EDGE_ON]),
        "culled": int(fate[scanline.CULLED]),
        "set_up": int(fate[scanline.DRAWN]),
    }


def _counts(counts: Array, covered: int) -> dict[str, int]:
    fragments, passed = int(counts[scanline.FRAGMENTS]), int(counts[scanline.PASSED])
    return {
        "scan_lines": int(counts[scanline.SCAN_LINES]),
        "spans": int(counts[scanline.SPANS]),
        "fragments": fragments,
        "depth_passed": passed,
        "depth_failed": fragments - passed,
        "overdraw": passed - covered,
    }
