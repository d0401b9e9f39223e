"""Which one mistake makes a picture wrong: each is undone, or made on purpose, and what then differs counted.

A sample differs if it shows another face than expected, no tie, which no model explains as rounding. A
mistake fits if less than a quarter as many differ without it.
"""

from __future__ import annotations

from collections.abc import Iterator
from statistics import mode
from typing import NamedTuple

import numpy as np

from hsr.algorithms import exact
from hsr.base.arrays import Bools, Ints
from hsr.base.errors import MapError
from hsr.difference.cause import explained
from hsr.mistakes.planted import MISREAD, MISTAKES, drawn, planted
from hsr.models.stages import Cause
from hsr.problem.map import BACKGROUND, VisibilityMap
from hsr.problem.view import View

MAX_TRIANGLES = 500
"""In how large a view mistakes are planted in a slow renderer: a second or two."""

UNKNOWN = BACKGROUND - 1
"""In place of a face where undoing a mistake does not tell it."""

PLANTED = [mistake for mistake in MISTAKES if mistake not in (*MISREAD, "flipped y")]
"""Those of them that are found in no quicker way."""


class Diagnosis(NamedTuple):
    """A mistake that accounts for most of what differs.

    Attributes
    ----------
    mistake : str
        What was done wrong: ``"shifted by (1, 0)"``, columns to the right and rows down.
    differing : int
        Samples that differ.
    explained : int
        Those of them that differ no more once it is undone; or that show what it makes a renderer show.
    left : int
        Samples that differ then, whether they did before or not; those that a shift has carried out of the
        picture go on differing.
    """

    mistake: str
    differing: int
    explained: int
    left: int

    def __str__(self) -> str:
        counted = f"explains {self.explained:,} of the {self.differing:,} samples that differ"
        return f"{self.mistake}: {counted}; without it {self.left:,} would"


def diagnose(
    shown: VisibilityMap, expected: VisibilityMap | View, view: View | None = None
) -> tuple[Diagnosis, ...]:
    """Name the one mistake that makes a picture wrong.

    Shifts, flips, and ids that are counted otherwise are found by undoing them. With the view these are found
    by making them: what a renderer misreads (culling, near and far, the centre of a pixel),
    its rule for ties, and, up to 500 triangles, the classic mistakes of depth buffers.

    Parameters
    ----------
    shown : VisibilityMap
        The picture; best with its model (:func:`hsr.testing.modelled`), which tells rounding from mistakes.
    expected : VisibilityMap or View
        What it should show, where a tie that is known is no difference; or the view, for the exact map.
    view : View, optional
        What both maps show.

    Returns
    -------
    tuple of Diagnosis
        Those that leave fewest samples, several only if they leave the same; empty if none fits, as of a
        picture that is right or rounded.

    Raises
    ------
    MapError
        If the maps differ in size.

    Examples
    --------
    >>> import hsr, numpy as np
    >>> view = hsr.view(hsr.load("scenes/cube.toml"), size=(32, 24))
    >>> ids = np.roll(hsr.render(view, "zbuffer").face, 1, axis=1)
    >>> for found in hsr.diagnose(hsr.testing.from_ids(ids), view):
    ...     print(found)
    shifted by (1, 0): explains 66 of the 66 samples that differ; without it 0 would
    """
    if isinstance(expected, View):
        view = expected
        expected = exact.render(view, exact.Options())
    if shown.face.shape != expected.face.shape:
        raise MapError(f"cannot diagnose {shown.method} by {expected.method}: their sizes differ")
    rounded = _rounded(shown, expected, view)
    differs = ~expected.admits(shown.face) & ~rounded
    if not differs.any():
        return ()
    found = []
    for mistake, face in _undone(shown.face, expected.face, view):
        after = np.where(face == UNKNOWN, differs, ~expected.admits(face))
        found.append(_diagnosis(mistake, differs, after & ~rounded))
    if view is not None and min(one.left for one in found):
        right = drawn(view)
        for mistake, wrong in _made(right, view):
            after = np.where(wrong != right, wrong != shown.face, differs)
            found.append(_diagnosis(mistake, differs, after & ~rounded))
    fewest = min(one.left for one in found)
    return tuple(one for one in found if one.left == fewest and 4 * fewest < one.differing)


def _rounded(shown: VisibilityMap, expected: VisibilityMap, view: View | None) -> Bools:
    """Tell which samples a model explains: that of the picture, or the best of the candidates."""
    why = None
    if view is not None:
        truth = expected if expected.admissible is not None else exact.render(view, exact.Options())
        why = explained(view, shown, truth)[1]
    return np.isin(0 if why is None else why.cause, (Cause.NONE, Cause.UNEXPLAINED), invert=True)


def _diagnosis(mistake: str, before: Bools, after: Bools) -> Diagnosis:
    """Count what differs before and after a mistake is undone."""
    count, left = int(np.count_nonzero(before)), int(np.count_nonzero(after))
    return Diagnosis(mistake, count, int(np.count_nonzero(before & ~after)), left)


# ---------------------------------------------------------------- hypotheses


def _undone(face: Ints, expected: Ints, view: View | None) -> Iterator[tuple[str, Ints]]:
    """Yield mistakes that can be undone in the picture, and the faces (H, W) without them."""
    from scipy import ndimage  # slow to import

    yield "turned upside down", face[::-1]
    yield "mirrored left to right", face[:, ::-1]
    yield "turned by 180 degrees", face[::-1, ::-1]
    for right, down in _shifts(face, expected):
        yield f"shifted by ({right}, {down})", ndimage.shift(face, (-down, -right), order=0, cval=UNKNOWN)
    covered = face != BACKGROUND
    apart = (face - expected)[covered & (expected != BACKGROUND)].tolist()
    for offset in {mode([*apart, 0]), 1, -1} - {0}:
        way = "high" if offset > 0 else "low"
        # What was below 0 looks like the background.
        uncovered = np.where(expected < -offset, expected, BACKGROUND)
        yield f"ids {abs(offset)} too {way}", np.where(covered, face - offset, uncovered)
    owner = None if view is None else view.tessellated().triangle_face
    if owner is not None and face.max() < len(owner):
        yield "triangles' numbers taken for faces", np.where(covered, owner[face], BACKGROUND)


def _shifts(face: Ints, expected: Ints) -> set[tuple[int, int]]:
    """Return the shifts, to the right and down, at which two pictures agree best, and those by one pixel."""
    from skimage.registration import phase_cross_correlation  # slow to import

    # Random levels in place of ids: faces of neighbouring ids are as unlike as any others.
    ids, number = np.unique([face, expected], return_inverse=True)
    pictures = np.random.default_rng(0).random(len(ids))[number].reshape(2, *face.shape)
    found = {(right, down) for right in (-1, 0, 1) for down in (-1, 0, 1)}
    for normalization in ("phase", None):
        shift = phase_cross_correlation(*pictures, normalization=normalization)[0]
        found.add((int(shift[1]), int(shift[0])))
    return found - {(0, 0)}


def _made(right: Ints, view: View) -> Iterator[tuple[str, Ints]]:
    """Yield mistakes, and the faces (H, W) that renderers show which make them and are right otherwise."""
    yield from ((mistake, wrong(view)) for mistake, wrong in MISREAD.items())
    if len(view.tessellated().triangle_face) <= MAX_TRIANGLES:
        base = VisibilityMap(right, np.zeros(right.shape), "")
        yield from ((mistake, planted(mistake, base, view).face) for mistake in PLANTED)
