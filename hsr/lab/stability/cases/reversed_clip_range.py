"""Reversed depth with and without the clip range [0, 1]."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability import theory
from hsr.lab.stability.building import central, flat, quads, scene_of
from hsr.lab.stability.family import Variant, buffer, hard_case, octaves, variants
from hsr.mistakes.renderers import through_ndc
from hsr.scene.model import Scene

NEAR, FAR, DEPTH = 1.0, 65537.0, 1000.0

D16, D24 = (theory.integers(bits, DEPTH, NEAR, FAR) / DEPTH for bits in (16, 24))
D32F = theory.float_window(DEPTH, NEAR, FAR) / DEPTH
REVERSED = theory.float_reversed(DEPTH, NEAR, FAR) / DEPTH
THROUGH_NDC = theory.reversed_through_ndc(DEPTH, NEAR, FAR) / DEPTH
"""What each format resolves, over the distance."""


def kept(name: str, breaks: float, because: str, method: str, depth_format: str) -> Variant:
    """Return a method with a depth format of its own."""
    return Variant(name, breaks, because, method=method, options={"depth_format": depth_format})


@hard_case("depth", "separation over distance, at 1000 times the near distance", octaves(-2, -28, 2))
@variants(
    Variant("D16", D16, "q d / near", method="scanline-d16"),
    Variant("D24", D24, "q d / near", method="scanline-d24"),
    kept("D32F", D32F, "2^-24 d / near", "scanline-direct", "d32f"),
    kept("D32F reversed in [0, 1]", REVERSED, "2^-23 at most", "scanline-direct", "d32f-reversed"),
    buffer("D32F reversed in [-1, 1]", THROUGH_NDC, "2^-25 d / near", stored=through_ndc),
    Variant("opengl", D24, "q d / near, as D24"),
    kept("opengl D32F reversed in [0, 1]", REVERSED, "2^-23 at most", "opengl", "d32f-reversed"),
    kept("opengl D32F reversed in [-1, 1]", THROUGH_NDC, "2^-25 d / near", "opengl", "d32f-reversed-ndc"),
)
def reversed_clip_range(part: float, _: int) -> Scene:
    """Hang eight pairs of strips side by side, the farther first, each pair a little nearer than the last.

    Floats are dense near 0, so a reversed buffer, 1 at near and 0 at far, spends them where window depth is
    crowded. OpenGL's normalised depth runs from -1 to 1: adding 1 and halving rounds everything at the
    spacing of numbers near 1 first, and what reversing has gained is lost again. With glClipControl it runs
    from 0 to 1, and nothing is lost.

    Truth: The nearer strip of every pair.

    Source: N. Reed, Depth Precision Visualized (2015); OpenGL extension ARB_clip_control
    """
    corners = []
    for k, x in enumerate(np.linspace(-1.0, 1.0, 8, endpoint=False)):
        depth = DEPTH * (1.0 - 0.011 * k)
        strip = flat([[x, -1.0], [x + 0.25, -1.0], [x + 0.25, 1.0], [x, 1.0]])
        corners += [depth * (1.0 + part) * strip, depth * strip]
    return scene_of(central(NEAR, FAR), quads(corners))
