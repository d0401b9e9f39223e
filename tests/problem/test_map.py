"""The map: its checks, its names, its file."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from hsr.base.errors import MapError
from hsr.problem.map import Admissible, Clock, VisibilityMap, load_map

MANIFEST = [
    {"name": "box", "shape": "cube", "first": 0, "count": 6, "faces": ["top", "bottom", "r", "l", "f", "b"]},
    {"name": "ball", "shape": "sphere", "first": 6, "count": 1, "faces": ["sphere"]},
    {"name": "bunny", "shape": "mesh", "first": 7, "count": 100},
]


def small_map(**changes: object) -> VisibilityMap:
    face = np.array([[-1, 0, 6], [7, 106, 5]], dtype=np.int32)
    depth = np.where(face < 0, np.inf, face + 1.5)
    values = {"method": "zbuffer", "work": {"fragments": 5}, "seconds": {"render": 0.1}}
    return VisibilityMap(
        face, depth, **{**values, "manifest": MANIFEST, "hashes": {"scene": "ab"}, **changes}
    )


def test_size_is_columns_by_rows() -> None:
    assert (small_map().width, small_map().height) == (3, 2)


def test_face_and_depth_must_have_one_shape() -> None:
    with pytest.raises(MapError, match=r"\(2, 3\) and depth \(3, 2\)"):
        VisibilityMap(np.zeros((2, 3), np.int32), np.zeros((3, 2)), "zbuffer")


@pytest.mark.parametrize(
    ("face", "name"),
    [
        (-1, "background"),
        (0, "box.top"),
        (5, "box.b"),
        (6, "ball"),
        (7, "bunny#0"),
        (106, "bunny#99"),
        (107, "unknown face 107"),
        (-2, "unknown face -2"),
    ],
)
def test_faces_have_names(face: int, name: str) -> None:
    assert small_map().name_of(face) == name


def test_what_is_saved_is_read_back_but_for_times(tmp_path: Path) -> None:
    written = small_map(notes={"sufficient": True})
    written.save(tmp_path / "map.npz")
    read = load_map(tmp_path / "map.npz")
    assert np.array_equal(read.face, written.face) and read.face.dtype == np.int32
    assert np.array_equal(read.depth, written.depth)
    for name in ("method", "work", "notes", "manifest", "hashes"):
        assert getattr(read, name) == getattr(written, name)
    assert read.seconds == {}


def test_same_answer_same_bytes(tmp_path: Path) -> None:
    small_map().save(tmp_path / "a.npz")
    small_map(seconds={"render": 0.7}).save(tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_missing_map_says_how_to_write_one(tmp_path: Path) -> None:
    with pytest.raises(MapError, match="no such file; write one with 'hsr render"):
        load_map(tmp_path / "none.npz")


@pytest.mark.parametrize("content", [b"", b"not a zip", b"PK\x03\x04 cut short"])
def test_corrupt_map_is_one_clear_line(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "bad.npz").write_bytes(content)
    with pytest.raises(MapError, match="not a visibility map"):
        load_map(tmp_path / "bad.npz")


@pytest.mark.parametrize("damaged", range(40))
def test_map_with_a_damaged_byte_is_read_or_refused(tmp_path: Path, damaged: int) -> None:
    small_map().save(tmp_path / "bad.npz")
    content = bytearray((tmp_path / "bad.npz").read_bytes())
    content[damaged * len(content) // 40] ^= 0xFF
    (tmp_path / "bad.npz").write_bytes(content)
    with suppress(MapError):
        load_map(tmp_path / "bad.npz")


def test_map_without_all_its_entries_is_refused(tmp_path: Path) -> None:
    arrays = {"face": np.zeros((1, 1), np.int32), "depth": np.zeros((1, 1)), "meta": np.array('{"hsr": 1}')}
    np.savez(tmp_path / "short.npz", **arrays)
    with pytest.raises(MapError, match="method: Field required; render it again"):
        load_map(tmp_path / "short.npz")


def test_foreign_archive_is_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "foreign.npz", ids=np.zeros(3))
    with pytest.raises(MapError, match="not a visibility map"):
        load_map(tmp_path / "foreign.npz")


def test_map_of_another_version_is_refused(tmp_path: Path) -> None:
    arrays = {"face": np.zeros((1, 1), np.int32), "depth": np.zeros((1, 1)), "meta": np.array('{"hsr": 99}')}
    np.savez(tmp_path / "old.npz", **arrays)
    with pytest.raises(MapError, match="version 1; render it again"):
        load_map(tmp_path / "old.npz")


def test_map_of_wrong_types_is_refused(tmp_path: Path) -> None:
    arrays = {"face": np.zeros((1, 1), np.int64), "depth": np.zeros((1, 1)), "meta": np.array('{"hsr": 1}')}
    np.savez(tmp_path / "wide.npz", **arrays)
    with pytest.raises(MapError, match="face must be int32 and depth float64, not int64"):
        load_map(tmp_path / "wide.npz")


def test_unwritable_path_is_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(MapError, match="cannot write the map: No such file or directory"):
        small_map().save(tmp_path / "no" / "folder.npz")


def test_clock_adds_up_stages() -> None:
    clock = Clock()
    for _ in range(2):
        with clock("render"):
            pass
    with clock("prepare"):
        pass
    assert set(clock.seconds) == {"render", "prepare"}
    assert all(seconds >= 0.0 for seconds in clock.seconds.values())


def test_a_map_admits_its_owners_and_those_of_its_ties() -> None:
    tied = Admissible(np.array([1, 2]), np.array([0, 2, 5]), np.array([0, 7, -1, 0, 5], dtype=np.int32))
    truth = VisibilityMap(np.zeros((1, 4), np.int32), np.ones((1, 4)), "exact", admissible=tied)
    shown = np.array([[0, 7, 5, 0], [7, 5, -1, 7]], dtype=np.int32)
    assert truth.admits(shown[:1]).tolist() == [[True, True, True, True]]
    assert truth.admits(shown[1:]).tolist() == [[False, False, True, False]]
