"""Spheres that touch a wall from behind, flattened ever more."""

from __future__ import annotations

import math

from hsr.lab.stability.building import parallel, powers_of_two, scene_of, wall
from hsr.lab.stability.family import Family, Variant
from hsr.scene.model import Scene

SEGMENTS = 24


def radius(side: int) -> float:
    """Return the radius of the sphere in the picture, in pixels."""
    return 0.4 * side


def scene(thickness: float, side: int) -> Scene:
    """Let a flattened sphere touch a wall from behind, in the middle of the picture."""
    r = radius(side)
    place = [{"scale": [r, r, thickness]}, {"translate": [0.0, 0.0, -0.4 - thickness]}]
    return scene_of(
        parallel(side, 0.0, 1.0), {"shape": "sphere", "transform": place}, wall(0.4, side), segments=SEGMENTS
    )


def first_wrong(step: float, side: int) -> float:
    """Return the thickness at which the samples next to the contact are within a step.

    At x pixels from it the sphere is ``t x^2 / (2 r^2)`` behind the wall, and those samples have x^2 = 1/2.
    """
    return 4.0 * step * radius(side) ** 2


def first_wrong_of_polygons(step: float, side: int) -> float:
    """Return the same for a tessellated sphere, which touches with a corner.

    Its sides fall off by ``t x tan(a / 2) / r``, a being the angle from the pole to the first ring.
    """
    return math.sqrt(2.0) * step * radius(side) / math.tan(math.pi / SEGMENTS)


POLYGONS = "sqrt(2) q r / tan(pi / 24): polygons touch with a corner"

FAMILY = Family(
    name="touching-solids",
    group="order",
    story=(
        "A sphere touches a wall from behind. In exact arithmetic it touches in one point, which no sample "
        "sees; in a depth buffer it shines through within a disc about that point, whose radius is the root "
        "of 2 r dz. The flatter the sphere the wider the disc."
    ),
    expected="The wall everywhere.",
    source="Derived: sqrt(2 r dz), the sagitta of a sphere of radius r",
    parameter="thickness of the sphere, in depth ranges",
    sweep=powers_of_two(-2, -34, 2),
    scene=scene,
    variants=(
        Variant("scanline-d16", lambda side: first_wrong_of_polygons(2.0**-16, side), POLYGONS),
        Variant("scanline-d24", lambda side: first_wrong_of_polygons(2.0**-24, side), POLYGONS),
        # Less than a step apart depths are equal or not, by where they lie between floats.
        Variant("raycast-woop-float32", lambda side: first_wrong(2.0**-25, side), "4 r^2 2^-25", 4.0),
        Variant("opengl", lambda side: first_wrong_of_polygons(2.0**-24, side), POLYGONS),
    ),
)
