"""A planet seen from ever lower above its ground."""

from __future__ import annotations

import math

import numpy as np

from hsr.lab.stability.building import powers_of_two, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.lab.stability.theory import U32, U64
from hsr.mistakes.renderers import naive_spheres
from hsr.scene.model import Scene

RADIUS = 6.4e6


def scene(height: float, _: int) -> Scene:
    """Look at the horizon of a planet from the origin, turned by the angle of the triangle of 3, 4 and 5."""
    dip = math.sqrt(2.0 * height / RADIUS)
    zoom, near = 0.5 / dip, 0.125 * height
    matrix = [
        [0.8 * zoom, -0.6 * zoom, 0.0, 0.0],
        [0.6 * zoom, 0.8 * zoom, -0.5, 0.0],  # the horizon runs through the middle
        [0.0, 0.0, -1.0, -2.0 * near],
        [0.0, 0.0, -1.0, 0.0],
    ]
    place = [{"scale": RADIUS}, {"translate": [0.0, -(RADIUS + height), 0.0]}]
    return scene_of({"type": "matrix", "matrix": matrix}, {"shape": "sphere", "transform": place})


def lowest(rounding: float, side: int) -> float:
    """Return the height at which rounding the eye's place costs the first sample on the horizon.

    The eye's distance from the centre is rounded by ``u r``. A height h off by that moves the horizon, a
    quarter of the picture below eye level, by ``u r / (2 h)`` of that. Samples lie at fifths of a pixel from
    a line turned by 3, 4 and 5, so the nearest is off by a tenth at most.
    """
    return 10.0 * rounding * RADIUS * side / 8.0


FAMILY = Family(
    name="planet",
    group="rays",
    story=(
        "The eye looks at the horizon of a planet, from ever lower above the ground. All there is to tell "
        "height by is the difference of two numbers of the size of the planet: in float32 they are half a "
        "metre apart, and the horizon is anywhere; float64 knows nanometres."
    ),
    expected="The planet below the horizon, the sky above.",
    source=(
        "E. Haines, J. Guenther, T. Akenine-Moeller, Precision Improvements for Ray/Sphere Intersection "
        "(Ray Tracing Gems, 2019)"
    ),
    parameter="height above the ground, in metres",
    sweep=tuple(0.7 * height for height in powers_of_two(16, -28, 2)),  # powers themselves are not rounded
    scene=scene,
    variants=(
        Variant("raycast-woop-float32", lambda side: lowest(U32, side), "2^-24 r W 10 / 8"),
        Variant(
            "naive float32",
            lambda side: lowest(U32, side),
            "2^-24 r W 10 / 8",
            4.0,  # at most heights the eye's place is off by less than the whole of u r
            mistake=naive_spheres(np.float32),
        ),
        Variant(
            "naive float64",
            lambda side: lowest(U64, side),
            "2^-53 r W 10 / 8",
            mistake=naive_spheres(np.float64),
        ),
    ),
)
