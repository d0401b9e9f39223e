"""Edges and depths that are stepped along, or evaluated from far away: rounding adds up."""

from __future__ import annotations

import math

import numpy as np

from hsr.lab.stability.building import loose, parallel, quads, scene_of
from hsr.lab.stability.family import Variant, also, buffer, hard_case, octaves, variants
from hsr.lab.stability.theory import U32
from hsr.scene.model import Scene

WIDTH, EDGES = 64, 15


def first_drift() -> float:
    """Return the height at which drift is expected to cost the first sample.

    After r lines an edge is off by ``r 2^-24 W / 4``: half a spacing at W / 2, always the same way. Of E
    edges one sample in ``1 / (2 error)`` is passed, so ``E 2^-24 W H^2 / 4`` samples are wrong in H lines.
    """
    return math.sqrt(4.0 / (EDGES * U32 * WIDTH))


@hard_case("coverage", "height of the picture, in samples", octaves(3, 12), continuous=False)
@also(size=lambda height, _: (WIDTH, int(height)))
@variants(
    Variant("scanline-float32", first_drift(), "H = sqrt(4 2^24 / (E W)): drift of W 2^-26 a line"),
    Variant("scanline", None, "float64: 2^14.5 times as high"),
)
def edge_drift(height: float, _: int) -> Scene:
    """Divide the picture into upright strips by edges that are almost vertical.

    Down an edge x goes on by 1/m from line to line. In float32 every step is rounded, always by the same
    amount as long as x stays between two powers of two, and the edge drifts away from where it is; after
    enough lines it passes on the wrong side of a sample.

    Truth: The strip whose edges lie on either side of the sample.

    Source: D. Hearn, M. P. Baker, Computer Graphics, scan-line polygon fill: x' = x + 1/m
    """
    random = np.random.default_rng(0).uniform(-0.4, 0.4, (2, EDGES + 2))
    top, bottom = np.sort(random + np.linspace(-34.0, 34.0, EDGES + 2), axis=1)
    x = np.stack([bottom[:-1], bottom[1:], top[1:], top[:-1]], axis=1)
    y = np.broadcast_to(0.5 * height * np.array([-1.0, -1.0, 1.0, 1.0]), x.shape)
    return scene_of(parallel(height), quads(np.stack([x, y, np.full_like(x, -1.0)], axis=2)))


ROWS = 8
GAP = 64
"""Steps of a 24-bit buffer between two spans."""

LATE = 4.0
"""The factor: of eight pairs of spans few drift apart by nearly as much as rounding can make them."""


def guarded(bits: int) -> Variant:
    """Return stepping in integers with so many guard bits."""
    name, at, options = f"24 bits + {bits} guard", 2.0 * GAP * 2.0**bits, {"guard_bits": bits}
    return Variant(name, at, "2^g 2 gap", LATE, method="scanline-fixed", options=options)


@hard_case("depth", "length of the spans, in samples", octaves(3, 14), continuous=False)
@also(size=lambda length, _: (int(length), ROWS))
@variants(
    Variant("scanline-float32", 2.0 * GAP, "2 gap: L / 2 steps of drift", LATE),
    Variant("scanline-float32-direct", None, "3 steps at any length"),
    guarded(0),
    guarded(6),
    Variant("scanline-fixed", None, "12 guard bits: 2^12 2 gap, longer than any picture"),
    Variant("scanline", None, "2^29 2 gap: float64"),
)
def long_span(length: float, _: int) -> Scene:
    """Point two triangles along every line of samples, the farther first; depth runs from about 1/2 to 9/10.

    Along a span depth goes on by an increment, -A/C. Rounding is the same in every step, so it adds up:
    float32 drifts by up to half a step of a 24-bit buffer a sample. Two spans 64 steps apart change their
    order after about 128 samples. Evaluated anew at every sample depth does not drift, nor, for a while, in
    integers with guard bits.

    At the right end they come as close as the gap, by increments a step or more apart: each drifts its own
    way.

    Truth: The nearer span everywhere.

    Source: D. Hearn, M. P. Baker, Computer Graphics, depth-buffer method: z' = z - A/C
    """
    random = np.random.default_rng(0)
    end, gap = 0.5 * length, GAP * 2.0**-24
    corners = []
    for y in 0.5 * ROWS - 0.5 - np.arange(ROWS):
        left, right = random.uniform(0.5, 0.55), random.uniform(0.85, 0.9)
        apart = gap + random.uniform(1.0, 3.0) * length * 2.0**-24
        for a, b in ((left + apart, right + gap), (left, right)):
            corners.append([[-end, y - 0.4, -a], [end, y, -b], [-end, y + 0.4, -a]])
    return scene_of(parallel(ROWS, 0.0, 1.0), loose(corners))


HEIGHT = 16
SLOPE = 1.0 / 12.0
"""Of depth, in ranges a pixel."""
APART = 2.0**-20


@hard_case("depth", "distance from the left end, in pixels", octaves(4, 13), continuous=False)
@also(size=lambda away, _: (int(away) + HEIGHT, HEIGHT))
@variants(
    buffer("anchored", APART * 2.0**24 / SLOPE, "2^24 s / |dz/dx|, for a separation s", anchored=True),
    Variant("scanline-float32-direct", None, "anchored at the first sample of a span: 2^-24, less than s"),
)
def steep_far_triangle(away: float, _: int) -> Scene:
    """Put a triangle at the right end of a wide picture, and another behind it that comes first.

    A small steep triangle stands far from the left end of the picture. Evaluating its plane from there in
    float32 carries depth back over the whole way, to numbers much larger than any depth, and rounds it at
    their spacing. Anchored at one of its own corners the plane is as good as anywhere.

    Truth: The nearer of two parallel triangles.

    Source: Derived: 2^-24 |dz/dx| x, the rounding of what depth is at the left end
    """
    x = 0.5 * (away + HEIGHT) - 12.0
    across = np.array([[x, -6.1], [x + 8.0, -5.9], [x + 0.1, 6.5]])
    depth = 0.1 + SLOPE * (across[:, 0] - x)
    corners = [np.insert(across, 2, -depth - behind, axis=1) for behind in (APART, 0.0)]
    return scene_of(parallel(HEIGHT, 0.0, 1.0), loose(corners))
