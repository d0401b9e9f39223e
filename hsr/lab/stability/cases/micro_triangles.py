"""Eight triangles about a sample, all within a small part of its pixel."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import mesh, parallel, powers_of_two, scene_of, wall
from hsr.lab.stability.family import Family
from hsr.lab.stability.rounding import on_screen, snapped
from hsr.scene.model import Scene

AROUND = np.array([[3, 1], [1, 3], [-1, 3], [-3, 1], [-3, -1], [-1, -3], [1, -3], [3, -1]]) / 3.0
"""The rim about a sample, for a radius of 1."""


def scene(radius: float, side: int) -> Scene:
    """Put eight triangles about every eighth sample, in front of a wall."""
    line = np.arange(4, side, 8) + 0.5 - 0.5 * side
    centre = np.stack(np.meshgrid(line, line), axis=2).reshape(-1, 1, 2)
    corners = np.concatenate([centre, centre + radius * AROUND], axis=1).reshape(-1, 2)
    k = np.arange(8)
    fan = np.stack([0 * k, k + 1, (k + 1) % 8 + 1], axis=1)
    triangles = (9 * np.arange(len(centre))[:, None, None] + fan).reshape(-1, 3)
    return scene_of(parallel(side), mesh(np.insert(corners, 2, -1.0, axis=1), triangles), wall(1.5, side))


FAMILY = Family(
    name="micro-triangles",
    group="coverage",
    story=(
        "Eight triangles meet at a sample, and all of them together are smaller than a pixel. One of them "
        "owns the sample, however small they are. Corners that are rounded to a grid of 2^-b pixels fall "
        "together when the radius is less than half of it, and the triangles vanish."
    ),
    expected="One of the eight triangles at each such sample, the wall behind everywhere else.",
    source=(
        "The OpenGL Graphics System, 3.6.1: rasterization of polygons, at least 4 bits of sub-pixel precision"
    ),
    parameter="radius of the eight triangles, in pixels",
    sweep=powers_of_two(-1, -33, 2),
    scene=scene,
    variants=(*snapped(), *on_screen()),
)
