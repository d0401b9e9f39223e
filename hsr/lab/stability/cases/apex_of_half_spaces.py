"""Many half-spaces that meet in one point."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import central, powers_of_two, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.lab.stability.rounding import in_space
from hsr.scene.model import Scene

SIDES = 12


def scene(past: float, side: int) -> Scene:
    """Point pyramids at samples, or ever closer past them.

    Rays pass the apex by (1, 2) times the distance; the nearest edge of the pyramid is turned from there by
    5.6 degrees. So they pass that edge, on which two sides are equally far, at 0.22 of the distance.
    """
    angle = (np.arange(SIDES) + 0.3) * (2.0 * np.pi / SIDES)
    ring = np.stack([np.cos(angle), np.sin(angle), np.full(SIDES, -3.0)], axis=1) * [0.2, 0.2, 1.0]
    k = range(SIDES)
    faces = [[i, (i + 1) % SIDES, SIDES] for i in k] + [list(reversed(k))]
    pyramids = []
    for row, column in np.mgrid[side // 8 : side : side // 4, side // 8 : side : side // 4].reshape(2, -1).T:
        x, y = (2 * column + 1 + 2 * past) / side - 1, 1 - (2 * row + 1 - 4 * past) / side
        vertices = [*(ring + np.array([3.0 * x, 3.0 * y, 0.0])).tolist(), [2.0 * x, 2.0 * y, -2.0]]
        pyramids.append({"shape": "polyhedron", "vertices": vertices, "faces": faces})
    return scene_of(central(0.5), *pyramids)


FAMILY = Family(
    name="apex-of-half-spaces",
    group="rays",
    story=(
        "Twelve half-spaces meet in the apex of a pyramid, and a ray passes ever closer to it. It enters "
        "all of them at almost the same distance, and the greatest of those tells the face. Rounded, they "
        "are in any order as soon as they differ by less than the spacing of floats."
    ),
    expected="The side of the pyramid in whose direction the ray passes the apex.",
    source=(
        "M. Cyrus, J. Beck, Generalized Two- and Three-Dimensional Clipping (1978); Hill and Kelley, convex "
        "polyhedra"
    ),
    parameter="distance of rays from the apex, in pixels",
    sweep=powers_of_two(-2, -36, 2),
    scene=scene,
    variants=(*in_space(4.0), Variant("opengl", 2.0**-9, "2^-9 px: half the grid of its corners")),
)
