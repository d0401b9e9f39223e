"""Wedges at different depths whose edges all pass through one point of the picture."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import central, mesh, powers_of_two, scene_of, wall
from hsr.lab.stability.family import Family
from hsr.lab.stability.rounding import on_screen, snapped
from hsr.scene.model import Scene

DIRECTIONS = ((4, 1), (1, 3), (-2, 3), (-3, 1), (-3, -2), (-1, -4), (1, -3), (3, -2))


def scene(width: float, side: int) -> Scene:
    """Point wedges, so wide at their ends, at one sample, each about a line of samples and at its depth."""
    corners = []
    for k, (x, y) in enumerate(DIRECTIONS):
        # Samples on the line lie at whole multiples of the direction; end between two of them.
        reach = np.floor(0.45 * side / np.hypot(x, y)) + 0.5
        end = reach * np.array([x, y])
        aside = 0.5 * width / np.hypot(x, y) * np.array([-y, x])
        across = np.array([[0.0, 0.0], end - aside, end + aside]) + 0.5
        corners.append((2.0 + 0.125 * k) * np.insert(across * (2.0 / side), 2, -1.0, axis=1))
    vertices = np.concatenate(corners)
    wedges = mesh(vertices, np.arange(len(vertices)).reshape(-1, 3))
    return scene_of(central(0.5), wedges, wall(4.0, 8.0))


FAMILY = Family(
    name="concurrent-edges",
    group="order",
    story=(
        "Eight thin wedges at different depths point at one sample, so that sixteen edges meet in one point "
        "of the picture. Each wedge holds samples along its middle, out to its end. Rounding corners closes "
        "a wedge once it is narrower than the grid; in float32 it closes at its first sample, where it is "
        "about a seventh as wide as at its end."
    ),
    expected="The wedge at the samples of its middle line, the wall elsewhere.",
    source=(
        "M. Attene, Indirect Predicates for Geometric Constructions (2020): do not round what is constructed"
    ),
    parameter="width of the wedges at their ends, in pixels",
    sweep=powers_of_two(-3, -31, 2),
    scene=scene,
    variants=(*snapped(2.0), *on_screen(8.0)),
)
