"""A mesh of ever smaller triangles, in the end many to a sample."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import mesh, parallel, powers_of_two, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.scene.model import Scene


def scene(pitch: float, side: int) -> Scene:
    """Cover half the picture's width by a wavy mesh, its corners moved at random by a quarter pitch."""
    count = max(3, round(0.5 * side / pitch) + 1)
    random = np.random.default_rng(count)
    line = np.linspace(-0.25 * side, 0.25 * side, count)
    x, y = np.stack(np.meshgrid(line, line)) + random.uniform(-0.25, 0.25, (2, count, count)) * (
        line[1] - line[0]
    )
    z = -1.0 + 0.1 * np.sin(0.3 * x) * np.cos(0.2 * y)
    a = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    triangles = [np.stack([a, a + 1, a + count + 1], 1), np.stack([a, a + count + 1, a + count], 1)]
    vertices = np.stack([x, y, z], axis=2).reshape(-1, 3)
    return scene_of(parallel(side), mesh(vertices, np.concatenate(triangles), cull="back"))


def first_wrong(bits: int, side: int) -> float:
    """Return the pitch at which snapping is expected to cost the first sample.

    There are ``2 + sqrt(2)`` pixels of edge to a square of a pixel over the pitch, each moved by ``2^-(b+2)``
    on average, over a quarter of the picture's ``W^2`` samples.
    """
    return side * side / 4.0 * 3.4 * 2.0 ** -(bits + 2)


def snaps(name: str, bits: int) -> Variant:
    """Return a variant that snaps; the factor is large, as where one sample is expected is left to chance."""
    return Variant(name, lambda side: first_wrong(bits, side), "0.85 W^2 2^-(b+2) px", 4.0)


FAMILY = Family(
    name="sub-pixel-mesh",
    group="coverage",
    story=(
        "A wavy mesh is divided ever more finely, until there are many triangles to a sample. Every sample "
        "within its outline has exactly one owner. Snapping moves shared corners for all their triangles at "
        "once, so no hole opens; but the shorter the edges, the more of them there are to pass over a "
        "sample."
    ),
    expected="One triangle of the mesh at every sample within its outline.",
    source="The OpenGL Graphics System, 3.6.1: polygons that share an edge produce each fragment once",
    parameter="pitch of the mesh, in pixels",
    sweep=powers_of_two(4, -2),
    scene=scene,
    variants=(
        Variant("scanline-snap-4", 16.0, "0.85 W^2 2^-(b+2) px, beyond the start of the sweep"),
        snaps("scanline-snap-8", 8),
        snaps("opengl", 8),
        Variant("scanline-direct", None, "0.85 W^2 2^-(b+2) px with b = 45: beyond the end"),
    ),
)
