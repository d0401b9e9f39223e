"""Edge functions in integers that are too short for the triangle."""

from __future__ import annotations

import math

import numpy as np

from hsr.experiments.stability.building import powers_of_two
from hsr.experiments.stability.cases.huge_triangle import scene
from hsr.experiments.stability.family import Family, Variant
from hsr.experiments.stability.mistakes import GRID, Buffer


def first_overflow(bits: int) -> float:
    """Return the length from which on an edge function does not fit.

    Along the edge, of 6 L by 2 L pixels, a sample is at most L below an end: the greatest product is 6 L^2 in
    squares of the grid.
    """
    return math.sqrt(2.0 ** (bits - 1) / 6.0) / GRID


FAMILY = Family(
    name="integer-overflow",
    group="coverage",
    story=(
        "On a grid, edge functions are exact in integers, as long as they fit: a triangle of 2^k pixels on "
        "a grid of 2^-b needs 2 (k + b) + 2 bits. With 8 bits of sub-pixels 32 of them are full at little "
        "more than a hundred pixels; from there on signs are those of the remainder. Real rasterisers "
        "choose 64 bits, or split."
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
        Variant("int32", first_overflow(32), "sqrt(2^31 / 6) / 2^8 px", mistake=Buffer(whole=np.int32)),
        Variant("int64", None, "sqrt(2^63 / 6) / 2^8 px, beyond the sweep", mistake=Buffer(whole=np.int64)),
    ),
)
