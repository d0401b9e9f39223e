"""Assertions for other people's test suites."""

from __future__ import annotations

from hsr.difference.classes import compare
from hsr.visibility import VisibilityMap

__all__ = ["assert_same_visibility"]


def assert_same_visibility(a: VisibilityMap, b: VisibilityMap, max_diff_pixels: int = 0) -> None:
    """Assert that two maps show the same face at every sample.

    Parameters
    ----------
    a, b : VisibilityMap
        ``a`` is judged against ``b``. Depths are reported, not judged.
    max_diff_pixels : int
        How many samples may show another face.

    Raises
    ------
    AssertionError
        If more samples differ; the message lists the classes and the largest clusters.
    MapError
        If the maps differ in size, scene or camera, so that comparing them means nothing.
    """
    difference = compare(a, b)
    if difference.different > max_diff_pixels:
        raise AssertionError(f"{difference.summary()}\nallowed: max_diff_pixels={max_diff_pixels}")
