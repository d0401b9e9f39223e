"""A scene and its eye ever farther from the origin."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import central, mesh, moved, powers_of_two, scene_of
from hsr.lab.stability.cases.lattice_edges import net
from hsr.lab.stability.family import Family, Variant
from hsr.lab.stability.theory import U32
from hsr.mistakes.renderers import Buffer
from hsr.scene.model import Scene

PAST = 2.0**-4
"""Distance of corners from samples, in pixels."""


def scene(away: float, side: int) -> Scene:
    """Move a net and the eye before it by the same vector; in object space nothing changes."""
    corners, triangles = net(side, (PAST, 2.0 * PAST))
    vertices = np.insert(corners * (2.0 / side), 2, -1.0, axis=1)
    place = {"translate": [away, 0.75 * away, 0.0]}
    return scene_of(moved(central(0.5), away, 0.75 * away, 0.0), mesh(vertices, triangles, transform=[place]))


def first_wrong(side: int) -> float:
    """Return the distance at which corners are moved by their distance from samples, at a depth of 1."""
    return PAST * 2.0 / (side * U32)


FAMILY = Family(
    name="far-from-origin",
    group="rays",
    story=(
        "Scene and eye move away from the origin together, and what is seen does not change. Whoever puts "
        "corners into the world in float32 rounds them at the spacing of numbers out there, and the picture "
        "trembles. Whoever carries the ray into the object's frame by an exact enough transform does not "
        "notice."
    ),
    expected="The same net as at the origin.",
    source=(
        "Derived: T 2^-24, half the spacing at T, times W / 2 pixels a unit at depth 1; cf. Embree's tests "
        "of watertightness far from the origin"
    ),
    parameter="distance from the origin, in scene units",
    sweep=powers_of_two(2, 26, 2),
    scene=scene,
    variants=(
        Variant("opengl", first_wrong, "2^25 past / W: corners and matrix in float32"),
        Variant("embree", first_wrong, "2^25 past / W: corners and rays in float32"),
        Variant("float32 world", first_wrong, "2^25 past / W", mistake=Buffer(real=np.float32)),
        Variant("raycast-woop-float32", None, "float32 in the frame of the object, which does not move"),
    ),
)
