"""Four bars, each over the next."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import parallel, powers_of_two, quads, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.scene.model import Scene

SWEEP = powers_of_two(-7, -33, 2)


def scene(tilt: float, side: int) -> Scene:
    """Lay four bars about the middle; along each depth decreases so much a pixel."""
    near, far = 0.2 * side, 0.4 * side
    bar = np.array([[-far, -far], [far, -far], [far, -near], [-far, -near]])
    corners = []
    for _ in range(4):
        corners.append(np.column_stack([bar, tilt * np.array([-far, far, far, -far]) - 0.4]))
        bar = np.column_stack([-bar[:, 1], bar[:, 0]])  # a quarter turn is exact
    return scene_of(parallel(side, 0.0, 1.0), quads(corners))


FAMILY = Family(
    name="cyclic-overlap",
    group="order",
    story=(
        "Four bars lie each over the next, the last over the first. There is no order in which to paint "
        "them, unless one is cut; a depth buffer needs no order. The bars part by twice the tilt times "
        "their reach where they cross, and a depth format must tell that."
    ),
    expected="A pinwheel: turned by a quarter it is the same, with the bars renamed.",
    source="M. Newell, R. Newell, T. Sancha, A Solution to the Hidden Surface Problem (1972)",
    parameter="tilt of the bars, in depth ranges a pixel",
    sweep=SWEEP,
    scene=scene,
    variants=(
        Variant("painter", SWEEP[0], "always: there is no order"),
        Variant("scanline-d16", lambda side: 2.0**-16 / (0.6 * side), "2^-16 / (0.6 W)"),
        Variant("scanline-d24", lambda side: 2.0**-24 / (0.6 * side), "2^-24 / (0.6 W)"),
        Variant("opengl", lambda side: 2.0**-24 / (0.6 * side), "2^-24 / (0.6 W), as D24"),
    ),
)
