"""Mistakes of what a renderer is told: it draws another view than the one it was given, and rightly so."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from hsr.algorithms.registry import render
from hsr.base.arrays import Ints
from hsr.problem.geometry import CULL
from hsr.problem.view import View


def drawn(view: View, **changed: Any) -> Ints:
    """Return the faces (H, W) of a view, fields of it replaced; curved shapes are tessellated."""
    return render(replace(view, **changed).tessellated(), "zbuffer").face


def moved(view: View, right: float, down: float) -> Ints:
    """Move the picture by so many pixels."""
    matrix = view.clip_from_world.copy()
    matrix[:2] += np.outer([2.0 * right / view.width, -2.0 * down / view.height], matrix[3])
    return drawn(view, clip_from_world=matrix)


def culled(view: View, side: str) -> Ints:
    """Cull the same side of every object."""
    return drawn(view, placements=tuple(replace(one, cull=CULL[side]) for one in view.placements))


def tied(view: View, right: int, down: int) -> Ints:
    """Decide ties in the limit from this direction: rightly (1, 1), as it is done in a mirrored picture."""
    matrix = view.clip_from_world * [[right], [down], [1], [1]]
    things = view.geometry.mirror_image if right * down < 0 else view.placements
    return drawn(view, clip_from_world=matrix, placements=things)[::down, ::right]


MISREAD: dict[str, Callable[[View], Ints]] = {
    "pixel corner instead of centre": lambda view: moved(view, 0.5, 0.5),
    "lower pixel corner instead of centre": lambda view: moved(view, 0.5, -0.5),
    "inverted culling": lambda view: drawn(view, placements=view.geometry.mirror_image),
    "front faces culled": lambda view: culled(view, "front"),
    "back faces culled": lambda view: culled(view, "back"),
    "nothing culled": lambda view: culled(view, "none"),
    "no near clip": lambda view: drawn(view, near=2.0**-20 * view.near),
    "no far clip": lambda view: drawn(view, far=np.inf),
    "ties to the bottom and left": lambda view: tied(view, 1, -1),
    "ties to the top and right": lambda view: tied(view, -1, 1),
    "ties to the bottom and right": lambda view: tied(view, -1, -1),
}
"""The faces (H, W) that are shown in place of those of a view, by what people call the mistake."""
