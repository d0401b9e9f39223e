"""Shaded pictures compared by how they look: a second check, weaker than any by face id.

Two faces may be painted alike, and one face in two colours: a picture says little about visibility.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr.base.arrays import Pixels
from hsr.base.errors import CheckError, UnavailableError

MIN_SIMILARITY = 0.99

WINDOW = 7
"""Side of the window of structural similarity, in pixels."""

WEAKER = "weaker check: it compares colours, and overlooks a wrong face that is painted alike"


@dataclass(frozen=True)
class Alike:
    """How alike two pictures are.

    Attributes
    ----------
    similarity : float
        Mean structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004), 1 for equal pictures.
    differing : int
        Pixels of another colour.
    min_similarity : float
        What is demanded.
    """

    similarity: float
    differing: int
    min_similarity: float

    @property
    def passed(self) -> bool:
        """Whether they are alike enough."""
        return self.similarity >= self.min_similarity

    @property
    def text(self) -> str:
        """The verdict as lines for people."""
        return (
            f"pictures: similarity {self.similarity:.6g}, at least {self.min_similarity:g} demanded, "
            f"{self.differing} pixels of another colour\n  {WEAKER}"
        )


def compared(picture: Pixels, reference: Pixels, min_similarity: float) -> Alike:
    """Compare two shaded pictures; see :func:`hsr.testing.assert_similar`."""
    try:
        from skimage.metrics import structural_similarity
    except ImportError as error:
        raise UnavailableError(
            f"pictures need scikit-image ({error}); pip install 'hsr-lab[pictures]'"
        ) from error
    picture, reference = np.asarray(picture), np.asarray(reference)
    if picture.shape != reference.shape or picture.dtype != np.uint8 or reference.dtype != np.uint8:
        raise CheckError(
            f"pictures must be uint8 arrays of one shape, not {picture.dtype} {picture.shape} and "
            f"{reference.dtype} {reference.shape}"
        )
    if picture.ndim not in (2, 3) or min(picture.shape[:2]) < WINDOW:
        raise CheckError(f"pictures must be (H, W) or (H, W, 3), {WINDOW} pixels or more a side")
    axis = None if picture.ndim == 2 else -1
    similarity = structural_similarity(picture, reference, win_size=WINDOW, channel_axis=axis)
    other = (picture != reference).reshape(*picture.shape[:2], -1).any(axis=-1)
    return Alike(float(similarity), int(np.count_nonzero(other)), min_similarity)
