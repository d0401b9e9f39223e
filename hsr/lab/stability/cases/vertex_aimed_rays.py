"""Rays aimed at the corners of a mesh, and ever less past them."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import central, mesh, powers_of_two, scene_of
from hsr.lab.stability.cases.lattice_edges import net
from hsr.lab.stability.family import Family, Variant
from hsr.lab.stability.rounding import in_space
from hsr.lab.stability.theory import U64
from hsr.scene.model import Scene


def scene(past: float, side: int) -> Scene:
    """Surround the eye by a crumpled net whose corners lie right of and above samples, seen from the eye."""
    corners, triangles = net(side, (past, 2.0 * past))
    depth = 2.0 + np.random.default_rng(0).integers(0, 65, len(corners)) / 64.0
    vertices = depth[:, None] * np.insert(corners * (2.0 / side), 2, -1.0, axis=1)
    return scene_of(central(0.5), mesh(vertices, triangles))


FAMILY = Family(
    name="vertex-aimed-rays",
    group="rays",
    story=(
        "A crumpled net closes off the view. Its corners come ever closer to the rays of samples, each at a "
        "depth of its own. A test that looks at the edge of two triangles in two different ways may deny it "
        "to both, and the ray escapes through a closed surface, in float64 as in float32; a watertight test "
        "loses no ray, but rounding can still choose the wrong neighbour."
    ),
    expected="The triangle to the left of and below each corner; nowhere the background.",
    source="S. Woop, C. Benthin, I. Wald, Watertight Ray/Triangle Intersection (JCGT 2, 2013)",
    parameter="distance of the rays from the corners, in pixels",
    sweep=powers_of_two(-1, -49, 2),
    scene=scene,
    variants=(
        *in_space(),
        # Its two cross products are rounded besides, as those of float32.
        Variant("raycast-moller-trumbore", lambda side: U64 * side, "2^-53 W px: float64", 4.0),
        Variant("opengl", 2.0**-9, "2^-9 px: half the grid of its corners"),
    ),
)
