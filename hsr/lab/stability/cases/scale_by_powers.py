"""Scene and camera multiplied by ever greater powers of two."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import central, mesh, powers_of_two, scene_of
from hsr.lab.stability.cases.lattice_edges import net
from hsr.lab.stability.family import Family, Variant
from hsr.scene.model import Scene


def scene(scale: float, side: int) -> Scene:
    """Scale a crumpled net and a sphere, about the eye, and the near plane with them."""
    corners, triangles = net(side, (0.3, 0.4))
    depth = 2.0 + np.random.default_rng(0).integers(0, 65, len(corners)) / 64.0
    vertices = scale * depth[:, None] * np.insert(corners * (2.0 / side), 2, -1.0, axis=1)
    ball = {"shape": "sphere", "transform": [{"scale": 0.5 * scale}, {"translate": [0.0, 0.0, -1.5 * scale]}]}
    return scene_of(central(0.5 * scale), mesh(vertices, triangles), ball)


FAMILY = Family(
    name="scale-by-powers",
    group="relations",
    story=(
        "Scene and camera are multiplied by a power of two. No digit changes, and no decision may, until a "
        "product overflows: a product of three lengths, which triangle tests divide by another to get the "
        "distance, does in float32 beyond 2^42."
    ),
    expected="The same picture at every scale.",
    source=(
        "J. R. Shewchuk, Adaptive Precision Floating-Point Arithmetic (1997): exact barring over- and "
        "underflow"
    ),
    parameter="scale of everything",
    sweep=powers_of_two(0, 120, 8),
    continuous=False,
    scene=scene,
    variants=(
        *(
            Variant(
                f"raycast-{test}float32", 2.0 ** (128 / 3), "2^(128/3): a product of three lengths overflows"
            )
            for test in ("", "moller-trumbore-", "woop-")
        ),
        Variant("scanline-direct", None, "float64: 2^340"),
    ),
)
