"""Edges on the samples: a net of triangles whose corners come ever closer to them."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import mesh, parallel, powers_of_two, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.lab.stability.rounding import on_screen, snapped
from hsr.mistakes.renderers import Buffer
from hsr.scene.model import Scene

PITCH = 8
"""Pixels from one line of the net to the next."""

EPSILON = 2.0**-17


def net(side: int, offset: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (V, 2), in pixels, and triangles (n, 3) of a net that covers the picture.

    Every corner lies at a sample, but for the offset.
    """
    count = side // PITCH + 3
    line = (np.arange(count) - 1) * PITCH + 0.5 - 0.5 * side
    x, y = np.meshgrid(line + offset[0], line + offset[1])
    a = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    triangles = [np.stack([a, a + 1, a + count + 1], 1), np.stack([a, a + count + 1, a + count], 1)]
    return np.stack([x.ravel(), y.ravel()], 1), np.concatenate(triangles)


def scene(offset: float, side: int) -> Scene:
    """Cover the picture by a flat net, its corners right of and above samples."""
    vertices, triangles = net(side, (offset, 2.0 * offset))
    return scene_of(parallel(side), mesh(np.insert(vertices, 2, -1.0, axis=1), triangles))


FAMILY = Family(
    name="lattice-edges",
    group="coverage",
    story=(
        "A flat net of triangles has its corners ever closer to samples. However close, each sample has one "
        "owner, and at the sample itself the rule of top and left edges names it. Whoever rounds corners to "
        "a grid moves them onto the samples or past them; whoever widens edges by an epsilon lets two "
        "triangles own what lies within it, and the one drawn first keeps it."
    ),
    expected="The triangle to the left of and below each corner.",
    source=(
        "J. Foley, A. van Dam, S. Feiner, J. Hughes, Computer Graphics: Principles and Practice, 3.6: who "
        "owns the pixels on an edge"
    ),
    parameter="distance of corners from samples, in pixels",
    sweep=powers_of_two(-1, -43, 2),
    scene=scene,
    variants=(
        *snapped(),
        *on_screen(),
        Variant(
            "epsilon",
            0.5 * EPSILON,
            "epsilon / 2: level edges are widened by 2^-17 px, and twice as far from samples",
            mistake=Buffer(epsilon=EPSILON),
        ),
    ),
)
