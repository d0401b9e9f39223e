"""Id images of other programs: each format is written here, and read back."""

from __future__ import annotations

import json
import pickle
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import hsr
from hsr.base.errors import MapError
from hsr.problem.view import View
from hsr.testing import read_map

FACE = np.array([[-1, 0, 70000], [1, 300, -1]], dtype=np.int32)
IDS = (FACE + 1).astype(np.uint32)
SMALL = IDS % 65536
"""The same in 16 bits."""


def channels(ids: Any, order: str, bits: int = 8) -> Any:
    """Split ids into channels, which stand in the order r, g, b, a."""
    parts = {letter: ids >> bits * k & (2**bits - 1) for k, letter in enumerate(reversed(order))}
    return np.stack([parts[letter] for letter in sorted(order, key="rgba".index)], axis=2)


def png(pixels: Any, path: Path) -> None:
    Image.fromarray(pixels if pixels.dtype == np.uint16 else pixels.astype(np.uint8)).save(path)


def written_png(order: str) -> Callable[[Path], None]:
    return lambda path: png(channels(IDS, order), path)


@pytest.mark.parametrize(
    ("name", "write", "how", "expected"),
    [
        ("a.png", written_png("rgb"), {}, FACE),
        ("a.png", written_png("bgr"), {"ids": "bgr24"}, FACE),
        ("a.png", written_png("rgba"), {"ids": "rgba32"}, FACE),
        ("a.png", written_png("abgr"), {"ids": "abgr32"}, FACE),
        ("a.png", lambda path: png(SMALL.astype(np.uint16), path), {"ids": "r16"}, SMALL.astype(int) - 1),
        ("a.png", lambda path: png(IDS % 256, path), {"ids": "r8"}, (IDS % 256).astype(int) - 1),
        ("a.npy", lambda path: np.save(path, FACE), {}, FACE),
        ("a.npy", lambda path: np.save(path, IDS), {}, FACE),
        ("a.npy", lambda path: np.save(path, IDS.astype(np.float32)), {}, FACE),
        ("a.npy", lambda path: np.save(path, IDS - 1), {"background": 2**32 - 1}, FACE),
        ("a.npy", lambda path: np.save(path, FACE[::-1]), {"flip": True}, FACE),
        ("a.npy", lambda path: np.save(path, channels(IDS, "rgb").astype(np.uint8)), {}, FACE),
        ("a.npz", lambda path: np.savez(path, FACE), {}, FACE),
        ("a.npz", lambda path: np.savez(path, depth=FACE * 0.5, ids=FACE), {}, FACE),
        ("a.raw", lambda path: IDS.tofile(path), {"ids": "r32", "size": (3, 2)}, FACE),
        (
            "a.raw",
            lambda path: channels(IDS, "bgr").astype(np.uint8).tofile(path),
            {"ids": "bgr24", "size": (3, 2)},
            FACE,
        ),
        (
            "a.raw",
            lambda path: channels(IDS, "rg", 16).astype(np.uint16).tofile(path),
            {"ids": "rg32", "size": (3, 2)},
            FACE,
        ),
    ],
)
def test_what_was_written_is_read(
    tmp_path: Path, name: str, write: Callable[[Path], None], how: dict[str, Any], expected: Any
) -> None:
    write(tmp_path / name)
    shown = read_map(tmp_path / name, **how)
    np.testing.assert_array_equal(shown.face, expected)
    assert shown.method == name and not shown.tells_depth


def test_a_map_of_our_own_stays_what_it_is(tmp_path: Path) -> None:
    own = hsr.render(hsr.load("cube"), "zbuffer", (8, 6))
    own.save(tmp_path / "a.npz")
    read = read_map(tmp_path / "a.npz")
    assert (read.method, read.manifest, read.digest) == ("zbuffer", own.manifest, own.digest)
    assert read_map(tmp_path / "a.npz", method="mine").method == "mine"


def deep_png(path: Path, kind: int, bits: int, row: bytes) -> None:
    """Write one row of a PNG of any depth, which Pillow does not."""
    parts = [(b"IHDR", struct.pack(">IIBBBBB", 1, 1, bits, kind, 0, 0, 0))]
    parts += [(b"IDAT", zlib.compress(b"\0" + row)), (b"IEND", b"")]
    told = [
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        for name, data in parts
    ]
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(told))


ODD = np.full((2, 3, 4), 255, np.uint8)
ODD[1, 2, 3] = 200


@pytest.mark.parametrize(
    ("name", "write", "how", "problem"),
    [
        ("a.png", lambda _: None, {}, "no such file"),
        ("a.tiff", lambda path: path.write_bytes(b""), {}, "ids are read from .png, .exr, .npy, .npz, .raw"),
        ("a.png", lambda path: path.write_bytes(b"x" * 40), {}, "not a picture that can be read"),
        ("a.png", written_png("rgb"), {"ids": "rgb25"}, "write channels from the highest on and their bits"),
        ("a.png", written_png("rgb"), {"ids": "rgr24"}, "write channels from the highest on and their bits"),
        ("a.png", written_png("rgb"), {"ids": "rgba32"}, "it has 3 channels, too few for ids of rgba32"),
        (
            "a.png",
            lambda path: png(ODD, path),
            {},
            "alpha: id 200 at 2,1 is not opaque; ids must not be blended",
        ),
        (
            "a.png",
            lambda path: Image.new("P", (3, 2)).save(path),
            {},
            "it is a palette of 1 bits, and no ids of rgb24",
        ),
        ("a.png", lambda path: Image.new("L", (3, 2)).save(path), {}, "it is grey of 8 bits, .*; say ids r8"),
        ("a.png", lambda path: png(SMALL.astype(np.uint16), path), {}, "grey of 16 bits, .*; say ids r16"),
        (
            "a.png",
            lambda path: Image.new("1", (3, 2)).save(path),
            {"ids": "r8"},
            "of 1 bits, and no ids of r8",
        ),
        ("a.png", lambda path: deep_png(path, 0, 4, b"\x10"), {"ids": "r8"}, "of 4 bits, and no ids of r8"),
        ("a.png", lambda path: deep_png(path, 2, 16, b"\0" * 6), {}, "RGB of 16 bits, and no ids of rgb24"),
        (
            "a.png",
            lambda path: deep_png(path, 2, 16, b"\0" * 6),
            {"ids": "r16"},
            "RGB of 16 bits, and no ids",
        ),
        (
            "a.npy",
            lambda path: np.save(path, FACE + 0.5),
            {},
            "id -0.5 at 0,0 .* no whole number; .* blends ids",
        ),
        (
            "a.npy",
            lambda path: np.save(path, FACE[0]),
            {},
            r"ids must be numbers \(H, W\).*, not \(3,\) int32",
        ),
        ("a.npy", lambda path: np.save(path, np.array([["a"]])), {}, "ids must be numbers"),
        (
            "a.npy",
            lambda path: np.save(path, np.zeros((2, 3, 3))),
            {},
            "need channels of 8 bits, not float64",
        ),
        (
            "a.npy",
            lambda path: np.save(path, np.full((2, 2), None), allow_pickle=True),
            {},
            "it holds Python objects, which are not read",
        ),
        ("a.npy", lambda path: path.write_bytes(pickle.dumps([1, 2])), {}, "not a visibility map"),
        (
            "a.npz",
            lambda path: np.savez(path, a=FACE, b=FACE),
            {},
            "which of a, b is it\\? call that one 'ids'",
        ),
        ("a.raw", lambda path: IDS.tofile(path), {}, "give ids, such as r32, and size"),
        (
            "a.raw",
            lambda path: IDS.tofile(path),
            {"ids": "r32", "size": (3, 3)},
            "3x3 ids of r32 take 36 bytes, and it has 24",
        ),
        (
            "a.exr",
            lambda path: path.write_bytes(b"x"),
            {},
            r"not an EXR that can be read|install hsr-lab\[exr\]",
        ),
    ],
)
def test_what_is_no_image_of_ids_is_refused_with_the_reason(
    tmp_path: Path, name: str, write: Callable[[Path], Any], how: dict[str, Any], problem: str
) -> None:
    write(tmp_path / name)
    with pytest.raises(MapError, match=problem) as raised:
        read_map(tmp_path / name, **how)
    assert "\n" not in str(raised.value) and "allow_pickle" not in str(raised.value)


# ---------------------------------------------------------------- which face an id is


@pytest.fixture(scope="module")
def cube() -> View:
    return hsr.view(hsr.load("cube"), (8, 6))


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("faces.csv", "id,face\n#ff8800,cube.front\n0x0088ff, 4\n"),
        ("faces.csv", "\ufeff16746496,0\n35071,cube.front\n1,cube.top\n"),
        ("faces.json", '{"#ff8800": "cube.front", "35071": 4}'),
    ],
)
def test_ids_are_faces_as_a_file_tells(tmp_path: Path, cube: View, name: str, content: str) -> None:
    (tmp_path / name).write_text(content, encoding="utf-8")
    ids = np.zeros((6, 8), np.uint32)
    ids[2, 3], ids[4, 5] = 0xFF8800, 0x0088FF
    np.save(tmp_path / "a.npy", ids)
    shown = read_map(tmp_path / "a.npy", cube, faces=tmp_path / name)
    named = [shown.name_of(face) for face in (shown.face[2, 3], shown.face[4, 5], shown.face[0, 0])]
    first = "cube.front" if "#" in content else cube.manifest[0]["name"] + "." + cube.manifest[0]["faces"][0]
    assert named == [first, "cube.front", "background"] and shown.hashes == cube.hashes


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("1,cube.front\n1,cube.top\n", "two faces, [0-9] and [0-9], share the id 1"),
        ("1,cube.frnt\n", "'cube.frnt' is no face of the scene; did you mean 'cube.front'"),
        ("1,cube\n", "'cube' is no face of the scene"),
        ("one,cube.front\n", "'one' is no id; write 12, 0x0c or #00000c"),
        ("2,cube.front\n", "id 1 at 0,0 and 47 more is no face in faces.csv; antialiasing blends ids"),
        ("1,6\n", "id 6 at 0,0 and 47 more is no face: they run from 0 to 5"),
        ("1\n", "no ids and faces"),
        ("id,face\n", "it tells no faces; write lines ID,FACE"),
    ],
)
def test_faces_that_cannot_be_are_refused(tmp_path: Path, cube: View, content: str, problem: str) -> None:
    np.save(tmp_path / "a.npy", np.ones((6, 8), np.uint8))
    (tmp_path / "faces.csv").write_text(content, encoding="utf-8")
    with pytest.raises(MapError, match=problem):
        read_map(tmp_path / "a.npy", cube, faces=tmp_path / "faces.csv")


def test_names_are_those_of_a_scene(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.ones((6, 8), np.uint8))
    (tmp_path / "faces.csv").write_text("1,cube.front\n")
    with pytest.raises(MapError, match=r"'cube\.front' is a name; say of which scene"):
        read_map(tmp_path / "a.npy", faces=tmp_path / "faces.csv")


# ---------------------------------------------------------------- EXR


def exr(path: Path, held: dict[str, Any], **facts: str) -> None:
    library = pytest.importorskip("OpenEXR")
    library.File({f"cryptomatte/abc/{key}": told for key, told in facts.items()}, held).write(str(path))


def test_channels_of_exr_are_ids(tmp_path: Path) -> None:
    exr(tmp_path / "one.exr", {"ID": IDS})
    assert (read_map(tmp_path / "one.exr").face == FACE).all()
    exr(tmp_path / "two.exr", {"R": IDS.astype(np.float32), "G": np.ones((2, 3), np.float32)})
    assert (read_map(tmp_path / "two.exr", ids="r32").face == FACE).all()
    with pytest.raises(MapError, match="say which of its channels G, R holds ids, such as ids r32"):
        read_map(tmp_path / "two.exr")


def matte(path: Path, hashed: Any, cover: Any, other: Any, names: dict[str, int]) -> None:
    """Write a layer of Cryptomatte."""
    told = json.dumps({name: f"{number:08x}" for name, number in names.items()})
    held = {"m00.R": hashed.view(np.float32), "m00.G": cover, "m00.B": 0 * cover, "m00.A": other}
    exr(path, {name: part.astype(np.float32) for name, part in held.items()}, name="m", manifest=told)


def test_cryptomatte_names_faces(tmp_path: Path, cube: View) -> None:
    names = {"cube.front": 0x3F800001, "cube.top": 0xBF900000}
    hashed, cover = np.full((6, 8), names["cube.front"], np.uint32), np.ones((6, 8))
    hashed[2, 3], hashed[0, 0], cover[0, 0] = names["cube.top"], 0, 0
    matte(tmp_path / "a.exr", hashed, cover, 0 * cover, names)
    shown = read_map(tmp_path / "a.exr", cube)
    told = [shown.name_of(shown.face[place]) for place in ((0, 0), (2, 3), (5, 7))]
    assert told == ["background", "cube.top", "cube.front"]
    (tmp_path / "faces.json").write_text('{"cube.front": 1, "cube.top": 1}')
    assert read_map(tmp_path / "a.exr", faces=tmp_path / "faces.json").face.max() == 1
    cover[3, 3] = 0.5
    matte(tmp_path / "b.exr", hashed, cover, 0 * cover, names)
    with pytest.raises(MapError, match=r"0\.5 at 3,3 covers a part of the pixel; render one sample a pixel"):
        read_map(tmp_path / "b.exr", cube)
