"""Steep triangles ever farther from where their planes are anchored."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import mesh, parallel, powers_of_two, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.mistakes.renderers import Buffer
from hsr.scene.model import Scene

HEIGHT = 16
SLOPE = 1.0 / 12.0
"""Of depth, in ranges a pixel."""
APART = 2.0**-20


def scene(away: float, _: int) -> Scene:
    """Put a triangle at the right end of a wide picture, and another behind it that comes first."""
    x = 0.5 * (away + HEIGHT) - 12.0
    across = np.array([[x, -6.1], [x + 8.0, -5.9], [x + 0.1, 6.5]])
    depth = 0.1 + SLOPE * (across[:, 0] - x)
    corners = [np.insert(across, 2, -depth - behind, axis=1) for behind in (APART, 0.0)]
    return scene_of(parallel(HEIGHT, 0.0, 1.0), mesh(np.concatenate(corners), [[0, 1, 2], [3, 4, 5]]))


FAMILY = Family(
    name="steep-far-triangle",
    group="depth",
    story=(
        "A small steep triangle stands far from the left end of the picture. Evaluating its plane from "
        "there in float32 carries depth back over the whole way, to numbers much larger than any depth, and "
        "rounds it at their spacing. Anchored at one of its own corners the plane is as good as anywhere."
    ),
    expected="The nearer of two parallel triangles.",
    source="Derived: 2^-24 |dz/dx| x, the rounding of what depth is at the left end",
    parameter="distance from the left end, in pixels",
    sweep=powers_of_two(4, 13),
    continuous=False,
    scene=scene,
    size=lambda away, _: (int(away) + HEIGHT, HEIGHT),
    variants=(
        Variant(
            "anchored",
            APART * 2.0**24 / SLOPE,
            "2^24 s / |dz/dx|, for a separation s",
            mistake=Buffer(anchored=True),
        ),
        Variant(
            "scanline-float32-direct", None, "anchored at the first sample of a span: 2^-24, less than s"
        ),
    ),
)
