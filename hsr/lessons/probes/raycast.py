"""Single rays on their way through the object list."""

from __future__ import annotations

import numpy as np

from hsr.algorithms.raycast import Options
from hsr.kernels import boxes, hits, rays
from hsr.kernels import ray_hierarchy as extents
from hsr.lessons.probes import Beat, Look, Names, Probe, answered, nobody, place
from hsr.problem.map import BACKGROUND
from hsr.problem.view import View

EXTENTS = (extents.cast_through_extents, extents.nearest_in_extents)


def probe(_view: View, options: Options) -> Probe:
    """Watch each ray, the extents and shapes it is tested against, and the nearest hit."""

    def clear(names: Names) -> None:
        names["face"].fill(BACKGROUND)
        names["depth"].fill(np.inf)

    def met(names: Names) -> int:
        nearness, face = names["hit"]
        return int(face) if nearness > -np.inf else BACKGROUND

    plain = options.acceleration == "none"
    cast, nearest = (rays.cast, rays.nearest_hit) if plain else EXTENTS
    return Probe(
        shown={
            cast: ("row", "column", "x", "y", "best"),
            nearest: ("k", "best"),
            extents.meets_extent: (),
            boxes.box_entry: ("axis", "inverse", "start", "t_first", "t_last", "t_in", "t_out"),
            rays.generic_hit: ("o", "d", "span", "t", "face"),
            hits.polyhedron_span: ("k", "along", "inside", "t", "t_in", "face_in", "t_out", "face_out"),
            hits.sphere_span: ("a", "b", "s", "v", "r"),
            hits.square_hit: ("t", "inside"),
            hits.first_hit: ("span",),
            rays.better: ("nearness", "face", "best"),
        },
        buffers={cast: Look("x", answered, clear)},
        beats=(Beat(cast, "x = ", place("row", "column"), nobody),),
        counters={
            "rays": (cast, "x = "),
            "extents tested": (extents.meets_extent, "tally("),
            "faces or shapes tested": (rays.better, "nearness, face = hit"),
            "hits": (rays.better, "if nearness > best.nearness"),
        },
        rival=(rays.better, met),
    )
