"""Parallel triangles of any orientation, ever closer: the least separation that is always told apart."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from hsr.base.arrays import Bools, Floats
from hsr.lab.stability import theory
from hsr.lab.stability.building import central, loose, scene_of
from hsr.lab.stability.family import Trial, Variant, also, hard_case, octaves, variants
from hsr.scene.model import Scene

NEAR, FAR, DEPTH = 1.0, 65537.0, 512.0
SIZE = 0.3
"""Radius of the triangles over their depth."""
BEGIN = 0.5
"""The part of the bound at which failures begin: as found, for 16 pairs are seldom near the worst plane."""
BITS = 8
"""Of the snapping grid whose least separation is the unit."""


def least(side: int, triangle: Floats, bits: int = BITS, depth_bits: int = 24) -> float:
    """Return the least separation that is told apart at every corner (x, y, -depth) of a triangle (3, 3)."""
    found = []
    for x, y, z in triangle.tolist():
        dz = theory.integers(depth_bits, -z, NEAR, FAR)
        found.append(theory.separation(dz, -z, math.hypot(x, y) / -z, bits, 2.0 / side))
    return max(found)


def nearer_triangles() -> Iterator[tuple[Floats, Floats, Floats]]:
    """Yield 4 x 4 triangles (3, 3), each with its normal (3,) and its corners (3, 3) from its middle."""
    random = np.random.default_rng(1)
    for x, y in (np.mgrid[-0.75:1.0:0.5, -0.75:1.0:0.5]).reshape(2, -1).T:
        ray = np.array([x, y, -1.0])
        normal = ray + random.normal(0.0, 0.8, 3)
        normal *= np.sign(normal @ ray) / np.linalg.norm(normal)
        across = np.linalg.svd(normal[None])[2][1:]
        angle = random.uniform(0.0, 2.0 * np.pi) + np.array([0.0, 2.0, 4.0]) * (np.pi / 3.0)
        around = SIZE * DEPTH * np.stack([np.cos(angle), np.sin(angle)], axis=1) @ across
        yield DEPTH * ray + around, normal, around


def swapped(trial: Trial) -> Bools:
    """Count where the farther triangle of a pair is shown in place of the nearer."""
    nearer = trial.truth.face % 2 == 1
    return np.asarray(nearer & (trial.answer.face == trial.truth.face - 1))


def failure_rate(trial: Trial, wrong: Bools) -> float:
    """Return the part of the samples with a nearer triangle that show the farther one."""
    return float(wrong.sum() / (trial.truth.face % 2 == 1).sum())


def unit_of(bits: int, depth_bits: int, side: int) -> float:
    """Return the least separation of another buffer in units of that of D24 with 8 bits, for all pairs."""
    found = [triangle for triangle, _, _ in nearer_triangles()]
    return max(least(side, triangle, bits, depth_bits) / least(side, triangle) for triangle in found)


def snapped(name: str, bits: int, depth_bits: int, because: str, **how: Any) -> Variant:
    """Return a scan conversion that snaps to so many bits and stores depth in so many."""
    unit = partial(unit_of, bits, depth_bits)
    return Variant(name, lambda side: BEGIN * unit(side), because, safe=unit, **how)


def snapping(bits: int, depth_bits: int) -> Variant:
    """Return the same by the direct variant, under a name that tells both."""
    told = "below S_min = sqrt(dz^2 + (sqrt(2) 2^-b p + dz tan a)^2), never at it"
    options = {"depth_format": f"d{depth_bits}", "subpixel_bits": bits}
    name = f"D{depth_bits}, {bits} bits"
    return snapped(name, bits, depth_bits, told, method="scanline-direct", options=options)


@hard_case(
    "depth", "separation, in units of the least one for D24 with 8 sub-pixel bits", octaves(6, -9, 0.5)
)
@also(wrong=swapped, marked={"S_min of D24 with 8 bits": 1.0})
@also(figure=failure_rate, figure_name="part of the samples that show the farther one")
@variants(
    snapping(4, 16),
    snapping(8, 16),
    snapping(4, 24),
    snapping(8, 24),
    snapped("scanline-d24", 40, 24, "below dz / cos a, never at it"),
    Variant("opengl", BEGIN, "as D24 with 8 bits; its depths come from unsnapped corners", safe=1.0),
)
def triangle_separation(part: float, side: int) -> Scene:
    """Put pairs of triangles into the picture; the farther, smaller one comes first.

    Pairs of parallel triangles lie in planes of any orientation. A depth buffer that snaps corners moves each
    plane, and a plane seen at a slant moves far along the line of sight: sub-pixel precision can matter more
    than the depth format. The closed form bounds both; below it failures begin, at it there are none.

    Truth: The nearer triangle wherever both are met.

    Source: K. Akeley, J. Su, Minimum Triangle Separation for Correct Z-Buffer Occlusion (2006); the formula
    is derived anew in theory.py
    """
    corners = []
    for triangle, normal, around in nearer_triangles():
        away = part * least(side, triangle) * normal
        corners += [triangle + away - 0.4 * around, triangle]
    return scene_of(central(NEAR, FAR), loose(corners))
