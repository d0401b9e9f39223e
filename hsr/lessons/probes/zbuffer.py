"""Half-space tests into a buffer of keys, and the exact answers afterwards."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hsr.algorithms import zbuffer
from hsr.kernels.zbuffer import fill, tiles
from hsr.lessons.probes import Beat, Buffers, Look, Names, Probe, answered, nobody, place
from hsr.problem.map import BACKGROUND
from hsr.problem.view import View


def probe(view: View, _options: Any) -> Probe:
    """Watch the samples of each triangle, the doubts, and what decides them."""
    size, faces = (view.height, view.width), zbuffer.clusters_of(view.tessellated()).faces

    def keys_read(names: Names) -> Callable[[], Buffers]:
        tile, eye, known = names["tile"], names["eye"], names["tile"].keys.copy()
        face, depth = np.full(size, BACKGROUND, np.int32), np.full(size, np.inf)

        def read() -> Buffers:
            if not np.array_equal(tile.keys, known):
                fill.read_out(tile, (0, len(known), 0, view.width), (faces, face, depth), eye)
                known[:] = tile.keys
            return face, depth

        return read

    def sample(names: Names) -> tuple[int, int] | None:
        row, column = int(names["line"]), int(names["start"] + names["lane"])
        return (row, column) if column < view.width else None

    def tested(names: Names) -> int:
        return int(faces[int(names["number"])]) if names["inner"] >= names["bound"] else BACKGROUND

    tests = "line start lane inner bound z key old inside nearer_by doubtful"
    return Probe(
        shown={
            fill.draw_table: ("i",),
            fill.fill: tuple(tests.split()),
            fill.note: ("line", "column", "inner", "bound"),
            zbuffer.render: (),
        },
        buffers={tiles.draw_clusters: Look("table", keys_read), zbuffer.render: Look("found", answered)},
        beats=(
            Beat(fill.fill, "inside, nearer_by =", sample, tested),
            Beat(fill.note, "inner, z =", place("line", "column"), nobody),
        ),
        counters={"samples tested": (fill.fill, "place ="), "in doubt on an edge": (fill.note, "write(")},
    )
