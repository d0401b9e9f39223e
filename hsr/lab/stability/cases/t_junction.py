"""T-junctions: a corner in the middle of a neighbour's edge."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import mesh, parallel, powers_of_two, scene_of
from hsr.lab.stability.family import Family
from hsr.lab.stability.rounding import on_screen, snapped
from hsr.scene.model import Scene

ALONG = np.array([3.0, 1.0])
"""Direction of the edges, from sample to sample."""


def scene(grid: float, side: int) -> Scene:
    """Divide many small squares by an edge on samples, one neighbour having a corner in the middle of it.

    All corners are multiples of ``grid`` along the edge, so that they lie on it exactly.
    """
    random = np.random.default_rng(0)
    first = np.mgrid[4 : side - 8 : 12, 4 : side - 4 : 8].reshape(2, -1).T + 0.5 - 0.5 * side
    away = grid * (2 * random.integers(0, max(1, round(0.25 / grid)), (len(first), 3, 1)) + 1)
    a, t, b = (first + (s * away[:, k] + place) * ALONG for k, s, place in ((0, -1, 0), (1, 1, 1), (2, 1, 2)))
    above, below = first + np.array([2.0, 4.0]), first + np.array([4.0, -3.0])
    corners = np.stack([a, b, t, above, below], axis=1).reshape(-1, 2)
    triangles = np.array([[1, 0, 4], [0, 2, 3], [2, 1, 3]]) + 5 * np.arange(len(first))[:, None, None]
    return scene_of(parallel(side), mesh(np.insert(corners, 2, -1.0, axis=1), triangles.reshape(-1, 3)))


FAMILY = Family(
    name="t-junction",
    group="coverage",
    story=(
        "On one side of an edge lies one triangle, on the other side lie two, which meet in a corner on the "
        "edge. All corners lie on it exactly, and so do samples. While the grid of a rasteriser holds the "
        "corners, nothing happens; with one bit more the three corners are rounded apart, and the "
        "background shines through the crack at samples on the edge."
    ),
    expected="A triangle at every sample of the edge, whichever of those that meet there.",
    source=(
        "The OpenGL Graphics System, appendix on corollaries: no promise holds where edges do not share "
        "corners"
    ),
    parameter="grid that holds the corners, in pixels",
    sweep=powers_of_two(-2, -28, 2),
    continuous=False,
    scene=scene,
    variants=(*snapped(), *on_screen()),
)
