"""Resolution of depth formats against distance: pairs of squares that are ever closer."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from hsr.base.arrays import Bools, Floats
from hsr.lab.stability import theory
from hsr.lab.stability.building import central, quads, scene_of
from hsr.lab.stability.family import Trial, Variant, also, buffer, hard_case, octaves, variants
from hsr.mistakes.renderers import Buffer, distance, levels, logarithm, minifloat, receding, through_ndc
from hsr.scene.model import Scene

NEAR, FAR = 1.0, 16385.0
COLUMNS, ROWS = 64, 4
FARTHEST = 1.0 + (ROWS - 1) / 64
"""Depth of the last row's pairs, over the distance."""

Curve = Callable[[float], float]
"""What theory says is resolved at a distance."""


def separations(at: float) -> Floats:
    """Return the separation (W,) of the pairs in every column: 36 octaves, down from twice the distance."""
    return np.asarray(at * np.exp2(1.0 - np.arange(COLUMNS) * (36.0 / COLUMNS)))


def resolution(trial: Trial, wrong: Bools) -> float:
    """Return the largest separation of a pair that is not told apart, 0 if all are."""
    return float((separations(trial.value) * wrong.any(axis=0)).max())


def of(curve: Callable[..., float], *bits: int, **keys: Any) -> Curve:
    """Return the resolution of a format at the farthest pair of a view."""
    return lambda at: curve(*bits, FARTHEST * at, NEAR, FAR, **keys)


def spacing(at: float) -> float:
    """Return the spacing of float32 at the farthest pair of a view."""
    return theory.spacing(FARTHEST * at)


def resolved(name: str, because: str, curve: Curve, **how: Any) -> Variant:
    """Return a variant by what it resolves.

    A view has four pairs a separation, separations 1.5 apart: few meet the worst place between levels. Hence
    the factor.
    """
    return Variant(name, because=because, factor=3.0, curve=curve, **how)


def scanned(name: str, kept: str, because: str, curve: Curve) -> Variant:
    """Return scan conversion with a depth format."""
    return resolved(name, because, curve, method="scanline-direct", options={"depth_format": kept})


def plain(name: str, stored: Any, because: str, curve: Curve) -> Variant:
    """Return a format that only the plain buffer has."""
    return resolved(name, because, curve, mistake=Buffer(stored=stored))


def driven(name: str, kept: str, because: str, curve: Curve) -> Variant:
    """Return the driver with a depth format.

    It rounds corners to float32 before anything else, and depth again while it interpolates it, before what
    is stored is: hence the excess.
    """
    how = {"method": "opengl", "options": {"depth_format": kept}, "excess": 2.0}
    return resolved(name, because, lambda at: max(curve(at), spacing(at)), **how)


CROSSINGS = {
    "D24 no worse than D32F": 2.0 * NEAR,
    "log better than D16": NEAR * math.log(FAR / NEAR),
    "W16, W24 better than D16, D24": math.sqrt(NEAR * FAR),
    "W24 better than D32F reversed": 0.5 * (FAR - NEAR),
}
"""Where resolutions cross: 2 near, near ln(far / near), the mean of near and far on both scales."""

D16, D24 = of(theory.integers, 16), of(theory.integers, 24)
WINDOW, REVERSED = of(theory.float_window), of(theory.float_reversed)
THROUGH_NDC = of(theory.reversed_through_ndc)
HALF = of(theory.float_reversed, mantissa=10, least=-24)
FOUR = of(theory.float_reversed, mantissa=12, least=-18)


@hard_case("depth", "distance from the eye, in units of the near distance", octaves(0, 13))
@also(size=lambda *_: (COLUMNS, ROWS), marked=CROSSINGS)
@also(figure=resolution, figure_name="largest separation that is not resolved")
@variants(
    scanned("D16", "d16", "q d^2 / near", D16),
    scanned("D24", "d24", "q d^2 / near", D24),
    scanned("D32F", "d32f", "2^-24 d^2 / near: that of D24", WINDOW),
    scanned("D32F reversed", "d32f-reversed", "2^-23 d at most", REVERSED),
    scanned("W16", "w16", "q (far - near)", of(theory.linear, 16)),
    scanned("W24", "w24", "q (far - near)", of(theory.linear, 24)),
    scanned("1/w float32", "1/w", "2^-23 d at most", of(theory.reciprocal)),
    plain("D16 reversed", levels(16, receding), "that of D16", D16),
    plain("D32F reversed in [-1, 1]", through_ndc, "2^-25 d^2 / near", THROUGH_NDC),
    plain("log, 16 bits", levels(16, logarithm), "q d ln(far / near)", of(theory.logarithmic, 16)),
    plain("half float reversed", minifloat(5, 10), "2^-10 d at most, then 2^-24 d^2 / near", HALF),
    plain("16 bits, 4 of them exponent", minifloat(4, 12), "2^-12 d at most, then 2^-18 d^2 / near", FOUR),
    plain("ray t, float32", distance(np.float32), "2^-23 d at most", spacing),
    Variant("scanline-direct", None, "float64 resolves 2^-53 d^2 / near: less than any pair is apart"),
    buffer("ray t, float64", None, "2^-52 d: less than any pair is apart", stored=distance(np.float64)),
    driven("opengl", "d24", "q d^2 / near", D24),
    driven("opengl D16", "d16", "q d^2 / near", D16),
    driven("opengl D32F", "d32f", "2^-24 d^2 / near, or 2^-23 d: float32 corners", WINDOW),
    driven("opengl D32F reversed", "d32f-reversed", "2^-23 d at most", REVERSED),
    driven("opengl D32F reversed in [-1, 1]", "d32f-reversed-ndc", "2^-25 d^2 / near", THROUGH_NDC),
    resolved("embree", "2^-23 d: float32 corners", spacing, excess=2.0),
)
def parallel_pair(at: float, _: int) -> Scene:
    """Put a pair at every sample, the farther square first; each row lies a little farther away.

    Two squares face the eye, the nearer one drawn second. A depth buffer tells them apart if their stored
    depths differ, so what it resolves is the spacing of its numbers divided by the slope of what it stores.
    Standard window depth loses two digits for every tenfold distance, as integers and as floats; reversed
    floats, 1/w and logarithms lose one, and linear depth none. D24 and D32F part at twice the near distance,
    D16 and W16 cross where d^2 = near far, W24 passes reversed floats at half the far one.

    Truth: The nearer square of every pair.

    Source: E. Lapidous, G. Jiao, Optimal Depth Buffer for Low-Cost Graphics Hardware (1999); N. Reed, Depth
    Precision Visualized (2015); J. Blinn, W Pleasure, W Fun (1998)
    """
    row, column = np.mgrid[:ROWS, :COLUMNS].reshape(2, -1)
    near = at * (1.0 + row / 64)
    depth = np.stack([near + separations(at)[column], near], axis=1).ravel()
    middle = np.stack([(2 * column + 1) / COLUMNS - 1, 1 - (2 * row + 1) / ROWS], axis=1).repeat(2, axis=0)
    around = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) / [COLUMNS, ROWS]
    across = (middle[:, None] + around) * depth[:, None, None]
    return scene_of(central(NEAR, FAR), quads(np.insert(across, 2, -depth[:, None], axis=2)))
