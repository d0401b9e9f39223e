"""Files are written whole, or not at all."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from hsr.base.errors import HsrError, MapError
from hsr.base.files import write_folder, write_whole


def test_text_and_bytes(tmp_path: Path) -> None:
    write_whole(tmp_path / "a", "zwölf", "the file")
    assert (tmp_path / "a").read_bytes() == "zwölf".encode()
    write_whole(tmp_path / "a", b"\x00\xff", "the file")
    assert (tmp_path / "a").read_bytes() == b"\x00\xff"
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_a_full_disk_leaves_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a").write_text("old", encoding="utf-8")

    def full_disk(path: Path, data: bytes) -> Any:
        with path.open("wb") as file:
            file.write(data[:1])
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(Path, "write_bytes", full_disk)
        with pytest.raises(MapError, match="a: cannot write the map: No space left on device"):
            write_whole(tmp_path / "a", "new", "the map", MapError)
    assert (tmp_path / "a").read_text(encoding="utf-8") == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_no_such_folder(tmp_path: Path) -> None:
    with pytest.raises(HsrError, match="cannot write the picture: No such file or directory"):
        write_whole(tmp_path / "none" / "a.png", b"", "the picture")


def test_names_as_long_as_a_file_system_takes(tmp_path: Path) -> None:
    for name in ("a" * 255, "ä" * 127):
        write_whole(tmp_path / name, name, "the file")
        assert (tmp_path / name).read_text(encoding="utf-8") == name
    with pytest.raises(HsrError, match="cannot write the file: File name too long"):
        write_whole(tmp_path / ("a" * 256), "", "the file")


def test_a_link_is_replaced_and_what_it_leads_to_stays(tmp_path: Path) -> None:
    (tmp_path / "other").write_text("old", encoding="utf-8")
    (tmp_path / "a").symlink_to(tmp_path / "other")
    write_whole(tmp_path / "a", "new \udc80", "the file")
    assert (tmp_path / "a").read_text(encoding="utf-8") == "new ?"
    assert (tmp_path / "other").read_text(encoding="utf-8") == "old"


def test_a_folder_is_written_whole(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    for target in (tmp_path / "new" / "folder", tmp_path / "empty"):
        write_folder(target, {"a.txt": "é", "b.bin": b"\0"})
        assert (target / "a.txt").read_text("utf-8") == "é" and (target / "b.bin").read_bytes() == b"\0"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["empty", "new"]


def test_a_folder_with_anything_in_it_is_left_as_it_is(tmp_path: Path) -> None:
    file = tmp_path / "out" / "mine.txt"
    file.parent.mkdir()
    file.write_text("mine", "utf-8")
    for target in (file.parent, file):
        with pytest.raises(HsrError, match=r"^\S+: there is something already, .*; name a new folder$"):
            write_folder(target, {"a.txt": "a"})
    assert [*tmp_path.rglob("*")] == [file.parent, file] and file.read_text("utf-8") == "mine"


def test_of_a_folder_that_fails_nothing_is_left(tmp_path: Path) -> None:
    with pytest.raises(HsrError, match=r"^\S+out: cannot write the folder: "):
        write_folder(tmp_path / "out", {"a.txt": "a", "not/there.txt": "b"})
    assert not [*tmp_path.iterdir()]
