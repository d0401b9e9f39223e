"""Variants that move corners or edges before they decide, and by how much.

A sample that lies nearer to an edge than that may get the wrong face. Corners are moved half the spacing of
the numbers that hold them: ``2^-(b+1)`` pixels by a grid of ``2^-b``, and ``2^-24`` of a coordinate by
float32. In pictures of W samples coordinates are up to W pixels, or W / 2 from the middle; rounding a corner
and then the edge function costs a few times that, which the factor of the verdict leaves room for.
"""

from __future__ import annotations

from hsr.lab.stability.family import Variant
from hsr.lab.stability.theory import U32

GRIDS = {"scanline-snap-4": 4, "scanline-snap-8": 8, "opengl": 8}
"""Variants that snap corners, and the bits of their grids."""


def snapped(gain: float = 1.0) -> tuple[Variant, ...]:
    """Return the variants that snap, if ``gain`` times the distance they move corners is what matters."""
    told = "2^-(b+1) px: half the grid of the corners" + _times(gain)
    return tuple(Variant(name, gain * 2.0 ** -(bits + 1), told) for name, bits in GRIDS.items())


def on_screen(gain: float = 1.0) -> tuple[Variant, ...]:
    """Return scan conversion in float32, if ``gain`` times the rounding of screen coordinates matters."""
    told = "2^-24 W px: screen coordinates in float32" + _times(gain)
    return (Variant("scanline-float32-direct", lambda side: gain * U32 * side, told),)


def in_space(gain: float = 1.0) -> tuple[Variant, ...]:
    """Return ray casting in float32, if ``gain`` times the rounding of corners and directions matters.

    The factor of two tests is larger: Moeller and Trumbore's, and Embree's, round cross products besides.
    """
    told = "2^-24 W px: float32 directions and corners" + _times(gain)
    factors = {"raycast-moller-trumbore-float32": 4.0, "raycast-woop-float32": 2.0, "embree": 4.0}
    return tuple(Variant(name, lambda side: gain * U32 * side, told, by) for name, by in factors.items())


def _times(gain: float) -> str:
    return "" if gain == 1.0 else f", times {gain:g}"
