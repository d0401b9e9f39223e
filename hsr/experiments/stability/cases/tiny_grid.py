"""A picture zoomed until its samples are units in the last place apart."""

from __future__ import annotations

from hsr.experiments.stability.building import mesh, powers_of_two, scene_of
from hsr.experiments.stability.family import Family, Variant
from hsr.scene.model import Scene

REACH = 24.1


def scene(zoom: float, side: int) -> Scene:  # noqa: ARG001
    """Look at the point (1/2, 1/2) of a long edge of slope 1/2 through an ever smaller window."""
    matrix = [
        [zoom, 0.0, 0.0, -0.5 * zoom],
        [0.0, zoom, 0.0, -0.5 * zoom],
        [0.0, 0.0, -1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]
    left, right = [0.5 - REACH, 0.5 - 0.5 * REACH, 0.0], [0.5 + REACH, 0.5 + 0.5 * REACH, 0.0]
    triangle = mesh([left, [REACH, -REACH, 0.0], right], [[0, 1, 2]])
    return scene_of({"type": "matrix", "matrix": matrix}, triangle)


FAMILY = Family(
    name="tiny-grid",
    group="coverage",
    story=(
        "A window about one point of a long edge is zoomed, until its samples are neighbouring floats. The "
        "nearest samples lie a quarter of a step from the edge: the sign of the orientation of three points "
        "decides, and in floats that is noise as soon as the window is smaller than the rounding of what "
        "lies far outside."
    ),
    expected="The triangle at the samples below its edge, the background above.",
    source=(
        "L. Kettner, K. Mehlhorn, S. Pion, S. Schirra, C. Yap, Classroom Examples of Robustness Problems in "
        "Geometric Computations (2008)"
    ),
    parameter="zoom of the window",
    sweep=powers_of_two(0, 50, 2),
    scene=scene,
    variants=(
        Variant("scanline-direct", lambda side: 2.0**53 / (REACH * side), "2^53 / (24 W)", 16.0),
        Variant("opengl", lambda side: 2.0**24 / (REACH * side), "2^24 / (24 W)", 16.0),
    ),
)
