"""Every family: certified methods at zero, every other variant where its theory says."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from hsr.algorithms.registry import certified_methods, method_named
from hsr.lab.stability.cases import families
from hsr.lab.stability.family import Family, another_choice
from hsr.lab.stability.judge import FINE, Result, judge

FAMILIES = families()

EVERYONE = [pytest.param(family, id=name) for name, family in FAMILIES.items()]


@cache
def judged(name: str) -> Result:
    """Run a family without the peers, which other machines may lack."""
    family = FAMILIES[name]
    own = tuple(v.name for v in family.variants if v.mistake or not method_named(v.method or v.name).needs)
    return judge(family, quick=True, asked=(*certified_methods(), *own))


@pytest.mark.jit
@pytest.mark.parametrize("family", EVERYONE)
def test_every_row_is_as_theory_says(family: Family) -> None:
    rows = {row.variant: row for row in judged(family.name).rows}
    assert {name: rows[name].wrong for name in certified_methods()} == dict.fromkeys(certified_methods(), 0)
    assert not any(point.refused for name in certified_methods() for point in rows[name].points)
    assert {name: row.verdict for name, row in rows.items() if row.verdict not in FINE} == {}
    assert sum(row.unexplained for row in rows.values()) == 0


@pytest.mark.jit
@pytest.mark.parametrize("family", EVERYONE)
def test_something_breaks_in_every_family(family: Family) -> None:
    """A sweep that no variant and no planted mistake fails would prove nothing."""
    assert any(row.wrong for row in judged(family.name).rows if row.variant not in certified_methods())


@pytest.mark.jit
@pytest.mark.parametrize("family", EVERYONE)
def test_certified_methods_choose_at_ties_as_the_truth_does(family: Family) -> None:
    strict = replace(family, wrong=another_choice)
    hardest = replace(strict, sweep=(family.sweep[0], *family.values(quick=True)[-2:]))
    assert [row.wrong for row in judge(hardest, asked=certified_methods()).rows] == [0, 0]


@pytest.mark.jit
@pytest.mark.parametrize("name", ["degenerate-input", "vertex-aimed-rays", "coplanar-overlap"])
def test_the_same_kernels_fail_without_certification(name: str) -> None:
    for row in judge(FAMILIES[name], quick=True, asked=("zbuffer-plain", "raycast-plain")).rows:
        assert row.wrong > 0 and row.unexplained == 0
