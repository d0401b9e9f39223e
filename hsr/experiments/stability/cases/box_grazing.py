"""Rays that graze the extents of two meshes where they meet."""

from __future__ import annotations

import numpy as np

from hsr.experiments.stability.building import central, powers_of_two, rectangle, scene_of
from hsr.experiments.stability.family import Family, Variant
from hsr.experiments.stability.theory import U64
from hsr.scene.model import Scene

ZOOM = 1.3
"""Not a power of two: directions have many digits, and reciprocals are rounded."""


def scene(past: float, side: int) -> Scene:
    """Hang panels beside and below each other at odd depths; they meet so far left of and above samples."""
    panels, random = [], np.random.default_rng(0)
    for row, column in np.mgrid[1 : side - 2 : 2, 1 : side - 2 : 2].reshape(2, -1).T.tolist():
        depth = 1.0 + random.integers(1, 128) / 128.0
        left, right, top, bottom = (
            (2 * k + 1 - 2 * past - side) / (ZOOM * side) * depth for k in (column, column + 2, row, row + 2)
        )
        panels.append(rectangle((left, right), (-bottom, -top), depth))
    return scene_of(central(0.5, None, ZOOM), *panels)


FAMILY = Family(
    name="box-grazing",
    group="rays",
    story=(
        "Panels hang side by side, and along their seams rays graze the flat extents of two of them. The "
        "slab test multiplies by a rounded reciprocal of the direction and may find that the ray leaves an "
        "extent before it has entered: if both are lost, so is the sample. Two units in the last place of "
        "padding, or a division, are enough to lose none."
    ),
    expected="A panel at every sample but those of the border.",
    source="T. Ize, Robust BVH Ray Traversal (JCGT 2, 2013)",
    parameter="distance of rays from the seam, in pixels",
    sweep=(*powers_of_two(-2, -56, 3), 0.0),
    scene=scene,
    variants=(
        Variant(
            "raycast-naive-slabs", lambda side: U64 * side, "2^-53 W px: one rounding of a reciprocal", 16.0
        ),
        Variant(
            "raycast-single",
            lambda side: U64 * side,
            "2^-53 W px: its directions, not its padded slabs",
            16.0,
        ),
    ),
)
