"""Ranges, counted one after the other."""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import ranges


def test_ranges_are_counted_one_after_the_other() -> None:
    which, number = ranges(np.array([3, 5, 0]), np.array([5, 4, 1]))
    assert (which.tolist(), number.tolist()) == ([0, 0, 2], [3, 4, 0])
