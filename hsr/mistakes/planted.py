"""Classic mistakes of renderers, planted on purpose: a test that lets one pass tests too little."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from hsr.mistakes.renderers import Buffer, levels, window
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
def _drawn(buffer: Buffer, seen: View) -> VisibilityMap:
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
    right, wrong = _drawn(Buffer(), seen), _drawn(MISTAKES[mistake], seen)
    changed = right.face != wrong.face
    face, depth = np.where(changed, wrong.face, shown.face), np.where(changed, wrong.depth, shown.depth)
    return replace(shown, face=face, depth=depth)
