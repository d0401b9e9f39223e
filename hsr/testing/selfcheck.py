"""A check tried on planted mistakes: those it overlooks."""

from __future__ import annotations

import numpy as np

from hsr.mistakes.planted import MISTAKES, planted
from hsr.problem.map import VisibilityMap
from hsr.testing.judging import judge
from hsr.testing.limits import Limits
from hsr.testing.problems import Problem


def let_through(
    shown: VisibilityMap, expected: VisibilityMap, limits: Limits, problem: Problem
) -> dict[str, int]:
    """Find the mistakes that a check would not notice.

    Parameters
    ----------
    shown, expected : VisibilityMap
        What the check compares.
    limits : Limits
    problem : Problem

    Returns
    -------
    dict of str to int
        By mistake, the number of samples that it makes wrong and the check lets pass. Mistakes that
        do not show in this view are not among them.
    """
    found = {}
    for mistake in MISTAKES:
        changed = planted(mistake, shown, problem.view)
        wrong = int(np.count_nonzero(~problem.truth.admits(changed.face) & (changed.face != shown.face)))
        if wrong and judge(mistake, changed, expected, limits, problem).passed:
            found[mistake] = wrong
    return found
