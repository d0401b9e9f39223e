"""Rays that graze the extents of two meshes where they meet."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import central, powers_of_two, rectangle, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.lab.stability.theory import U64
from hsr.scene.model import Scene

WIDTH = 64
"""Samples of a picture: its columns have directions of up to six bits, some of whose reciprocals round up."""


def scene(past: float, _: int) -> Scene:
    """Hang panels side by side, each at a depth of its own; they meet so far left of columns of samples."""
    panels, random = [], np.random.default_rng(0)
    for top in (1.0, 0.5, 0.0, -0.5):
        for column in range(3, WIDTH - 4, 4):
            depth = 1.0 + random.integers(1, 1024) / 1024.0
            left, right = ((2 * k + 1 - 2 * past - WIDTH) / WIDTH * depth for k in (column, column + 4))
            panels.append(rectangle((left, right), ((top - 0.5) * depth, top * depth), depth))
    return scene_of(central(0.5), *panels)


FAMILY = Family(
    name="box-grazing",
    group="rays",
    story=(
        "Panels hang side by side, and along their seams rays graze the flat extents of two of them. The "
        "slab test multiplies by a rounded reciprocal of the direction and may find that the ray leaves an "
        "extent before it has entered. Then the panel that owns the sample is never asked, and the other "
        "does not own it: the ray escapes. Two units in the last place of padding, or a division, lose "
        "none."
    ),
    expected="A panel in every column from the first seam to the last.",
    source="T. Ize, Robust BVH Ray Traversal (JCGT 2, 2013)",
    parameter="distance of rays from the seam, in pixels",
    sweep=(*powers_of_two(-2, -50, 3), 0.0),
    scene=scene,
    size=lambda *_: (WIDTH, WIDTH),
    variants=(
        Variant("raycast-naive-slabs", 0.5 * U64 * WIDTH, "2^-54 W px: one rounding, W / 2 from the middle"),
        Variant("raycast-single", None, "its slabs are padded by two units in the last place"),
    ),
)
