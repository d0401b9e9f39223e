"""Edges stepped down ever taller pictures."""

from __future__ import annotations

import math

import numpy as np

from hsr.lab.stability.building import parallel, powers_of_two, quads, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.lab.stability.theory import U32
from hsr.scene.model import Scene

WIDTH, EDGES = 64, 15


def scene(height: float, _: int) -> Scene:
    """Divide the picture into upright strips by edges that are almost vertical."""
    random = np.random.default_rng(0)
    top, bottom = np.sort(
        random.uniform(-0.4, 0.4, (2, EDGES + 2)) + np.linspace(-34.0, 34.0, EDGES + 2), axis=1
    )
    end = 0.5 * height
    strips = [
        [[bottom[k], -end, -1.0], [bottom[k + 1], -end, -1.0], [top[k + 1], end, -1.0], [top[k], end, -1.0]]
        for k in range(EDGES + 1)
    ]
    return scene_of(parallel(height), quads(strips))


def first_wrong() -> float:
    """Return the height at which drift is expected to cost the first sample.

    After r lines an edge is off by ``r 2^-24 W / 4``: half a spacing at W / 2, always the same way. Of E
    edges one sample in ``1 / (2 error)`` is passed, so ``E 2^-24 W H^2 / 4`` samples are wrong in H lines.
    """
    return math.sqrt(4.0 / (EDGES * U32 * WIDTH))


FAMILY = Family(
    name="edge-drift",
    group="coverage",
    story=(
        "Down an edge x goes on by 1/m from line to line. In float32 every step is rounded, always by the "
        "same amount as long as x stays between two powers of two, and the edge drifts away from where it "
        "is; after enough lines it passes on the wrong side of a sample."
    ),
    expected="The strip whose edges lie on either side of the sample.",
    source="D. Hearn, M. P. Baker, Computer Graphics, scan-line polygon fill: x' = x + 1/m",
    parameter="height of the picture, in samples",
    sweep=powers_of_two(3, 12),
    continuous=False,
    scene=scene,
    size=lambda height, _: (WIDTH, int(height)),
    variants=(
        Variant("scanline-float32", first_wrong(), "H = sqrt(4 2^24 / (E W)): drift of W 2^-26 a line"),
        Variant("scanline", None, "float64: 2^14.5 times as high"),
    ),
)
