"""Every family: certified methods at zero, every other variant where its theory says."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from hsr.experiments.stability.family import Family, another_choice, families
from hsr.experiments.stability.judge import FINE, Result, judge

FAMILIES = families()

NOT_YET = {"box-grazing", "coplanar-overlap", "tiny-grid"}
"""Families in which ``raycast`` still shows wrong samples; exactly these."""

EVERYONE = [pytest.param(family, id=name) for name, family in FAMILIES.items()]


@cache
def judged(name: str) -> Result:
    """Run a family without the peers, which other machines may lack."""
    family = FAMILIES[name]
    own = tuple(v.name for v in family.variants if v.name not in ("opengl", "embree"))
    return judge(family, quick=True, asked=("zbuffer", "raycast", *own))


@pytest.mark.jit
@pytest.mark.parametrize("family", EVERYONE)
def test_every_row_is_as_theory_says(family: Family) -> None:
    rows = {row.variant: row for row in judged(family.name).rows}
    raycast = rows.pop("raycast")
    assert (raycast.wrong > 0) == (family.name in NOT_YET)
    assert rows["zbuffer"].wrong == 0
    assert {name: row.verdict for name, row in rows.items() if row.verdict not in FINE} == {}
    assert sum(row.unexplained for row in rows.values()) == 0


@pytest.mark.jit
@pytest.mark.parametrize("family", EVERYONE)
def test_something_breaks_in_every_family(family: Family) -> None:
    """A sweep that no variant and no planted mistake fails would prove nothing."""
    assert any(row.wrong for row in judged(family.name).rows if row.variant not in ("zbuffer", "raycast"))


@pytest.mark.jit
@pytest.mark.parametrize("family", [p for p in EVERYONE if p.id != "relations"])
def test_the_certified_buffer_chooses_at_ties_as_the_truth_does(family: Family) -> None:
    strict = replace(family, wrong=another_choice)
    hardest = replace(strict, sweep=(family.sweep[0], *family.values(quick=True)[-2:]))
    assert judge(hardest, quick=False, asked=("zbuffer",)).rows[0].wrong == 0
