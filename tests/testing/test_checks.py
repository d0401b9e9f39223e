"""The plain functions: what they raise, and what they say."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.errors import CheckError, MapError, VisibilityError
from hsr.problem.map import VisibilityMap
from hsr.testing import assert_agree, assert_matches_baseline, assert_same_visibility, assert_similar
from tests.conftest import SCENES

ROOM = SCENES / "cube.toml"


@pytest.fixture(scope="module")
def truth() -> VisibilityMap:
    return hsr.render(hsr.load(ROOM), "exact", (24, 24))


@pytest.fixture(scope="module")
def wrong(truth: VisibilityMap) -> VisibilityMap:
    return replace(truth, face=np.roll(truth.face, 2, axis=0), method="raycast", admissible=None)


def test_right_maps_pass(truth: VisibilityMap) -> None:
    assert_agree({"mine": hsr.render(hsr.load(ROOM), "raycast", (24, 24))}, truth, scene=ROOM)
    assert_same_visibility(truth, truth, max_diff_pixels=0)


def test_wrong_maps_fail_with_the_command_that_explains_them(
    truth: VisibilityMap, wrong: VisibilityMap
) -> None:
    with pytest.raises(AssertionError) as error:
        assert_agree({"fine": truth, "mine": wrong}, truth, scene=ROOM)
    text = str(error.value)
    assert isinstance(error.value, VisibilityError)
    assert text.startswith("mine vs exact, 24x24: ") and "fine vs" not in text
    assert f"\n  hsr explain {ROOM} " in text and text.endswith("--size 24x24 -a raycast")


def test_limits_are_those_of_the_caller(truth: VisibilityMap, wrong: VisibilityMap) -> None:
    assert_same_visibility(wrong, truth, max_diff_ratio=1.0)
    with pytest.raises(VisibilityError, match=r"max_diff_pixels=1 \(caller\): "):
        assert_same_visibility(wrong, truth, max_diff_pixels=1)
    with pytest.raises(CheckError, match="caller: there is no limit 'max_diff'"):
        assert_same_visibility(wrong, truth, max_diff=1)


def test_what_cannot_be_compared(truth: VisibilityMap) -> None:
    with pytest.raises(MapError, match="render both at one size"):
        assert_same_visibility(hsr.render(hsr.load(ROOM), "exact", (8, 8)), truth)
    with pytest.raises(CheckError, match="nothing to compare"):
        assert_agree({}, truth)


def test_any_file_that_matches_will_do(truth: VisibilityMap, wrong: VisibilityMap, tmp_path: Path) -> None:
    for name, shown in (("a", wrong), ("b", truth)):
        shown.save(tmp_path / f"{name}.npz")
    assert_matches_baseline(truth, [tmp_path / "a.npz", tmp_path / "b.npz"], depth_ulps=0)
    with pytest.raises(VisibilityError, match="scene same, camera same"):
        assert_matches_baseline(truth, [tmp_path / "a.npz"])
    with pytest.raises(VisibilityError, match="there is no baseline"):
        assert_matches_baseline(truth, [])


def test_a_changed_scene_explains_a_difference_and_is_none(truth: VisibilityMap, tmp_path: Path) -> None:
    truth.save(tmp_path / "a.npz")
    renamed = replace(truth, hashes={**truth.hashes, "scene": "another"})
    assert_matches_baseline(renamed, [tmp_path / "a.npz"])
    with pytest.raises(VisibilityError, match="scene changed, camera same"):
        assert_matches_baseline(replace(renamed, face=np.roll(truth.face, 1)), [tmp_path / "a.npz"])


# ---------------------------------------------------------------- pictures


def picture(value: int, shape: Any = (16, 16, 3)) -> Any:
    return np.full(shape, value, np.uint8)


def test_pictures_that_look_alike() -> None:
    assert_similar(picture(90), picture(90))
    assert_similar(picture(90, (16, 16)), picture(90, (16, 16)), min_similarity=1.0)
    changed = picture(90)
    changed[3:9, 3:9] = 200
    with pytest.raises(VisibilityError, match="36 pixels of another colour\n  weaker check"):
        assert_similar(changed, picture(90))


@pytest.mark.parametrize(
    ("one", "other", "complaint"),
    [
        (picture(0), picture(0, (16, 15, 3)), "of one shape"),
        (picture(0).astype(float), picture(0), "must be uint8"),
        (picture(0, (6, 16)), picture(0, (6, 16)), "7 pixels or more a side"),
    ],
)
def test_pictures_that_cannot_be_compared(one: Any, other: Any, complaint: str) -> None:
    with pytest.raises(CheckError, match=complaint):
        assert_similar(one, other)
