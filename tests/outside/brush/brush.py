"""A method of another package: rays against every triangle, in plain Python; its row tells hsr the rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr import Method
from hsr.lessons.probes import Beat, Look, Names, Probe, nobody, place
from hsr.models.rounded import TESSELLATED
from hsr.models.stages import Cause, Pipeline, ending, rerun
from hsr.problem.map import BACKGROUND, Clock, VisibilityMap
from hsr.problem.view import View

METHOD = Method(
    "brush",
    "every ray against every triangle, by determinants",
    "brush",
    exhaustive=True,
    pipeline="brush",
    probe="brush",
)


@dataclass(frozen=True)
class Options:
    """How much a sample must be inside: more than 0 leaves gaps between triangles."""

    margin: float = 0.0


def render(view: View, options: Options) -> VisibilityMap:
    """Cast the ray of every sample; of equal depths the lowest face is shown."""
    clock = Clock()
    with clock("prepare"):
        polygons = view.tessellated().polygons
        corners = polygons.vertices[polygons.triangle_vertex]
        culled = polygons.cull[polygons.triangle_polygon]
    with clock("render"):
        face = np.full((view.height, view.width), BACKGROUND, np.int32)
        depth = np.full((view.height, view.width), np.inf)
        for row in range(view.height):
            for column in range(view.width):
                x, y = (2 * column + 1) / view.width - 1, 1 - (2 * row + 1) / view.height
                origin, direction = view.rays.origin @ [1, x, y], view.rays.direction @ [1, x, y]
                t = distances(corners, culled, origin, direction, options.margin)
                t[(t < view.near) | (t > view.far)] = np.inf
                if len(t) and t.min() < np.inf:
                    face[row, column] = polygons.triangle_face[t.argmin()]
                    depth[row, column] = t.min()
    work = {"tests": len(corners) * face.size}
    return VisibilityMap(face, depth, "brush", work, clock.seconds)


def distances(corners: Any, culled: Any, origin: Any, direction: Any, margin: float) -> Any:
    """Return how far along a ray each triangle (n, 3, 3) is met, inf where it is not."""
    a, b, c = np.moveaxis(corners - origin, 1, 0)
    sides = np.stack([np.cross(b, c) @ direction, np.cross(c, a) @ direction, np.cross(a, b) @ direction])
    total = sides.sum(axis=0)
    front, back = (sides <= -margin).all(axis=0), (sides >= margin).all(axis=0)
    shown = (total != 0) & (front & (culled != 2) | back & (culled != 1))
    with np.errstate(all="ignore"):
        return np.where(shown, np.einsum("nk,nk->n", np.cross(a, b), c) / total, np.inf)


PIPELINE: Pipeline = ending(rerun(render), Cause.INTERSECTOR, TESSELLATED)


def probe(_view: View, _options: Options) -> Probe:
    """Watch the samples as they are answered."""

    def buffers(names: Names) -> Any:
        return lambda: (names["face"], names["depth"])

    return Probe(
        shown={render: ("row", "column", "t")},
        buffers={render: Look("depth", buffers)},
        beats=(Beat(render, "x, y =", place("row", "column"), nobody),),
        counters={"rays": (render, "x, y =")},
    )
