"""Shaded pictures compared by how they look: a second check, weaker than any by face id.

Two faces may be painted alike, and one face in two colours: a picture says little about visibility.
"""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Pixels
from hsr.base.errors import CheckError

MIN_SIMILARITY = 0.99

WINDOW = 7
"""Side of the window of structural similarity, in pixels."""

WEAKER = "weaker check: it compares colours, and overlooks a wrong face that is painted alike"


def compared(picture: Pixels, reference: Pixels, min_similarity: float) -> tuple[bool, str]:
    """Compare two shaded pictures; see :func:`hsr.testing.assert_similar`.

    Returns
    -------
    bool, str
        Whether they are alike enough, by their mean structural similarity (Wang, Bovik, Sheikh,
        Simoncelli 2004); and the judgement as lines for people.
    """
    from skimage.metrics import structural_similarity  # on first use: it takes a second to import

    picture, reference = np.asarray(picture), np.asarray(reference)
    if picture.shape != reference.shape or picture.dtype != np.uint8 or reference.dtype != np.uint8:
        raise CheckError(
            f"pictures must be uint8 arrays of one shape, not {picture.dtype} {picture.shape} and "
            f"{reference.dtype} {reference.shape}"
        )
    if picture.ndim not in (2, 3) or min(picture.shape[:2]) < WINDOW:
        raise CheckError(f"pictures must be (H, W) or (H, W, 3), {WINDOW} pixels or more a side")
    axis = None if picture.ndim == 2 else -1
    alike = structural_similarity(picture, reference, win_size=WINDOW, channel_axis=axis)
    other = (picture != reference).reshape(*picture.shape[:2], -1).any(axis=-1)
    text = (
        f"pictures: similarity {alike:.6g}, at least {min_similarity:g} demanded, "
        f"{np.count_nonzero(other)} pixels of another colour\n  {WEAKER}"
    )
    return bool(alike >= min_similarity), text
