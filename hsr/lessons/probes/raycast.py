"""Single rays on their way through the object list."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hsr.kernels import boxes, hits, rays
from hsr.lessons.probes import Beat, Buffers, Look, Names, Probe, nobody, place
from hsr.problem.map import BACKGROUND
from hsr.problem.view import View


def probe(_view: View, _options: Any) -> Probe:
    """Watch each ray, the extents and shapes it is tested against, and the nearest hit."""

    def clear(names: Names) -> None:
        names["face"].fill(BACKGROUND)
        names["depth"].fill(np.inf)

    def answered(names: Names) -> Callable[[], Buffers]:
        face, depth = names["face"], names["depth"]
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
        buffers={rays.cast: Look("x", answered, clear)},
        beats=(Beat(rays.cast, "tally(done, RAYS)", place("row", "column"), nobody),),
        counters={
            "rays": (rays.cast, "tally(done, RAYS)"),
            "extents tested": (rays.meets_extent, "tally("),
            "faces or shapes tested": (rays.counted, "tally("),
            "hits": (rays.counted, "tally(work, HITS)"),
        },
        rival=(rays.better, met),
    )
