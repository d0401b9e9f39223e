"""A sphere ever farther away, seen by an ever narrower view."""

from __future__ import annotations

import math

import numpy as np

from hsr.lab.stability.building import powers_of_two, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.lab.stability.theory import U32, U64
from hsr.mistakes.renderers import naive_spheres
from hsr.scene.model import Scene

SHARE = 0.8
"""Radius of the sphere in the picture, over half the picture."""


def scene(away: float, _: int) -> Scene:
    """Look at a unit sphere from so far away, aslant, and fill the picture with it."""
    camera = {"type": "perspective", "eye": [0.48 * away, 0.64 * away, 0.6 * away], "near": 0.5 * away}
    fov = math.degrees(2.0 * math.atan(1.0 / (SHARE * away)))
    return scene_of(camera | {"fov": fov}, {"shape": "sphere"})


def outline(side: int) -> float:
    """Return how many samples a band about the outline holds, of a width of one radius: ``2 pi R^2``."""
    return 2.0 * math.pi * (0.5 * SHARE * side) ** 2


FAMILY = Family(
    name="distant-sphere",
    group="rays",
    story=(
        "A unit sphere stands D away and fills the view. The discriminant b^2 - a c is the difference of "
        "two numbers like D^2, so its rounding decides in a band about the outline that grows with D^2, and "
        "beyond D^2 = 2^24, in float32, the sphere is gone. Measuring from the point of the ray nearest to "
        "the centre leaves a band that grows with D alone."
    ),
    expected="The sphere inside its outline, the background outside.",
    source=(
        "E. Haines, J. Guenther, T. Akenine-Moeller, Precision Improvements for Ray/Sphere Intersection "
        "(Ray Tracing Gems, 2019)"
    ),
    parameter="distance, in radii",
    sweep=powers_of_two(2, 36, 2),
    scene=scene,
    variants=(
        Variant(
            "naive float32",
            lambda side: (outline(side) * U32) ** -0.5,
            "sqrt(2^24 / (2 pi R^2)): a band of u D^2 about the outline",
            mistake=naive_spheres(np.float32),
        ),
        Variant(
            "naive float64",
            lambda side: (outline(side) * U64) ** -0.5,
            "sqrt(2^53 / (2 pi R^2))",
            mistake=naive_spheres(np.float64),
        ),
        Variant(
            "raycast-woop-float32",
            lambda side: 4.0 / (outline(side) * U32),
            "2^26 / (2 pi R^2): a band of u D / 4, half a spacing on average",
        ),
    ),
)
