"""What to watch of each algorithm: its functions, its variables, its buffers, its turns."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hsr.algorithms import scanline as scan_conversion
from hsr.algorithms import zbuffer as certified
from hsr.kernels import boxes, culling, hits, rays, scanline
from hsr.kernels.zbuffer import key_buffer, tiles
from hsr.lessons.recording import Beat, Buffers, Names, Probe
from hsr.problem.map import BACKGROUND
from hsr.problem.view import View


def nobody(_: Names) -> int:
    """Say that no face asks for the sample yet."""
    return BACKGROUND


def place(row: str, column: str) -> Callable[[Names], tuple[int, int]]:
    """Return what reads a sample from two variables."""
    return lambda names: (int(names[row]), int(names[column]))


PASSED = "z[line, column] = stored"
"""The statement of a fragment that passes the depth test."""


def scanline_probe(view: View, options: scan_conversion.Options) -> Probe:
    """Watch scan conversion into a depth buffer."""

    def buffers(names: Names) -> Callable[[], Buffers] | None:
        if "i" not in names:  # not cleared yet
            return None
        z, owner = names["z"], names["owner"]
        way = -1 if options.upside_down else 1
        return lambda: (owner[::way], z[::way])

    def sample(names: Names) -> tuple[int, int]:
        row = int(names["line"])
        return view.height - 1 - row if options.upside_down else row, int(names["column"])

    return Probe(
        shown={
            scanline._scan_strip: (
                "face",
                "row",
                "x_left",
                "x_right",
                "first",
                "last",
                "left_m",
                "z_x",
                "z_y",
                "z_m",
                "z_left",
                "depth",
                "z_step",
            ),
            scanline._drawn: ("face", "depth", "stored", "z[line, column]"),
            scanline._stored: ("depth",),
            scanline._edge_below: ("row", "k", "line", "edge_end", "one_over_m"),
        },
        buffers={scanline._scan_strip: buffers},
        beats=(Beat(scanline._drawn, "stored =", sample, lambda names: int(names["face"])),),
        counters={
            "scan lines": (scanline._scan_strip, "line = "),
            "fragments tested": (scanline._drawn, "stored ="),
            "written": (scanline._drawn, PASSED),
        },
    )


def backface_probe(view: View, _options: Any) -> Probe:
    """Watch back-face detection, and the painting of what is left."""

    def begin(names: Names) -> None:
        if "i" not in names:  # the memory is as it was found
            names["facing"].fill(np.nan)

    paint = scanline_probe(view, scan_conversion.Options())
    return paint._replace(
        shown={
            culling._facing_by_normal: ("i", "a", "b", "c", "p", "facing[i]"),
            culling.newell: ("a", "b", "c"),
            **paint.shown,
        },
        buffers={culling._facing_by_normal: begin, **paint.buffers},
        until=scanline._scan_strip,
    )


def raycast_probe(_view: View, _options: Any) -> Probe:
    """Watch single rays on their way through the object list."""

    def buffers(names: Names) -> Callable[[], Buffers]:
        face, depth = names["face"], names["depth"]
        if "x" not in names:  # the memory is as it was found; no sample has been answered yet
            face.fill(BACKGROUND)
            depth.fill(np.inf)
        return lambda: (face, depth)

    def met(names: Names) -> int:
        nearness, face = names["hit"]
        return int(face) if nearness > -np.inf else BACKGROUND

    return Probe(
        shown={
            rays.cast: ("row", "column", "x", "y", "best"),
            rays.nearest_in_list: ("k", "hit", "best"),
            rays.meets_extent: (),
            boxes.box_entry: ("axis", "inverse", "start", "t_first", "t_last", "t_in", "t_out"),
            rays.generic_hit: ("o", "d", "span", "t", "face"),
            hits.polyhedron_span: ("k", "along", "inside", "t", "t_in", "face_in", "t_out", "face_out"),
            hits.sphere_span: ("a", "b", "s", "v", "r"),
            hits.square_hit: ("t", "inside"),
            hits.first_hit: ("span",),
            rays.better: ("nearness", "face", "best"),
            rays.counted: ("hit",),
        },
        buffers={rays.cast: buffers},
        beats=(Beat(rays.cast, "tally(done, RAYS)", place("row", "column"), nobody),),
        counters={
            "rays": (rays.cast, "tally(done, RAYS)"),
            "extents tested": (rays.meets_extent, "tally("),
            "faces or shapes tested": (rays.counted, "tally("),
            "hits": (rays.counted, "tally(work, HITS)"),
        },
        rival=(rays.better, met),
    )


def tiles_probe(view: View, _options: Any) -> Probe:
    """Watch half-space tests into a buffer of keys, and the exact answers afterwards."""
    size, faces = (view.height, view.width), certified.mesh_of(view.tessellated()).faces

    def keys_read(names: Names) -> Callable[[], Buffers] | None:
        if "window" not in names:
            return None
        keys, window, eye = names["keys"], names["window"], names["eye"]
        face, depth = np.full(size, BACKGROUND, np.int32), np.full(size, np.inf)
        box, known = (0, len(keys), 0, view.width), keys.copy()

        def read() -> Buffers:
            if not np.array_equal(keys, known):
                key_buffer.read_out(keys, window, box, faces, eye, face, depth)
                known[:] = keys
            return face, depth

        return read

    def answered(names: Names) -> Callable[[], Buffers] | None:
        return (lambda: (names["face"], names["depth"])) if "found" in names else None

    def sample(names: Names) -> tuple[int, int] | None:
        row, column = int(names["line"]), int(names["start"] + names["lane"])
        return (row, column) if column < view.width else None

    def tested(names: Names) -> int:
        return int(faces[int(names["number"])]) if names["inner"] >= names["bound"] else BACKGROUND

    return Probe(
        shown={
            tiles.draw_table: ("i",),
            key_buffer.fill: (
                "line",
                "start",
                "lane",
                "inner",
                "bound",
                "z",
                "key",
                "old",
                "inside",
                "beside",
                "doubtful",
            ),
            key_buffer.note: ("line", "column", "inner", "bound"),
            certified.render: (),
        },
        buffers={tiles.draw_tile: keys_read, certified.render: answered},
        beats=(
            Beat(key_buffer.fill, "inside, nearer_by =", sample, tested),
            Beat(key_buffer.note, "inner, z =", place("line", "column"), nobody),
        ),
        counters={
            "samples tested": (key_buffer.fill, "place ="),
            "in doubt on an edge": (key_buffer.note, "write("),
        },
    )


PROBES: dict[str, Callable[[View, Any], Probe]] = {
    "hsr.algorithms.backface": backface_probe,
    "hsr.algorithms.scanline": scanline_probe,
    "hsr.algorithms.raycast": raycast_probe,
    "hsr.algorithms.zbuffer": tiles_probe,
}
"""By the module of a method; others cannot be recorded."""
