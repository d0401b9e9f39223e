"""Families describe themselves; the registry finds them all."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import hsr
from hsr.algorithms.registry import certified_methods, methods
from hsr.base.errors import HsrError, MethodError
from hsr.lab.stability import cases
from hsr.lab.stability.cases import families, family_named
from hsr.lab.stability.family import GROUPS, QUICK_SIDE, Family, Variant, at_side
from hsr.scene.writing import to_toml

FAMILIES = families()


def test_every_file_holds_hard_cases() -> None:
    files = {path.stem for path in Path(cases.__path__[0]).glob("[!_]*.py")}
    assert {family.scene.__module__.rpartition(".")[2] for family in FAMILIES.values()} == files
    assert len(FAMILIES) >= 41


def test_a_function_is_a_family_by_its_name_and_its_docstring() -> None:
    family = family_named("needle-gap")
    assert family.scene.__name__ == "needle_gap"
    assert family.story.startswith("Two walls leave a gap through which a third is seen, at one column of")
    assert family.story.endswith("which one of the two walls then owns.")


@pytest.mark.parametrize("family", FAMILIES.values(), ids=FAMILIES)
def test_a_family_says_what_it_must(family: Family) -> None:
    assert family.group in GROUPS
    for text in (family.story, family.expected, family.source, family.parameter):
        assert len(text) > 5 and text == text.strip()
    steps = np.diff(family.sweep)
    assert (steps > 0).all() or (steps < 0).all()
    assert family.values(quick=True)[-1] == family.sweep[-1]
    names = [variant.name for variant in family.variants]
    assert len(set(names)) == len(names)
    for variant in family.variants:
        assert variant.because and variant.factor >= 1.0
        assert variant.mistake is not None or (variant.method or variant.name) in methods()


@pytest.mark.parametrize("family", FAMILIES.values(), ids=FAMILIES)
def test_scenes_are_the_same_each_time_and_go_through_files(family: Family, tmp_path: Path) -> None:
    value = family.values(quick=True)[0]
    scene = family.scene_at(value, QUICK_SIDE)
    assert to_toml(scene) == to_toml(family.scene_at(value, QUICK_SIDE)) and scene.title == family.name
    file = tmp_path / "scene.toml"
    file.write_text(to_toml(scene), encoding="utf-8")
    size = family.size(value, QUICK_SIDE)
    again = hsr.view(hsr.load(file), size)
    assert again.hashes == family.view(value, QUICK_SIDE).hashes


@pytest.mark.parametrize("family", FAMILIES.values(), ids=FAMILIES)
def test_any_value_of_the_sweep_makes_a_scene(family: Family) -> None:
    for k in (0, len(family.sweep) // 2, -2):
        value = 0.37 * family.sweep[k] + 0.63 * family.sweep[k + 1]
        assert family.view(value, QUICK_SIDE).faces > 0


def test_the_certified_come_first_and_peers_last() -> None:
    family = family_named("fan")
    names = [variant.name for variant in family.contenders()]
    assert tuple(names[:2]) == certified_methods() and names[-1].startswith("embree")
    assert names.count("opengl") == 1
    assert [variant.name for variant in family.contenders(("scanline-snap-4", "exact"))] == [
        "scanline-snap-4",
        "exact",
    ]


def test_a_quick_run_takes_one_peer_of_each_kind() -> None:
    names = [variant.name for variant in family_named("interpenetration").contenders((), quick=True)]
    assert [name for name in names if name.startswith("embree")] == ["embree"]


def test_unknown_names_are_told() -> None:
    with pytest.raises(HsrError, match=r"no family is named 'fans'; did you mean 'fan'\?"):
        family_named("fans")
    with pytest.raises(MethodError, match="no method is named 'z'"):
        family_named("fan").contenders(("z",))


@pytest.mark.parametrize("value", [1.0, 1e9, float("nan")])
def test_values_outside_the_sweep_are_refused(value: float) -> None:
    with pytest.raises(HsrError, match=r"fan: --at .* is outside the sweep, 4 to 8192"):
        family_named("fan").scene_at(value, 32)


@pytest.mark.parametrize(("name", "value"), [("relations", 2.5), ("t-junction", 0.2), ("fan", 12.0)])
def test_values_between_that_mean_nothing_are_refused(name: str, value: float) -> None:
    with pytest.raises(HsrError, match=rf"{name}: --at {value:g} is not in the sweep; choose one of "):
        family_named(name).scene_at(value, 32)


def test_a_break_may_depend_on_the_side() -> None:
    variant = Variant("zbuffer", lambda side: 2.0 * side, "2 W")
    assert at_side(variant.breaks, 32) == 64.0 and at_side(3.0, 32) == 3.0
    assert at_side(None, 32) is None
