"""Surfaces ever closer to the near plane, on either side of it."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import central, powers_of_two, rectangle, scene_of, wall
from hsr.lab.stability.family import Family, Variant
from hsr.mistakes.renderers import Buffer
from hsr.scene.model import Scene


def scene(off: float, _: int) -> Scene:
    """Put the left of two panels behind the near plane, the right one before it, both before a wall."""
    panels = []
    for left, depth in ((-0.75, 1.0 + off), (0.125, 1.0 - off)):
        x, y = (left * depth, (left + 0.625) * depth), (-0.75 * depth, 0.75 * depth)
        panels.append(rectangle(x, y, depth))
    return scene_of(central(1.0), *panels, wall(2.0, 4.0))


FAMILY = Family(
    name="eye-on-surface",
    group="rays",
    story=(
        "Two panels lie at the near plane, one a little behind it, one a little before it. What lies at the "
        "near distance exactly is seen, and what lies nearer is not. In float32 the panel in front is "
        "rounded onto the plane, and appears; who asks for more than the near distance loses both in the "
        "end."
    ),
    expected="The left panel; the right one only where it touches the near plane.",
    source=(
        "J. Foley, A. van Dam, S. Feiner, J. Hughes, Computer Graphics: Principles and Practice, 6.5: the "
        "view volume is closed"
    ),
    parameter="distance from the near plane, over the near distance",
    sweep=(*powers_of_two(-2, -50, 2), 0.0),
    scene=scene,
    variants=(
        Variant(
            "float32 corners", 2.0**-25, "2^-25: half the spacing below 1", mistake=Buffer(real=np.float32)
        ),
        Variant("opengl", 2.0**-25, "2^-25: half the spacing below 1"),
        Variant("embree", 2.0**-25, "2^-25: half the spacing below 1"),
        Variant(
            "after near", 0.0, "0: near < depth in place of near <= depth", mistake=Buffer(after_near=True)
        ),
    ),
)
