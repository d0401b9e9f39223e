"""A corner that moves from before the eye to behind it."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import central, mesh, scene_of, wall
from hsr.lab.stability.family import Family, Variant
from hsr.mistakes.renderers import Buffer
from hsr.scene.model import Scene


def scene(behind: float, _: int) -> Scene:
    """Let six triangles before a wall share a corner that lies so far behind the plane of the eye."""
    angle = np.arange(6) * (np.pi / 3.0) + 0.1
    rim = np.stack([3.0 * np.cos(angle), 3.0 * np.sin(angle), np.full(6, -4.0)], axis=1)
    k = np.arange(6)
    vertices = np.concatenate([[[0.3, -1.2, behind]], rim])
    return scene_of(
        central(2.0**-6, None),
        mesh(vertices, np.stack([0 * k, k + 1, (k + 1) % 6 + 1], axis=1)),
        wall(8.0, 16.0),
    )


FAMILY = Family(
    name="behind-the-eye",
    group="coverage",
    story=(
        "Six triangles share a corner that moves through the plane of the eye. There its projection goes to "
        "infinity, and comes back from the other side: a divide without clipping turns the triangle inside "
        "out. Clipped, or tested by edges that need no divide, it runs off the picture in the right "
        "direction."
    ),
    expected="The part of each triangle that lies before the near plane.",
    source="M. Olano, T. Greer, Triangle Scan Conversion Using 2D Homogeneous Coordinates (1997)",
    parameter="distance of the corner behind the plane of the eye",
    sweep=(-2.0, -1.0, -0.5, -0.25, -0.125, -0.0625, 0.0, 0.0625, 0.125, 0.25, 0.5, 1.0, 2.0),
    scene=scene,
    variants=(
        Variant("no clipping", 0.0, "0: the divide by w < 0 mirrors the corner", mistake=Buffer()),
        Variant("scanline-direct", None, "clipped before the divide"),
    ),
)
