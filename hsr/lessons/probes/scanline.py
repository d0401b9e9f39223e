"""Scan conversion into a depth buffer."""

from __future__ import annotations

from collections.abc import Callable

from hsr.algorithms.scanline import Options
from hsr.kernels.depth_buffer import stored_of
from hsr.kernels.scanline import draw, edge_below, scan_polygon
from hsr.kernels.strips import _scan_convert
from hsr.lessons.probes import Beat, Buffers, Look, Names, Probe
from hsr.problem.view import View


def probe(view: View, options: Options) -> Probe:
    """Watch spans, the depths along them, and the depth test."""

    def cleared(names: Names) -> Callable[[], Buffers]:
        z, owner = names["buffers"]
        way = -1 if options.upside_down else 1
        return lambda: (owner[::way], z[::way])

    def sample(names: Names) -> tuple[int, int]:
        row = int(names["row"])
        return view.height - 1 - row if options.upside_down else row, int(names["column"])

    spans = "face row A B C left_one_over_m x_left x_right first last z_left z_down z z_across"
    return Probe(
        shown={
            scan_polygon: tuple(spans.split()),
            draw: ("face", "z", "stored", "z_buffer[row, column]"),
            stored_of: ("z",),
            edge_below: ("row", "k", "line", "edge_end", "one_over_m"),
        },
        buffers={_scan_convert: Look("i", cleared)},
        beats=(Beat(draw, "stored =", sample, lambda names: int(names["face"])),),
        counters={
            "scan lines": (scan_polygon, "first = "),
            "fragments tested": (draw, "stored ="),
            "written": (draw, "z_buffer[row, column] = stored"),
        },
    )
