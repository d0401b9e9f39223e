"""Rays that run within a side of an extent, or ever closer to it."""

from __future__ import annotations

from hsr.lab.stability.building import panel, parallel, powers_of_two, scene_of, wall
from hsr.lab.stability.family import Family, Variant
from hsr.mistakes.renderers import naive_boxes
from hsr.scene.model import Scene


def scene(past: float, side: int) -> Scene:
    """Hang panels before a wall; they meet so far left of columns of samples."""
    panels = []
    for column in range(3, side - 4, 4):
        left, right = (c + 0.5 - past - 0.5 * side for c in (column, column + 4))
        panels.append(panel((left, right), (-side, side), 1.0))
    return scene_of(parallel(side), *panels, wall(1.5, side))


FAMILY = Family(
    name="slab-degeneracies",
    group="rays",
    story=(
        "Parallel rays run along the sides of extents, and exactly within them in the end: there the slab "
        "test multiplies 0 by infinity, and what becomes of the NaN depends on the order of operands and on "
        "the sign of the zero. No order is right for all: the case needs a rule of its own."
    ),
    expected="A panel in every column from the first seam to the last.",
    source=(
        "A. Williams et al., An Efficient and Robust Ray-Box Intersection Algorithm (2005); T. Barnes, "
        "Fast, Branchless Ray/Bounding Box Intersections (2015)"
    ),
    parameter="distance of rays from the sides, in pixels",
    sweep=(*powers_of_two(-2, -44, 3), 0.0),
    scene=scene,
    variants=(
        Variant("minimum of NaN", 0.0, "0: 0 times infinity is NaN, and no hit", mistake=naive_boxes),
        Variant(
            "raycast-naive-slabs", None, "its order of operands is right for +0, and no direction has -0"
        ),
        Variant("raycast-single", None, "a ray within a side is inside"),
    ),
)
