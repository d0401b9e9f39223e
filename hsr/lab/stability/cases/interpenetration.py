"""Two planes that penetrate each other, at an ever smaller angle."""

from __future__ import annotations

from hsr.lab.stability.building import parallel, powers_of_two, quads, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.scene.model import Scene

SWEEP = powers_of_two(-7, -32)


def scene(slope: float, side: int) -> Scene:
    """Let two planes cross along the middle of the picture, at a depth of 0.4."""
    end, z = 0.5 * side, 0.4
    tilted = [
        quads(
            [[[-end, -end, rise - z], [end, -end, -rise - z], [end, end, -rise - z], [-end, end, rise - z]]]
        )
        for rise in (slope * end, -slope * end)
    ]
    return scene_of(parallel(side, 0.0, 1.0), *tilted)


FAMILY = Family(
    name="interpenetration",
    group="order",
    story=(
        "Two planes go through each other along the middle of the picture. No order in which they could be "
        "painted is right. A depth buffer is, as long as it tells their depths apart at the samples next to "
        "the line, half a pixel from it: there they differ by the difference of slopes times half a pixel."
    ),
    expected="The plane that comes forward, on either side of the middle.",
    source=(
        "J. Foley, A. van Dam, S. Feiner, J. Hughes, Computer Graphics: Principles and Practice, 15.4 and "
        "15.5"
    ),
    parameter="slope of each plane, in depth ranges a pixel",
    sweep=SWEEP,
    scene=scene,
    variants=(
        Variant("painter", SWEEP[0], "always: no order of two is right"),
        Variant("scanline-d16", 1.0 / (2.0**16 - 1.0), "q = 1 / (2^16 - 1)"),
        Variant("scanline-d24", 1.0 / (2.0**24 - 1.0), "q = 1 / (2^24 - 1)"),
        Variant("scanline-float32-direct", 2.0**-25, "2^-25: spacing of float32 below 1/2"),
        Variant("opengl", 1.0 / (2.0**24 - 1.0), "q = 1 / (2^24 - 1), after float32"),
    ),
)
