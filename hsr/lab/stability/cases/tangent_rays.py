"""Rays that almost touch spheres."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import parallel, powers_of_two, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.lab.stability.theory import U32, U64
from hsr.mistakes.renderers import naive_spheres
from hsr.scene.model import Scene

RADII = 64.0
"""Distance of the spheres, in radii."""


def radius(side: int) -> float:
    """Return the radius of the spheres, in pixels, such that they touch samples on the right alone."""
    return side / 16.0 + 0.3


def scene(depth: float, side: int) -> Scene:
    """Let rays enter the right borders of 4 x 4 spheres by so many pixels, and miss others by as many."""
    r, spheres = radius(side), []
    for row in range(4):
        for column in range(4):
            inside = depth if (row + column) % 2 else -depth
            x, y = ((k + 0.5) * side / 4 + 0.5 - 0.5 * side for k in (column, row))
            place = [{"scale": r}, {"translate": [x + inside - r, y, -RADII * r]}]
            spheres.append({"shape": "sphere", "transform": place})
    return scene_of(parallel(side, 0.0, 2.0 * RADII * r), *spheres, segments=8)


FAMILY = Family(
    name="tangent-rays",
    group="rays",
    story=(
        "Rays run past spheres at almost their radius: half of them enter by a little, half miss by as "
        "much. The sign of the discriminant is all that tells, and it is as small as that little. Computed "
        "as b^2 - a c it carries the rounding of the squared distance; from the nearest point of the ray, "
        "that of the radius."
    ),
    expected="A sphere at every other of the tangent samples.",
    source=(
        "F. S. Hill, S. M. Kelley, Computer Graphics Using OpenGL, intersecting rays with a sphere; Haines, "
        "Guenther, Akenine-Moeller (2019)"
    ),
    parameter="how far rays enter or miss, in pixels",
    sweep=powers_of_two(-1, -47, 2),
    scene=scene,
    variants=(
        Variant(
            "naive float32",
            lambda side: U32 * RADII**2 * radius(side),
            "2^-24 k^2 r, at k radii",
            mistake=naive_spheres(np.float32),
        ),
        Variant(
            "naive float64",
            lambda side: U64 * RADII**2 * radius(side),
            "2^-53 k^2 r, at k radii",
            mistake=naive_spheres(np.float64),
        ),
        Variant("raycast-woop-float32", lambda side: U32 * radius(side), "2^-24 r"),
    ),
)
