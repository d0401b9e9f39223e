"""Why a picture shows nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hsr.algorithms.registry import render
from hsr.problem.view import CULL, Placement, View

NAMED = 3
"""How many objects are named that are not seen for one reason."""


def why_nothing(view: View, method: str) -> str:
    """Say of the objects of a view of which a method shows nothing why they are not seen.

    Parameters
    ----------
    view : View
    method : str
        It is asked again what it shows of the view with nothing culled.

    Returns
    -------
    str
        ``behind the eye: box; culled: floor, wall``; lengths in scene units.
    """
    bare = replace(view, placements=tuple(replace(p, cull=CULL["none"]) for p in view.placements))
    shown = bare.object_of(np.unique(render(bare, method).face))
    reasons: dict[str, list[str]] = {}
    for k, placement in enumerate(view.placements):
        otherwise = "culled" if k in shown else "edge-on, or between the samples"
        reasons.setdefault(_outside(view, placement) or otherwise, []).append(placement.name)
    return "; ".join(f"{reason}: {_named(names)}" for reason, names in reasons.items())


def _named(names: list[str]) -> str:
    more = f" and {len(names) - NAMED:,} more" if len(names) > NAMED else ""
    return ", ".join(names[:NAMED]) + more


def _outside(view: View, placement: Placement) -> str:
    """Say on which side of what is seen all of an object lies, if it does."""
    reach, matrix = placement.shape.solid.reach, placement.world_from_object
    least, greatest = reach(view.depth_row @ matrix)
    if greatest <= 0.0 and view.perspective:
        return "behind the eye"
    if greatest < view.near:
        return f"nearer than the near plane ({view.near:g})"
    if least > view.far:
        return f"beyond the far plane ({view.far:g})"
    x, y, _, w = view.clip_from_world @ matrix
    return "beside the window" if min(reach(w + side)[1] for side in (x, -x, y, -y)) < 0.0 else ""
