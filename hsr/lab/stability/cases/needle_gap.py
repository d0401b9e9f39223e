"""A gap between two walls, ever narrower."""

from __future__ import annotations

from hsr.lab.stability.building import parallel, powers_of_two, rectangle, scene_of, wall
from hsr.lab.stability.family import Family
from hsr.lab.stability.rounding import on_screen, snapped
from hsr.scene.model import Scene


def scene(width: float, side: int) -> Scene:
    """Leave a gap about a column of samples between two walls, in front of a third."""
    left, right, end = 0.5 - 0.5 * width, 0.5 + 0.5 * width, float(side)
    walls = [rectangle(x, (-end, end), 1.0) for x in ((-end, left), (right, end))]
    return scene_of(parallel(side), *walls, wall(1.5, side))


FAMILY = Family(
    name="needle-gap",
    group="coverage",
    story=(
        "Two walls leave a gap through which a third is seen, at one column of samples in the middle of it. "
        "However narrow the gap, it is seen there. A grid of 2^-b pixels closes it when both its edges are "
        "rounded to the column of samples, which one of the two walls then owns."
    ),
    expected="The far wall in the column of samples, the near walls elsewhere.",
    source="Microsoft, Direct3D 11.3 Functional Specification, 3.4.1: corners are snapped to 8 fraction bits",
    parameter="width of the gap, in pixels",
    sweep=powers_of_two(1, -33, 2),
    scene=scene,
    variants=(*snapped(2.0), *on_screen(2.0)),
)
