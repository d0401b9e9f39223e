"""Edge functions in integers that are too short for the triangle."""

from __future__ import annotations

import math

import numpy as np

from hsr.lab.stability.building import powers_of_two
from hsr.lab.stability.cases.huge_triangle import scene
from hsr.lab.stability.family import Family, Variant
from hsr.mistakes.renderers import GRID, Buffer


def first_overflow(bits: int) -> float:
    """Return the length from which on twice the area of the triangle does not fit.

    The long edge is 6 L by 2 L pixels, and the third corner lies 3 L to the right of its left end and 3 L
    below: the cross product, whose sign turns all edges, is 18 L^2 + 6 L^2 in squares of the grid.
    """
    return math.sqrt(2.0 ** (bits - 1) / 24.0) / GRID


FAMILY = Family(
    name="integer-overflow",
    group="coverage",
    story=(
        "On a grid, edge functions are exact in integers, as long as they fit: a triangle of 2^k pixels on "
        "a grid of 2^-b needs 2 (k + b) + 2 bits. With 8 bits of sub-pixels 32 of them are full at some "
        "two hundred pixels; from there on signs are those of the remainder. Real rasterisers choose 64 "
        "bits, or split."
    ),
    expected="The triangle at the samples below its edge, the wall at those above.",
    source=(
        "Derived: the product of two differences of corners; cf. J. Pineda, A Parallel Algorithm for "
        "Polygon Rasterization (1988)"
    ),
    parameter="distance of the corners, in pixels",
    sweep=powers_of_two(2, 16, 2),
    scene=scene,
    variants=(
        Variant("int32", first_overflow(32), "sqrt(2^31 / 24) / 2^8 px", mistake=Buffer(whole=np.int32)),
        Variant("int64", None, "sqrt(2^63 / 24) / 2^8 px, beyond the sweep", mistake=Buffer(whole=np.int64)),
    ),
)
