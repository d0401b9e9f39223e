"""Surfaces that no order of painting, and no coarse depth, can tell apart."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hsr.lab.stability.building import loose, parallel, quads, scene_of
from hsr.lab.stability.family import Variant, also, another_choice, hard_case, octaves, variants
from hsr.scene.model import Scene


def tilt_of(bits: int) -> Callable[[int], float]:
    """Return the tilt, by the side, at which bars part by less than a step of so many bits."""
    return lambda side: 2.0**-bits / (0.6 * side)


@hard_case("order", "tilt of the bars, in depth ranges a pixel", octaves(-7, -33, 2))
@variants(
    Variant("painter", 2.0**-7, "always: there is no order"),
    Variant("scanline-d16", tilt_of(16), "2^-16 / (0.6 W)"),
    Variant("scanline-d24", tilt_of(24), "2^-24 / (0.6 W)"),
    Variant("opengl", tilt_of(24), "2^-24 / (0.6 W), as D24"),
)
def cyclic_overlap(tilt: float, side: int) -> Scene:
    """Lay four bars about the middle; along each depth decreases so much a pixel.

    Four bars lie each over the next, the last over the first. There is no order in which to paint them,
    unless one is cut; a depth buffer needs no order. The bars part by twice the tilt times their reach where
    they cross, and a depth format must tell that.

    Truth: A pinwheel: turned by a quarter it is the same, with the bars renamed.

    Source: M. Newell, R. Newell, T. Sancha, A Solution to the Hidden Surface Problem (1972)
    """
    near, far = 0.2 * side, 0.4 * side
    bar = np.array([[-far, -far], [far, -far], [far, -near], [-far, -near]])
    corners = []
    for _ in range(4):
        corners.append(np.column_stack([bar, tilt * np.array([-far, far, far, -far]) - 0.4]))
        bar = np.column_stack([-bar[:, 1], bar[:, 0]])  # a quarter turn is exact
    return scene_of(parallel(side, 0.0, 1.0), quads(corners))


@hard_case("order", "slope of each plane, in depth ranges a pixel", octaves(-7, -32))
@variants(
    Variant("painter", 2.0**-7, "always: no order of two is right"),
    Variant("scanline-d16", 1.0 / (2.0**16 - 1.0), "q = 1 / (2^16 - 1)"),
    Variant("scanline-d24", 1.0 / (2.0**24 - 1.0), "q = 1 / (2^24 - 1)"),
    Variant("scanline-float32-direct", 2.0**-25, "2^-25: spacing of float32 below 1/2"),
    Variant("opengl", 1.0 / (2.0**24 - 1.0), "q = 1 / (2^24 - 1), after float32"),
)
def interpenetration(slope: float, side: int) -> Scene:
    """Let two planes cross along the middle of the picture, at a depth of 0.4.

    Two planes go through each other along the middle of the picture. No order in which they could be painted
    is right. A depth buffer is, as long as it tells their depths apart at the samples next to the line, half
    a pixel from it: there they differ by the difference of slopes times half a pixel.

    Truth: The plane that comes forward, on either side of the middle.

    Source: J. Foley, A. van Dam, S. Feiner, J. Hughes, Computer Graphics: Principles and Practice, 15.4 and
    15.5
    """
    end, z = 0.5 * side, 0.4
    tilted = [
        quads([[-end, -end, rise - z], [end, -end, -rise - z], [end, end, -rise - z], [-end, end, rise - z]])
        for rise in (slope * end, -slope * end)
    ]
    return scene_of(parallel(side, 0.0, 1.0), *tilted)


def overlapping(method: str, bits: int) -> Variant:
    """Return the theory for arithmetic of so many bits.

    Corners have ``log2(W / (2 g))`` bits, products of two differences twice as many, and two more. The factor
    is large, as the first bits that are lost decide at few samples.
    """
    told = f"2^(-{bits}/2) W: products of two corners need more than {bits} bits"
    return Variant(method, lambda side: 2.0 ** (-bits / 2.0) * side, told, 4.0)


@hard_case("order", "grid of the corners, in pixels", octaves(0, -38, 2), continuous=False)
@also(wrong=another_choice, figure_name="samples with another choice")
@variants(overlapping("scanline-float32-direct", 24), overlapping("scanline-direct", 53))
def coplanar_overlap(grid: float, side: int) -> Scene:
    """Lay large triangles over each other in the plane z = -1/2 + (x + 2 y) / (4 W), corners on a grid.

    Six triangles lie in one plane and over each other. Any of them may own a sample they share, but the lab's
    rule names one, the lowest, so that all methods can agree. While the corners have few enough bits, plane
    equations are exact and depths equal; beyond that rounding decides, another way from triangle to triangle.
    Certified methods compare the planes.

    Truth: The lowest of the triangles at a sample; counted wrong here is any other choice.

    Source: D. Hearn, M. P. Baker, Computer Graphics, plane equations; the count is derived from the bits of
    products
    """
    random = np.random.default_rng(3)
    around = np.array([[-0.9, -0.8], [0.9, -0.6], [0.1, 0.9]]) + random.uniform(-0.1, 0.1, (6, 3, 2))
    across = np.rint(around.reshape(-1, 2) * 0.5 * side / grid) * grid
    z = -0.5 + (across[:, 0] + 2.0 * across[:, 1]) / (4.0 * side)
    return scene_of(parallel(side, 0.0, 1.0), loose(np.column_stack([across, z])))
