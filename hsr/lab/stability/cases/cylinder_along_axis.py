"""Rays almost along the axis of a cylinder."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import central, powers_of_two, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.lab.stability.theory import U64
from hsr.mistakes.renderers import general_cylinders
from hsr.scene.model import Scene


def scene(tilt: float, _: int) -> Scene:
    """Look along a tube from within, close to its wall, by a view no wider than the tilt."""
    place = [{"scale": [1.0, 1.0, -1.0]}, {"translate": [0.5 * tilt - 1.0, 0.0, 0.25]}]
    return scene_of(central(0.125, None, 1.0 / tilt), {"shape": "cylinder", "transform": place})


FAMILY = Family(
    name="cylinder-along-axis",
    group="rays",
    story=(
        "The eye is in a tube, close to the wall, and looks along it through an ever narrower view. For an "
        "axis of any direction textbooks have a = d.d - (d.axis)^2 in the quadratic equation of the wall: "
        "of two numbers near 1 a difference of the size of the squared tilt is left. In the cylinder's own "
        "frame it is dx^2 + dy^2, and nothing cancels."
    ),
    expected="The wall where the ray leaves through it, the cap at the end elsewhere.",
    source="F. S. Hill, S. M. Kelley, Computer Graphics Using OpenGL, intersecting rays with a cylinder",
    parameter="greatest tilt of a ray against the axis",
    sweep=powers_of_two(-2, -36, 2),
    scene=scene,
    variants=(
        Variant(
            "general axis, float32",
            2.0**-12,
            "2^-12: tilt^2 = 2^-24",
            mistake=general_cylinders(np.float32),
        ),
        Variant(
            "general axis, float64",
            2.0**-26.5,
            "2^-26.5: tilt^2 = 2^-53",
            mistake=general_cylinders(np.float64),
        ),
        Variant(
            "raycast-single",
            lambda side: 0.5 * side * side * U64,
            "2^-53 W^2 / 2: the distance to the wall",
        ),
    ),
)
