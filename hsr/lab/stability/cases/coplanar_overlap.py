"""Triangles in one plane, their corners on an ever finer grid."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import mesh, parallel, powers_of_two, scene_of
from hsr.lab.stability.family import Family, Variant, another_choice
from hsr.scene.model import Scene


def scene(grid: float, side: int) -> Scene:
    """Lay large triangles over each other in the plane z = -1/2 + (x + 2 y) / (4 W), corners on a grid."""
    random = np.random.default_rng(3)
    around = np.array([[-0.9, -0.8], [0.9, -0.6], [0.1, 0.9]]) + random.uniform(-0.1, 0.1, (6, 3, 2))
    across = np.rint(around.reshape(-1, 2) * 0.5 * side / grid) * grid
    z = -0.5 + (across[:, 0] + 2.0 * across[:, 1]) / (4.0 * side)
    return scene_of(parallel(side, 0.0, 1.0), mesh(np.column_stack([across, z]), np.arange(18).reshape(6, 3)))


def first_wrong(bits: int) -> Variant:
    """Return the theory for arithmetic of so many bits.

    Corners have ``log2(W / (2 g))`` bits, products of two differences twice as many, and two more. The factor
    is large, as the first bits that are lost decide at few samples.
    """
    told = f"2^(-{bits}/2) W: products of two corners need more than {bits} bits"
    name = "scanline-direct" if bits == 53 else "scanline-float32-direct"
    return Variant(name, lambda side: 2.0 ** (-bits / 2.0) * side, told, 4.0)


FAMILY = Family(
    name="coplanar-overlap",
    group="order",
    story=(
        "Six triangles lie in one plane and over each other. Any of them may own a sample they share, but "
        "the lab's rule names one, the lowest, so that all methods can agree. While the corners have few "
        "enough bits, plane equations are exact and depths equal; beyond that rounding decides, another way "
        "from triangle to triangle. Certified methods compare the planes."
    ),
    expected="The lowest of the triangles at a sample; counted wrong here is any other choice.",
    source=(
        "D. Hearn, M. P. Baker, Computer Graphics, plane equations; the count is derived from the bits of "
        "products"
    ),
    parameter="grid of the corners, in pixels",
    sweep=powers_of_two(0, -38, 2),
    continuous=False,
    scene=scene,
    wrong=another_choice,
    figure_name="samples with another choice",
    variants=(first_wrong(24), first_wrong(53)),
)
