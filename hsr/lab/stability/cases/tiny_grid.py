"""A picture zoomed until its samples are units in the last place apart."""

from __future__ import annotations

from hsr.lab.stability.building import mesh, powers_of_two, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.lab.stability.theory import U32, U64
from hsr.scene.model import Scene

REACH = 24.1
SLOPE = 2.0 / 3.0
"""Not a power of two: a corner whose x and y are rounded alike would stay on the edge."""


def scene(zoom: float, side: int) -> Scene:  # noqa: ARG001
    """Look at the point (1/2, 1/2) of a long edge of slope 2/3 through an ever smaller window."""
    matrix = [
        [zoom, 0.0, 0.0, -0.5 * zoom],
        [0.0, zoom, 0.0, -0.5 * zoom],
        [0.0, 0.0, -1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]
    left, right = ([0.5 + x, 0.5 + SLOPE * x, 0.0] for x in (-REACH, REACH))
    triangle = mesh([left, [REACH, -REACH, 0.0], right], [[0, 1, 2]])
    return scene_of({"type": "matrix", "matrix": matrix}, triangle)


def first_wrong(rounding: float, side: int) -> float:
    """Return the zoom at which rounding a corner moves the edge over the nearest sample.

    Steps are ``2 / (zoom W)``, and y - 2/3 x an odd multiple of a sixth of that at the samples.
    """
    return 1.0 / (3.0 * side * REACH * rounding)


FAMILY = Family(
    name="tiny-grid",
    group="coverage",
    story=(
        "A window about one point of a long edge is zoomed, until its samples are neighbouring floats. The "
        "nearest samples lie a sixth of a step from the edge: the sign of the orientation of three points "
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
        Variant("scanline-direct", lambda side: first_wrong(U64, side), "2^53 / (72 W)"),
        Variant("opengl", lambda side: first_wrong(U32, side), "2^24 / (72 W)"),
    ),
)
