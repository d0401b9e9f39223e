"""Triangles that are flattened until nothing is left."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import mesh, parallel, powers_of_two, scene_of, wall
from hsr.lab.stability.family import Family, Variant
from hsr.mistakes.renderers import Buffer
from hsr.scene.model import Scene


def scene(height: float, side: int) -> Scene:
    """Lay triangles so high upon lines of samples, and some that are a line or a point, before a wall."""
    y = np.arange(2, side, 4) + 0.5 - 0.5 * side
    x = np.full_like(y, 0.25 * side)
    corners = np.stack([[-x, y], [x, y], [0.0 * x, y + height]]).transpose(2, 0, 1).reshape(-1, 2)
    k = 3 * np.arange(len(y))[:, None]
    triangles = (k + np.array([0, 1, 2, 0, 1, 1, 2, 2, 2])).reshape(-1, 3)
    return scene_of(parallel(side), mesh(np.insert(corners, 2, -1.0, axis=1), triangles), wall(1.5, side))


FAMILY = Family(
    name="degenerate-input",
    group="coverage",
    story=(
        "Triangles lie upon lines of samples and lose their height; others have two equal corners, or "
        "three, from the start. Without area there is nothing to see: all edge functions are 0, and whoever "
        "counts 0 as inside on every edge draws what is not there."
    ),
    expected="The wall, and on the lower edges of triangles with a height either of the two.",
    source=(
        "J. Foley, A. van Dam, S. Feiner, J. Hughes, Computer Graphics: Principles and Practice, 3.6: slivers"
    ),
    parameter="height of the triangles, in pixels",
    sweep=(*powers_of_two(-1, -19, 2), 0.0),
    scene=scene,
    variants=(
        Variant(
            "inclusive", 0.5, "always: a triangle without area has no outside", mistake=Buffer(inclusive=True)
        ),
        Variant("scanline-direct", None, "no area, no span"),
    ),
)
