"""Needles: triangles longer than the picture, and ever thinner."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import mesh, parallel, powers_of_two, scene_of, wall
from hsr.lab.stability.family import Family
from hsr.lab.stability.rounding import in_space, on_screen, snapped
from hsr.scene.model import Scene


def scene(height: float, side: int) -> Scene:
    """Lay a needle along every fourth line of samples, in front of a wall."""
    y = np.arange(0, side, 4) + 0.5 - 0.5 * side
    x = np.full_like(y, side)
    corners = np.stack([[-x, y], [x, y - 0.5 * height], [x, y + 0.5 * height]])
    vertices = np.insert(corners.transpose(2, 0, 1).reshape(-1, 2), 2, -1.0, axis=1)
    triangles = np.arange(len(vertices)).reshape(-1, 3)
    return scene_of(parallel(side), mesh(vertices, triangles), wall(1.5, side))


FAMILY = Family(
    name="needle",
    group="coverage",
    story=(
        "A triangle twice as long as the picture is wide holds samples between its long edges, however thin "
        "it is. Snapped to a grid of 2^-b pixels it has no area left once its height is less than that; in "
        "float32 its area drowns in the rounding of products as long as the picture is wide."
    ),
    expected="The needle at the samples between its edges, the wall behind elsewhere.",
    source=(
        "J. R. Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates "
        "(1997): the error of an orientation test grows with the length of the edges"
    ),
    parameter="height of the needle, in pixels",
    sweep=powers_of_two(1, -33, 2),
    scene=scene,
    variants=(*snapped(2.0), *on_screen(), *in_space()),
)
