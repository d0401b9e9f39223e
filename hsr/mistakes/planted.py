"""Classic mistakes of renderers, made on purpose: a test that lets one pass tests too little.

Some are planted in a small renderer. Others are of what a renderer is told: it draws another view than the
one it was given, and rightly so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from hsr.algorithms.registry import render
from hsr.base.arrays import Ints
from hsr.mistakes.renderers import Buffer, levels, window
from hsr.problem.geometry import CULL
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View

MISTAKES = {
    "pixel corner instead of centre": Buffer(centre=(0.0, 0.0)),
    "lower pixel corner instead of centre": Buffer(centre=(1.0, 0.0)),
    "inclusive edges": Buffer(inclusive=True),
    "<= for <": Buffer(later_wins=True),
    "flipped y": Buffer(upside_down=True),
    "no near clip": Buffer(near_clip=False),
    "z not divided": Buffer(divided=False),
    "truncating snap": Buffer(grid=16.0),
    "inverted culling": Buffer(swapped=True),
    "unnormalised t": Buffer(unscaled=True),
    "16-bit depth": Buffer(stored=levels(16, window)),
    "first instead of nearest hit": Buffer(nearest=False),
    "> for <": Buffer(stored=lambda _, d: -d),
    "truncated bounding box": Buffer(short_box=True),
}
"""A depth buffer for each mistake, by what people call it."""


@lru_cache(maxsize=len(MISTAKES) + 1)
def _planted(buffer: Buffer, seen: View) -> VisibilityMap:
    return buffer.render(seen.tessellated(), "")


def planted(mistake: str, shown: VisibilityMap, seen: View) -> VisibilityMap:
    """Return a map as it would be if its renderer made a mistake.

    Parameters
    ----------
    mistake : str
        A key of ``MISTAKES``.
    shown : VisibilityMap
        Of the view ``seen``.
    seen : View

    Returns
    -------
    VisibilityMap
        Changed where a small renderer shows another face with the mistake than without it.
    """
    right, wrong = _planted(Buffer(), seen), _planted(MISTAKES[mistake], seen)
    changed = right.face != wrong.face
    face, depth = np.where(changed, wrong.face, shown.face), np.where(changed, wrong.depth, shown.depth)
    return replace(shown, face=face, depth=depth)


# ---------------------------------------------------------------- another view


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
