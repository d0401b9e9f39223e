"""Scan conversion into a depth buffer."""

from __future__ import annotations

from collections.abc import Callable

from hsr.algorithms.scanline import Options
from hsr.kernels import scanline
from hsr.lessons.probes import Beat, Buffers, Look, Names, Probe
from hsr.problem.view import View


def probe(view: View, options: Options) -> Probe:
    """Watch spans, the depths along them, and the depth test."""

    def cleared(names: Names) -> Callable[[], Buffers]:
        z, owner = names["z"], names["owner"]
        way = -1 if options.upside_down else 1
        return lambda: (owner[::way], z[::way])

    def sample(names: Names) -> tuple[int, int]:
        row = int(names["line"])
        return view.height - 1 - row if options.upside_down else row, int(names["column"])

    spans = "face row x_left x_right first last left_m z_x z_y z_m z_left depth z_step"
    return Probe(
        shown={
            scanline._scan_strip: tuple(spans.split()),
            scanline._drawn: ("face", "depth", "stored", "z[line, column]"),
            scanline._stored: ("depth",),
            scanline._edge_below: ("row", "k", "line", "edge_end", "one_over_m"),
        },
        buffers={scanline._scan_strip: Look("i", cleared)},
        beats=(Beat(scanline._drawn, "stored =", sample, lambda names: int(names["face"])),),
        counters={
            "scan lines": (scanline._scan_strip, "line = "),
            "fragments tested": (scanline._drawn, "stored ="),
            "written": (scanline._drawn, "z[line, column] = stored"),
        },
    )
