"""A mesh that snapping folds over: a strip between two sheets, thinner than the grid."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import mesh, parallel, powers_of_two, scene_of
from hsr.lab.stability.family import Family
from hsr.lab.stability.rounding import on_screen, snapped
from hsr.scene.model import Scene


def scene(height: float, side: int) -> Scene:
    """Join two sheets by a strip about a line of samples, its borders zigzags of half its height.

    Diagonals cross the line half-way between samples, and so do the sides of the strip's triangles.
    """
    x = np.arange(-0.5 * side - 4.0, 0.5 * side + 5.0, 4.0)
    n, zigzag = len(x), 0.25 * height * (-1.0) ** np.arange(len(x))
    end = np.full(n, float(side))
    y = [-end, 0.5 - 0.5 * height + zigzag, 0.5 + 0.5 * height + zigzag, end]
    vertices = np.stack([np.tile(x, 4), np.concatenate(y), np.full(4 * n, -1.0)], axis=1)
    a = (n * np.arange(3)[:, None] + np.arange(n - 1)).ravel()
    triangles = [np.stack([a, a + 1, a + n + 1], 1), np.stack([a, a + n + 1, a + n], 1)]
    return scene_of(parallel(side), mesh(vertices, np.concatenate(triangles), cull="back"))


FAMILY = Family(
    name="fold-over",
    group="coverage",
    story=(
        "Two sheets are joined by a strip of triangles in which a line of samples lies, and all of it faces "
        "the eye. Once the strip is thinner than the grid, its borders are rounded past each other: its "
        "triangles turn over and are culled, or lose their area. No hole opens, for the sheets share the "
        "moved corners; but the samples go to the wrong faces."
    ),
    expected="The strip along its line of samples, the sheets above and below.",
    source="Microsoft, Direct3D 11.3 Functional Specification, 3.4.1: culling comes after snapping",
    parameter="height of the strip, in pixels",
    sweep=powers_of_two(0, -32, 2),
    scene=scene,
    variants=(*snapped(2.0), *on_screen(2.0)),
)
