"""Variants that move corners or edges before they decide, and by how much.

A sample that lies nearer to an edge than that may get the wrong face. Corners are moved half the spacing of
the numbers that hold them: ``2^-(b+1)`` pixels by a grid of ``2^-b``, and ``2^-24`` of a coordinate by
float32. In pictures of W samples coordinates are up to W pixels, or W / 2 from the middle; rounding a corner
and then the edge function costs a few times that, which the factor of the verdict leaves room for.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from hsr.lab.stability.family import Mistake, Variant
from hsr.lab.stability.theory import U32, U64

Renderer = Callable[[type[np.floating[Any]]], Mistake]
"""From a type of floats to a renderer that computes in it."""

GRIDS = {"scanline-snap-4": 4, "scanline-snap-8": 8, "opengl": 8}
"""Variants that snap corners, and the bits of their grids."""

DRIVER = Variant("opengl", 2.0**-9, "2^-9 px: half the grid of its corners")
"""The driver, where its grid is coarser than the rounding of all others."""


def snapped(gain: float = 1.0) -> tuple[Variant, ...]:
    """Return the variants that snap, if ``gain`` times the distance they move corners is what matters."""
    told = "2^-(b+1) px: half the grid of the corners" + _times(gain)
    return tuple(Variant(name, gain * 2.0 ** -(bits + 1), told) for name, bits in GRIDS.items())


def on_screen(gain: float = 1.0) -> Variant:
    """Return scan conversion in float32, if ``gain`` times the rounding of screen coordinates matters."""
    told = "2^-24 W px: screen coordinates in float32" + _times(gain)
    return Variant("scanline-float32-direct", lambda side: gain * U32 * side, told)


def in_space(gain: float = 1.0) -> tuple[Variant, ...]:
    """Return ray casting in float32, if ``gain`` times the rounding of corners and directions matters.

    The factor of two tests is larger: Moeller and Trumbore's, and Embree's, round cross products besides.
    """
    told = "2^-24 W px: float32 directions and corners" + _times(gain)
    factors = {"raycast-moller-trumbore-float32": 4.0, "raycast-woop-float32": 2.0, "embree": 4.0}
    return tuple(Variant(name, lambda side: gain * U32 * side, told, by) for name, by in factors.items())


def first_drafts(
    name: str, renderer: Renderer, breaks: Callable[[float, int], float], *because: str, factor: float = 2.0
) -> tuple[Variant, ...]:
    """Return a textbook formula in float32 and in float64, which break by unit roundoff and side.

    ``factor`` is that of float32.
    """
    units: dict[type[np.floating[Any]], float] = {np.float32: U32, np.float64: U64}
    return tuple(
        Variant(f"{name} {real.__name__}", partial(breaks, unit), told, by, mistake=renderer(real))
        for (real, unit), told, by in zip(units.items(), because, (factor, 2.0), strict=True)
    )


def _times(gain: float) -> str:
    return "" if gain == 1.0 else f", times {gain:g}"
