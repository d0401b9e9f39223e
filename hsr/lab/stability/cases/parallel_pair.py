"""Resolution of depth formats against distance: pairs of squares that are ever closer."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from hsr.base.arrays import Bools, Floats
from hsr.lab.stability import theory
from hsr.lab.stability.building import central, powers_of_two, quads, scene_of
from hsr.lab.stability.family import Case, Family, Variant
from hsr.mistakes.renderers import (
    Buffer,
    distance,
    levels_of_logarithm,
    levels_of_reversed,
    minifloat,
    reversed_through_ndc,
)
from hsr.scene.model import Scene

NEAR, FAR = 1.0, 16385.0
COLUMNS, ROWS = 64, 4
FARTHEST = 1.0 + (ROWS - 1) / 64
"""Depth of the last row's pairs, over the distance."""


def separations(at: float) -> Floats:
    """Return the separation (W,) of the pairs in every column: 36 octaves, down from twice the distance."""
    return np.asarray(at * np.exp2(1.0 - np.arange(COLUMNS) * (36.0 / COLUMNS)))


def scene(at: float, _: int) -> Scene:
    """Put a pair at every sample, the farther square first; each row lies a little farther away."""
    row, column = np.mgrid[:ROWS, :COLUMNS].reshape(2, -1)
    near = at * (1.0 + row / 64)
    depth = np.stack([near + separations(at)[column], near], axis=1).ravel()
    middle = np.stack([(2 * column + 1) / COLUMNS - 1, 1 - (2 * row + 1) / ROWS], axis=1).repeat(2, axis=0)
    around = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) / [COLUMNS, ROWS]
    across = (middle[:, None] + around) * depth[:, None, None]
    corners = np.insert(across, 2, -depth[:, None], axis=2)
    return scene_of(central(NEAR, FAR), quads(corners))


def resolution(case: Case, wrong: Bools) -> float:
    """Return the largest separation of a pair that is not told apart, 0 if all are."""
    return float((separations(case.value) * wrong.any(axis=0)).max())


def format_of(curve: Callable[..., float], *bits: int, **keys: Any) -> Callable[[float], float]:
    """Return the resolution of a format at the farthest pair of a view."""
    return lambda at: curve(*bits, FARTHEST * at, NEAR, FAR, **keys)


def of_the_driver(curve: Callable[..., float], *bits: int) -> Callable[[float], float]:
    """Return the same for a driver, which rounds corners to float32 before anything else."""
    return lambda at: max(curve(*bits, FARTHEST * at, NEAR, FAR), theory.spacing(FARTHEST * at))


LESS = 3.0
"""A view has four pairs a separation, separations 1.5 apart: few meet the worst place between levels."""

EXCESS = 2.0
"""Of libraries: they round corners, and depth again while they interpolate it, before what is stored is."""

FORMATS: tuple[tuple[str, dict[str, Any], Callable[[float], float], str], ...] = (
    ("D16", {"depth_format": "d16"}, format_of(theory.integers, 16), "q d^2 / near"),
    ("D24", {"depth_format": "d24"}, format_of(theory.integers, 24), "q d^2 / near"),
    ("D32F", {"depth_format": "d32f"}, format_of(theory.float_window), "2^-24 d^2 / near: that of D24"),
    ("D32F reversed", {"depth_format": "d32f-reversed"}, format_of(theory.float_reversed), "2^-23 d at most"),
    ("W16", {"depth_format": "w16"}, format_of(theory.linear, 16), "q (far - near)"),
    ("W24", {"depth_format": "w24"}, format_of(theory.linear, 24), "q (far - near)"),
    ("1/w float32", {"depth_format": "1/w"}, lambda at: theory.reciprocal(FARTHEST * at), "2^-23 d at most"),
)
"""The formats of the scan conversion: name, options, resolution, and its formula."""

PLAIN: tuple[tuple[str, Any, Callable[[float], float], str], ...] = (
    ("D16 reversed", levels_of_reversed(16), format_of(theory.integers, 16), "that of D16"),
    (
        "D32F reversed in [-1, 1]",
        reversed_through_ndc,
        format_of(theory.reversed_through_ndc),
        "2^-25 d^2 / near",
    ),
    ("log, 16 bits", levels_of_logarithm(16), format_of(theory.logarithmic, 16), "q d ln(far / near)"),
    (
        "half float reversed",
        minifloat(5, 10),
        format_of(theory.float_reversed, mantissa=10, least=-24),
        "2^-10 d at most, then 2^-24 d^2 / near",
    ),
    (
        "16 bits, 4 of them exponent",
        minifloat(4, 12),
        format_of(theory.float_reversed, mantissa=12, least=-18),
        "2^-12 d at most, then 2^-18 d^2 / near",
    ),
    ("ray t, float32", distance(np.float32), lambda at: theory.spacing(FARTHEST * at), "2^-23 d at most"),
)
"""Formats that only the plain buffer has: name, what is stored, resolution, and its formula."""

DRIVEN: tuple[tuple[str, str, Callable[[float], float], str], ...] = (
    ("opengl", "d24", of_the_driver(theory.integers, 24), "q d^2 / near"),
    ("opengl D16", "d16", of_the_driver(theory.integers, 16), "q d^2 / near"),
    (
        "opengl D32F",
        "d32f",
        of_the_driver(theory.float_window),
        "2^-24 d^2 / near, or 2^-23 d: float32 corners",
    ),
    (
        "opengl D32F reversed",
        "d32f-reversed",
        of_the_driver(theory.float_reversed),
        "2^-23 d at most",
    ),
    (
        "opengl D32F reversed in [-1, 1]",
        "d32f-reversed-ndc",
        of_the_driver(theory.reversed_through_ndc),
        "2^-25 d^2 / near",
    ),
)
"""The formats of the driver: name, depth format, resolution, and its formula."""

CROSSINGS = {
    "D24 no worse than D32F": 2.0 * NEAR,
    "log better than D16": NEAR * math.log(FAR / NEAR),
    "W16, W24 better than D16, D24": math.sqrt(NEAR * FAR),
    "W24 better than D32F reversed": 0.5 * (FAR - NEAR),
}
"""Where resolutions cross: 2 near, near ln(far / near), the mean of near and far on both scales."""

FAMILY = Family(
    name="parallel-pair",
    group="depth",
    story=(
        "Two squares face the eye, the nearer one drawn second. A depth buffer tells them apart if their "
        "stored depths differ, so what it resolves is the spacing of its numbers divided by the slope of "
        "what it stores. Standard window depth loses two digits for every tenfold distance, as integers and "
        "as floats; reversed floats, 1/w and logarithms lose one, and linear depth none. D24 and D32F part "
        "at twice the near distance, D16 and W16 cross where d^2 = near far, W24 passes reversed floats at "
        "half the far one."
    ),
    expected="The nearer square of every pair.",
    source=(
        "E. Lapidous, G. Jiao, Optimal Depth Buffer for Low-Cost Graphics Hardware (1999); N. Reed, Depth "
        "Precision Visualized (2015); J. Blinn, W Pleasure, W Fun (1998)"
    ),
    parameter="distance from the eye, in units of the near distance",
    sweep=powers_of_two(0, 13),
    scene=scene,
    size=lambda *_: (COLUMNS, ROWS),
    figure=resolution,
    figure_name="largest separation that is not resolved",
    marked=CROSSINGS,
    variants=(
        *(
            Variant(
                name, because=because, factor=LESS, method="scanline-direct", options=options, curve=curve
            )
            for name, options, curve, because in FORMATS
        ),
        *(
            Variant(name, because=because, factor=LESS, mistake=Buffer(stored=stored), curve=curve)
            for name, stored, curve, because in PLAIN
        ),
        Variant("scanline-direct", None, "float64 resolves 2^-53 d^2 / near: less than any pair is apart"),
        Variant(
            "ray t, float64",
            None,
            "2^-52 d: less than any pair is apart",
            mistake=Buffer(stored=distance(np.float64)),
        ),
        *(
            Variant(
                name,
                because=because,
                factor=LESS,
                method="opengl",
                options={"depth_format": kept},
                curve=curve,
                excess=EXCESS,
            )
            for name, kept, curve, because in DRIVEN
        ),
        Variant(
            "embree",
            because="2^-23 d: float32 corners",
            factor=LESS,
            curve=lambda at: theory.spacing(FARTHEST * at),
            excess=EXCESS,
        ),
    ),
)
