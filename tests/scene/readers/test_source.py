"""Files packed by gzip, their endings, their words, and the memory that reading takes."""

from __future__ import annotations

import gzip
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from hsr.base.errors import SceneError
from hsr.scene.files import load, shape_of
from hsr.scene.readers import READERS, read_faces, source
from hsr.scene.readers.source import bare, decimal, ending_of, stem_of, whole
from tests.scene.readers.made import Mesh, write_binary_stl, write_obj, write_off, write_ply, write_stl

GRID: Mesh = (
    [(float(k % 60), float(k // 60), 0.0) for k in range(3600)],
    [[k, k + 1, k + 61] for k in range(3500)] + [[k, k + 1, k + 61, k + 60] for k in range(3000)],
)
TRIANGLES: Mesh = (GRID[0], GRID[1][:3500])
FILES = {
    "a.obj": write_obj(GRID),
    "a.off": write_off(GRID),
    "text.ply": write_ply(GRID, ""),
    "a.ply": write_ply(GRID, "<", "uchar", "ushort"),
    "text.stl": write_stl(TRIANGLES),
    "a.stl": write_binary_stl(TRIANGLES),
}


@pytest.mark.parametrize("name", FILES)
def test_packed_files_are_the_same(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(FILES[name])
    packed = tmp_path / f"{name}.GZ"
    packed.write_bytes(gzip.compress(FILES[name]))
    plain = load(tmp_path / name)
    scene = load(packed)
    one, other = (shape_of(of.object[0], tmp_path) for of in (plain, scene))
    assert one.polygons is not None and other.polygons is not None
    assert np.array_equal(one.polygons.vertices, other.polygons.vertices)
    assert np.array_equal(one.polygons.corner, other.polygons.corner)
    assert scene.object[0].name == plain.object[0].name == name[:-4]


SMALL = (
    b"ply\nformat binary_little_endian 1.0\n"
    b"element vertex %d\nproperty char x\nproperty char y\nproperty char z\n"
    b"element %s %d\nproperty list %s char vertex_index\nend_header\n"
)
MIXED = bytes(3) + b"\3\0\0\0\4\0\0\0\0" * 10_000
DENSE = {
    **FILES,
    "vertices.ply": SMALL % (20_000, b"face", 0, b"uchar") + bytes(60_000),
    "nothing.ply": SMALL % (1, b"face", 20_000, b"uchar") + bytes(20_003),
    "alike.ply": SMALL % (1, b"face", 20_000, b"uchar") + bytes(3) + b"\3\0\0\0" * 20_000,
    "mixed.ply": SMALL % (1, b"face", 20_000, b"uchar") + MIXED,
    "strips.ply": SMALL % (1, b"tristrips", 20_000, b"uchar") + MIXED,
    "strip.ply": SMALL % (1, b"tristrips", 1, b"ushort") + bytes(3) + b"\x20\x4e" + bytes(20_000),
    "b.obj": b"v 0 0 0\n" + b"f 1 1 1\n" * 20_000,
    "b.off": b"OFF 1 20000\n0 0 0\n" + b"3 0 0 0\n" * 20_000,
}
"""Files with as few bytes a number as may be."""


@pytest.mark.parametrize("name", DENSE)
def test_memory_is_a_multiple_of_the_file(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(DENSE[name])
    tracemalloc.start()
    try:
        read_faces(path)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < (100 if "strip" in name else 20) * len(DENSE[name])


def test_a_bomb_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(source, "MAX_UNPACKED", 1 << 20)
    path = tmp_path / "bomb.obj.gz"
    path.write_bytes(gzip.compress(bytes(1 << 24)))
    tracemalloc.start()
    try:
        with pytest.raises(SceneError, match=r"bomb.obj.gz: it unpacks to more than 1 MiB; "):
            load(path)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < 4 << 20


def test_packed_files_cut_off_or_damaged_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.obj.gz"
    packed = gzip.compress(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    for end in range(1, len(packed)):
        path.write_bytes(packed[:end])
        with pytest.raises(SceneError, match="not a readable gzip file"):
            read_faces(path)
    for content in (b"v 0 0 0\n", packed[:12] + b"\xff" + packed[13:], packed + b"more"):
        path.write_bytes(content)
        with pytest.raises(SceneError, match="not a readable gzip file"):
            read_faces(path)


def test_endings_and_stems() -> None:
    names = ["a.PLY", "a.ply.gz", "a.b.ply.GZ", "a.gz", "a"]
    assert [ending_of(Path(name)) for name in names] == [".ply", ".ply", ".ply", "", ""]
    assert [stem_of(Path(name)) for name in names] == ["a", "a", "a.b", "a", "a"]


def test_comments_and_numbers_with_the_same_character() -> None:
    lines = [b"v 1#two", b"#IND", b"v -1.#IND 1.#INF00 # c", b"1.# c", b"##"]
    assert [bare(line) for line in lines] == [b"v 1", b"", b"v -1.#IND 1.#INF00 ", b"1.", b""]


def test_words_that_are_numbers() -> None:
    assert [decimal(word) for word in (b"1.5", b"-.5e3", b"inf")] == [1.5, -500.0, np.inf]
    assert all(np.isnan(decimal(word)) for word in (b"nan", b"-1.#IND", b"1.#QNAN0", b"-nan(ind)"))
    assert [whole(word) for word in (b"12", b"-3", b"+4")] == [12, -3, 4]
    for read, words in ((decimal, (b"1_0", b"1,5", b"")), (whole, (b"1_0", b"1.0", b"9" * 19, b"\xb2"))):
        for word in words:
            with pytest.raises(ValueError):
                read(word)


def test_names_in_errors_are_printable(tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    path.write_bytes(b"ply\nformat ascii 1.0\nelement \x1d\x85 2\nproperty int x\nend_header\n")
    with pytest.raises(SceneError, match=r"row 0 .* of element \\x1d\\x85 is not whole$"):
        read_faces(path)


@pytest.mark.parametrize("ending", READERS)
def test_errors_of_readers_are_one_line(tmp_path: Path, ending: str, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / f"a{ending}"
    path.write_bytes(b"")

    def stumble(_: bytes) -> None:
        raise KeyError("a\nb")

    monkeypatch.setitem(READERS, ending, stumble)
    with pytest.raises(SceneError, match=rf"not a readable {ending[1:].upper()} file \(KeyError: 'a\\nb'\)"):
        read_faces(path)
