"""The checks as plain functions, for any test runner."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from hsr.base.arrays import Pixels
from hsr.base.errors import CheckError, VisibilityError
from hsr.problem.map import VisibilityMap
from hsr.testing.baselines import match
from hsr.testing.judging import Files, Judgement, Maps, Showing, judge, subject_of
from hsr.testing.limits import Limits, merged

CALLER = "caller"
"""Who sets the limits that are given to a function."""

MIN_SIMILARITY = 0.99

WINDOW = 7
"""Side of the window of structural similarity, in pixels."""

WEAKER = "weaker check: it compares colours, and overlooks a wrong face that is painted alike"


def agreement(
    maps: Maps, reference: VisibilityMap, limits: Limits, scene: Showing, camera: str | None
) -> list[Judgement]:
    """Judge every map against the reference; see :func:`assert_agree`."""
    if not maps:
        raise CheckError('nothing to compare: give maps by name, such as {"mine": map}')
    subject = subject_of(scene, camera, reference)
    return [judge(name, shown, reference, limits, subject) for name, shown in maps.items()]


def assert_agree(
    maps: Maps, reference: VisibilityMap, *, scene: Showing = None, camera: str | None = None, **limits: Any
) -> None:
    """Assert that maps show what a reference shows, by face id.

    Parameters
    ----------
    maps : mapping of str to VisibilityMap
        By the name under which a message speaks of them.
    reference : VisibilityMap
        Best the exact one, ``hsr.render(scene, "exact")``: then ties are never differences.
    scene : Scene, View, str or Path, optional
        What all of them show; makes the truth known, and with it ties and causes.
    camera : str, optional
        Name of the scene's camera, its first by default.
    **limits
        ``max_diff_pixels``, ``max_diff_ratio``, ``max_cluster``, ``max_in_window``, ``expect_diff``,
        ``depth_ulps``, ``allow``, and ``model`` with its parameters; see :class:`hsr.testing.limits.Limits`.
        Without any no sample may differ.

    Raises
    ------
    VisibilityError
        If a map breaks a limit; the message has a line for each cause.
    MapError
        If maps differ in size, scene or camera, so that comparing them means nothing.
    CheckError
        If a limit makes no sense.

    Examples
    --------
    >>> import hsr
    >>> scene = hsr.load("scenes/cube.toml")
    >>> truth = hsr.render(scene, "exact", size=(10, 8))
    >>> mine = hsr.render(scene, "scanline", size=(10, 8))
    >>> hsr.testing.assert_agree({"mine": mine}, truth, scene=scene)
    """
    found = agreement(maps, reference, merged([(CALLER, limits)]), scene, camera)
    failed = [_told(judgement) for judgement in found if not judgement.passed]
    if failed:
        raise VisibilityError("\n".join(failed))


def assert_same_visibility(
    a: VisibilityMap, b: VisibilityMap, *, scene: Showing = None, camera: str | None = None, **limits: Any
) -> None:
    """Assert that two maps show the same face at every sample.

    Parameters
    ----------
    a, b : VisibilityMap
        ``a`` is judged against ``b``.
    scene, camera, **limits
        As for :func:`assert_agree`.

    Raises
    ------
    VisibilityError
        If a limit is broken; the message has a line for each cause.
    MapError
        If the maps differ in size, scene or camera, so that comparing them means nothing.
    CheckError
        If a limit makes no sense.

    Examples
    --------
    >>> import numpy as np
    >>> from hsr.testing import assert_same_visibility, from_ids
    >>> one, other = from_ids(np.array([[0, 0, 1, 1]])), from_ids(np.array([[0, 1, 1, 1]]))
    >>> assert_same_visibility(one, other, max_diff_pixels=1)
    >>> assert_same_visibility(one, other)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    hsr.base.errors.VisibilityError: ...
    """
    assert_agree({a.method: a}, b, scene=scene, camera=camera, **limits)


def assert_matches_baseline(
    map: VisibilityMap, files: Files, *, scene: Showing = None, camera: str | None = None, **limits: Any
) -> None:
    """Assert that a map shows what any of several stored baselines shows.

    Parameters
    ----------
    map : VisibilityMap
    files : iterable of str or Path
        Maps as ``VisibilityMap.save`` writes them, or baselines of the pytest plug-in.
    scene, camera, **limits
        As for :func:`assert_agree`.

    Raises
    ------
    VisibilityError
        If none matches, or there is none.
    HsrError
        If a file cannot be read or a limit makes no sense.

    Examples
    --------
    >>> import hsr
    >>> map = hsr.render(hsr.load("scenes/cube.toml"), size=(10, 8))
    >>> map.save("baseline.npz")
    >>> hsr.testing.assert_matches_baseline(map, ["baseline.npz"])
    """
    paths = [Path(file) for file in files]
    if not paths:
        raise VisibilityError("there is no baseline; write one with map.save(path), and look at it first")
    subject = subject_of(scene, camera, map)
    found = match(map.method, map, paths, merged([(CALLER, limits)]), subject)
    if not found.passed:
        raise VisibilityError("\n".join(found.lines))


def assert_similar(picture: Pixels, reference: Pixels, min_similarity: float = MIN_SIMILARITY) -> None:
    """Assert that two shaded pictures look alike: a weaker check than any by face id.

    Parameters
    ----------
    picture, reference : (H, W) or (H, W, 3) uint8
    min_similarity : float
        Least structural similarity, 1 for equal pictures.

    Raises
    ------
    VisibilityError
        If they look less alike.
    CheckError
        If the pictures cannot be compared.

    Examples
    --------
    >>> import numpy as np
    >>> from hsr.testing import assert_similar
    >>> picture = np.arange(256, dtype=np.uint8).reshape(16, 16)
    >>> assert_similar(picture, picture // 2 * 2)
    """
    passed, text = compared(picture, reference, min_similarity)
    if not passed:
        raise VisibilityError(text)


def _told(judgement: Judgement) -> str:
    """Return a judgement, and in a line the command that explains its first sample."""
    command = judgement.command()
    return judgement.text() + (f"\n  {command}" if command else "")


# ---------------------------------------------------------------- pictures


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
        kinds = (f"{shown.dtype} {shown.shape}" for shown in (picture, reference))
        raise CheckError(f"pictures must be uint8 arrays of one shape, not {' and '.join(kinds)}")
    if picture.ndim not in (2, 3) or min(picture.shape[:2]) < WINDOW:
        raise CheckError(f"pictures must be (H, W) or (H, W, 3), {WINDOW} pixels or more a side")
    axis = None if picture.ndim == 2 else -1
    alike = structural_similarity(picture, reference, win_size=WINDOW, channel_axis=axis)
    other = (picture != reference).reshape(*picture.shape[:2], -1).any(axis=-1).sum()
    told = f"similarity {alike:.6g}, at least {min_similarity:g} demanded, {other} pixels of another colour"
    return bool(alike >= min_similarity), f"pictures: {told}\n  {WEAKER}"
