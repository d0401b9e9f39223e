"""Tips of triangles that reach just beyond samples, over the edges of walls behind them."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import central, mesh, powers_of_two, rectangle, scene_of, wall
from hsr.lab.stability.family import Family
from hsr.lab.stability.rounding import on_screen, snapped
from hsr.scene.model import Scene


def scene(beyond: float, side: int) -> Scene:
    """Point triangles from the left at a column of samples, and end a wall behind them at the same column."""
    y = np.arange(2, side - 2, 4) + 0.5 - 0.5 * side
    x = np.full_like(y, 0.5)
    tips = (
        np.stack([[x + beyond, y], [x - 3.0, y + 1.5], [x - 3.0, y - 1.5]]).transpose(2, 0, 1).reshape(-1, 2)
    )
    near = 2.0 * np.insert(tips * (2.0 / side), 2, -1.0, axis=1)
    edge = 3.0 * (0.5 - beyond) * 2.0 / side
    return scene_of(
        central(0.5),
        mesh(near, np.arange(len(near)).reshape(-1, 3)),
        rectangle((edge, 6.0), (-6.0, 6.0), 3.0),
        wall(4.0, 8.0),
    )


FAMILY = Family(
    name="vertex-on-edge",
    group="coverage",
    story=(
        "Tips of triangles end at a column of samples, at which the edge of a wall behind them ends as "
        "well: seen from the eye, corners lie on an edge. Each tip reaches beyond its sample by a little, "
        "and owns it. Rounded to a grid the tip ends on the sample, which then belongs to what is behind."
    ),
    expected="The triangles at the samples of their tips.",
    source="The lab's rule of ties: the limit from the right and below",
    parameter="how far tips reach beyond samples, in pixels",
    sweep=powers_of_two(-1, -33, 2),
    scene=scene,
    variants=(*snapped(), *on_screen()),
)
