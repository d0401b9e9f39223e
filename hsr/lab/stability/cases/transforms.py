"""Scenes far from the origin, or of any size: what is seen does not change, but what is rounded does."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import central, crumpled, mesh, moved, net, placed, scene_of, seen
from hsr.lab.stability.family import Variant, buffer, hard_case, octaves, variants
from hsr.lab.stability.theory import U32
from hsr.scene.model import Scene

PAST = 2.0**-4
"""Distance of corners from samples, in pixels."""


def least_trembling(side: int) -> float:
    """Return the distance at which corners are moved by their distance from samples, at a depth of 1."""
    return PAST * 2.0 / (side * U32)


@hard_case("rays", "distance from the origin, in scene units", octaves(2, 26, 2))
@variants(
    Variant("opengl", least_trembling, "2^25 past / W: corners and matrix in float32"),
    Variant("embree", least_trembling, "2^25 past / W: corners and rays in float32"),
    buffer("float32 world", least_trembling, "2^25 past / W", real=np.float32),
    Variant("raycast-woop-float32", None, "float32 in the frame of the object, which does not move"),
)
def far_from_origin(away: float, side: int) -> Scene:
    """Move a net and the eye before it by the same vector; in object space nothing changes.

    Scene and eye move away from the origin together, and what is seen does not change. Whoever puts corners
    into the world in float32 rounds them at the spacing of numbers out there, and the picture trembles.
    Whoever carries the ray into the object's frame by an exact enough transform does not notice.

    Truth: The same net as at the origin.

    Source: Derived: T 2^-24, half the spacing at T, times W / 2 pixels a unit at depth 1; cf. Embree's tests
    of watertightness far from the origin
    """
    corners, triangles = net(side, PAST, 2.0 * PAST)
    place = {"translate": [away, 0.75 * away, 0.0]}
    far_net = mesh(seen(corners, side), triangles, transform=[place])
    return scene_of(moved(central(0.5), away, 0.75 * away, 0.0), far_net)


NEAR = 2.0**-10
DEPTHS = (8.0, 2.0, 4.0)
LOST = "2 near 2^24: the constants of z and w become one number"


@hard_case("depth", "distance of eye and scene from the origin, in scene units", octaves(4, 30, 2))
@variants(
    Variant("opengl", 2.0**25 * NEAR, LOST),
    buffer("composed", 2.0**25 * NEAR, LOST, real=np.float32, composed=True),
    buffer(
        "separate", 2.0**25, "2^25: float32 no longer tells depths apart that differ by 2", real=np.float32
    ),
)
def composed_matrix(away: float, _: int) -> Scene:
    """Put three walls before an eye, all moved along the view axis; they cover parts of each other.

    Scene and camera move away from the origin together. A single float32 matrix has the camera's position T
    in its rows for z and w, and in the one for z twice the near distance on top: once that is less than the
    spacing of float32 at T it is gone, z equals w for every depth, and the order is lost. Depth first and
    window depth after it keeps the near distance out of such company.

    Truth: The nearest of three walls, as without the translation.

    Source: P. Upchurch, M. Desbrun, Tightening the Precision of Perspective Rendering (Journal of Graphics
    Tools 16, 2012)
    """
    walls = [placed("square", 0.5 * d, [0.4 * (k - 1) * d, 0.0, away - d]) for k, d in enumerate(DEPTHS)]
    return scene_of(moved(central(NEAR, None), 0.0, 0.0, away), *walls)


@hard_case("relations", "scale of everything", octaves(0, 120, 8), continuous=False)
@variants(
    *(
        Variant(f"raycast-{test}float32", 2.0 ** (128 / 3), "2^(128/3): a product of three lengths overflows")
        for test in ("", "moller-trumbore-", "woop-")
    ),
    Variant("scanline-direct", None, "float64: 2^340"),
)
def scale_by_powers(scale: float, side: int) -> Scene:
    """Scale a crumpled net and a sphere, about the eye, and the near plane with them.

    Scene and camera are multiplied by a power of two. No digit changes, and no decision may, until a product
    overflows: a product of three lengths, which triangle tests divide by another to get the distance, does in
    float32 beyond 2^42.

    Truth: The same picture at every scale.

    Source: J. R. Shewchuk, Adaptive Precision Floating-Point Arithmetic (1997): exact barring over- and
    underflow
    """
    corners, triangles = crumpled(side, 0.3, 0.4)
    ball = placed("sphere", 0.5 * scale, [0.0, 0.0, -1.5 * scale])
    return scene_of(central(0.5 * scale), mesh(scale * corners, triangles), ball)
