"""Depth stepped along ever longer spans."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import mesh, parallel, powers_of_two, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.scene.model import Scene

ROWS = 8
GAP = 64
"""Steps of a 24-bit buffer between two spans."""

LATE = 4.0
"""The factor: of eight pairs of spans few drift apart by nearly as much as rounding can make them."""


def scene(length: float, _: int) -> Scene:
    """Point two triangles along every line of samples, the farther first; depth runs from about 1/2 to 9/10.

    At the right end they come as close as the gap, by increments a step or more apart: each drifts its own
    way.
    """
    random = np.random.default_rng(0)
    end, gap = 0.5 * length, GAP * 2.0**-24
    corners = []
    for y in 0.5 * ROWS - 0.5 - np.arange(ROWS):
        left, right = random.uniform(0.5, 0.55), random.uniform(0.85, 0.9)
        apart = gap + random.uniform(1.0, 3.0) * length * 2.0**-24
        for a, b in ((left + apart, right + gap), (left, right)):
            corners += [[-end, y - 0.4, -a], [end, y, -b], [-end, y + 0.4, -a]]
    return scene_of(parallel(ROWS, 0.0, 1.0), mesh(corners, np.arange(len(corners)).reshape(-1, 3)))


def guarded(bits: int) -> Variant:
    """Return stepping in integers with so many guard bits."""
    at = 2.0 * GAP * 2.0**bits
    return Variant(
        f"24 bits + {bits} guard",
        at,
        "2^g 2 gap",
        LATE,
        method="scanline-fixed",
        options={"guard_bits": bits},
    )


FAMILY = Family(
    name="long-span",
    group="depth",
    story=(
        "Along a span depth goes on by an increment, -A/C. Rounding is the same in every step, so it adds "
        "up: float32 drifts by up to half a step of a 24-bit buffer a sample. Two spans 64 steps apart "
        "change their order after about 128 samples. Evaluated anew at every sample depth does not drift, "
        "nor, for a while, in integers with guard bits."
    ),
    expected="The nearer span everywhere.",
    source="D. Hearn, M. P. Baker, Computer Graphics, depth-buffer method: z' = z - A/C",
    parameter="length of the spans, in samples",
    sweep=powers_of_two(3, 14),
    continuous=False,
    scene=scene,
    size=lambda length, _: (int(length), ROWS),
    variants=(
        Variant("scanline-float32", 2.0 * GAP, "2 gap: L / 2 steps of drift", LATE),
        Variant("scanline-float32-direct", None, "3 steps at any length"),
        guarded(0),
        guarded(6),
        Variant("scanline-fixed", None, "12 guard bits: 2^12 2 gap, longer than any picture"),
        Variant("scanline", None, "2^29 2 gap: float64"),
    ),
)
