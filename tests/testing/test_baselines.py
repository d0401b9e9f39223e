"""Baselines: names that every file system takes, content that says what changed."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hsr.base.errors import CheckError
from hsr.problem.map import VisibilityMap
from hsr.testing.baselines import changes, contents, file_stem, match, next_variant, read, variants, write
from hsr.testing.limits import Limits

FACE = np.array([[0, 1], [-1, 1]], dtype=np.int32)
DEPTH = np.array([[1.0, 2.0], [np.inf, 3.0]])
HASHES = {"scene": "s", "camera": "c", "size": "z"}
SEEN = VisibilityMap(FACE, DEPTH, "painter", {"faces": 2}, hashes=HASHES, notes={"driver": "7", "time": 1.5})


@given(st.lists(st.text(min_size=1, max_size=120), min_size=1, max_size=3))
def test_names_are_safe(parts: list[str]) -> None:
    stem = file_stem(*parts)
    assert re.fullmatch(r"[a-z0-9_.-]+", stem) and len(stem) <= 80
    assert stem.split(".")[0] not in ("con", "prn", "aux", "nul", "com1", "lpt1")
    assert not stem.startswith(".")


@given(
    st.lists(st.text(max_size=9), min_size=1, max_size=2),
    st.lists(st.text(max_size=9), min_size=1, max_size=2),
)
def test_different_names_stay_different(one: list[str], other: list[str]) -> None:
    assert (file_stem(*one) == file_stem(*other)) == (one == other)


def test_plain_names_stay_as_they_are() -> None:
    assert file_stem("test_room") == "test_room"
    assert file_stem("test_room", "left") == "test_room.left"
    assert file_stem("test_room[A]").startswith("test_room-a-")


def test_variants_are_numbered(tmp_path: Path) -> None:
    assert variants(tmp_path, "a") == [] and next_variant(tmp_path, "a", ".npz") == tmp_path / "a.npz"
    for name in ("a~10.npz", "a.npz", "a~2.json", "a~x.npz", "ab.npz", "a.b.npz"):
        (tmp_path / name).touch()
    assert [file.name for file in variants(tmp_path, "a")] == ["a.npz", "a~2.json", "a~10.npz"]
    assert next_variant(tmp_path, "a", ".npz") == tmp_path / "a~11.npz"


def test_ids_are_kept_and_depths_only_if_wanted(tmp_path: Path) -> None:
    for depths in (True, False):
        write(tmp_path / "a.npz", SEEN, depths)
        kept = read(tmp_path / "a.npz")
        assert isinstance(kept, VisibilityMap)
        assert np.array_equal(kept.face, FACE) and kept.tells_depth == depths
        assert np.array_equal(kept.depth, DEPTH) == depths
        assert contents(kept) == contents(SEEN)
        assert kept.work == {} and "time" not in kept.notes


@pytest.mark.parametrize("ending", ["npz", "json"])
def test_the_same_answer_gives_the_same_bytes(tmp_path: Path, ending: str) -> None:
    write(tmp_path / f"a.{ending}", SEEN, False)
    write(tmp_path / f"b.{ending}", replace(SEEN, seconds={"render": 1.0}, work={}), False)
    assert (tmp_path / f"a.{ending}").read_bytes() == (tmp_path / f"b.{ending}").read_bytes()


def test_what_changed() -> None:
    old, renamed = contents(SEEN), replace(SEEN, method="brush", hashes={"scene": "t"})
    deeper = replace(renamed, depth=DEPTH + 1.0)
    told = changes(old, contents(deeper))
    assert told == (
        "scene changed, camera unknown, depths changed, size same, "
        "renderer changed from painter (7) to brush (7)"
    )
    assert contents(deeper)["faces"] == old["faces"]


@pytest.mark.parametrize("judged", [False, True])
def test_hashes_judge_depths_only_if_wanted(tmp_path: Path, judged: bool) -> None:
    write(tmp_path / "a.json", SEEN, False)
    deeper = replace(SEEN, depth=DEPTH + 1.0)
    found = match("mine", deeper, [tmp_path / "a.json"], Limits(depth_ulps=4 if judged else None), None)
    assert found.passed != judged


def test_depths_that_were_not_kept_cannot_be_judged(tmp_path: Path) -> None:
    write(tmp_path / "a.npz", SEEN, False)
    assert match("mine", SEEN, [tmp_path / "a.npz"], Limits(), None).passed
    found = match("mine", SEEN, [tmp_path / "a.npz"], Limits(depth_ulps=4), None)
    assert not found.passed and "keeps no depths" in found.lines[0]


def test_the_first_that_matches_is_named(tmp_path: Path) -> None:
    other = replace(SEEN, face=np.zeros_like(FACE))
    for name, kept in (("a.npz", other), ("a~2.npz", SEEN), ("a~3.npz", SEEN)):
        write(tmp_path / name, kept, False)
    found = match("mine", SEEN, variants(tmp_path, "a"), Limits(), None)
    assert found.passed and found.file.name == "a~2.npz"
    assert found.lines[0] == "mine vs a~2.npz, 2x2: 0 samples count as different"


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"hsr": 2}', '{"hsr": 1, "faces": "x"}', "\x00"])
def test_hashes_that_are_none(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.json").write_text(text, encoding="utf-8")
    with pytest.raises(CheckError, match=r"a\.json: not a baseline") as error:
        read(tmp_path / "a.json")
    assert "\n" not in str(error.value)


def test_a_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(CheckError, match="cannot write the baseline"):
        write(tmp_path / "file" / "a.npz", SEEN, False)
