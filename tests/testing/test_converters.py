"""Ids of other renderers: the same picture by every convention gives the same map."""

from __future__ import annotations

import random
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import hsr
from hsr.base.errors import MapError
from hsr.problem.map import Admissible, VisibilityMap
from hsr.problem.view import View
from hsr.testing import by_object, from_ids, from_nvdiffrast, from_open3d, from_png, from_pyrender

RED = np.full((1, 1, 3), (9, 0, 0), np.uint8)
FACE = np.array([[-1, 0, 2], [1, 1, -1]], dtype=np.int32)


def rast() -> Any:
    values = np.zeros((1, 2, 3, 4), np.float32)
    values[0, ..., 3] = FACE[::-1] + 1
    return values


def png(folder: Path) -> Path:
    number = (FACE + 1) * 0x010203
    colours = np.stack([number >> 16, (number >> 8) & 255, number & 255], axis=-1).astype(np.uint8)
    Image.fromarray(colours).save(folder / "ids.png")
    return folder / "ids.png"


def test_every_convention(tmp_path: Path) -> None:
    colours = [(1, 2, 3), (200, 0, 0), (0, 0, 255)]
    seg = np.array([(0, 0, 0), *colours], dtype=np.uint8)[FACE + 1]
    maps = {
        "array": from_ids(FACE),
        "offset": from_ids(FACE.astype(np.uint16) + 1, background=0, first=1),
        "bottom up": from_ids(FACE[::-1].astype(float), bottom_up=True),
        "nvdiffrast": from_nvdiffrast(rast()),
        "open3d": from_open3d(FACE.astype(np.uint32)),
        "pyrender": from_pyrender(seg, colours),
    }
    for name, shown in maps.items():
        assert np.array_equal(shown.face, FACE), name
        assert shown.face.dtype == np.int32 and not shown.tells_depth
        assert np.array_equal(np.isinf(shown.depth), FACE < 0)
    assert maps["open3d"].method == "open3d"
    stretched = from_png(png(tmp_path))
    assert np.array_equal(stretched.face, np.where(FACE < 0, -1, (FACE + 1) * 0x010203 - 1))


def test_geometries_begin_where_they_are_said_to() -> None:
    ids = np.array([[0, 1, 0xFFFFFFFF]], np.uint32)
    geometry = np.array([[0, 1, 0xFFFFFFFF]], np.uint32)
    assert from_open3d(ids, geometry_ids=geometry, starts=(0, 10)).face.tolist() == [[0, 11, -1]]
    with pytest.raises(MapError, match="id 1 at 1,0 is a geometry without a start"):
        from_open3d(ids, geometry_ids=geometry)


@pytest.fixture(scope="module")
def boxes(make_scene: Any) -> View:
    things = [
        {"name": name, "shape": "cube", "transform": [{"translate": [x, 0.0, 0.0]}]}
        for name, x in (("left", -1.0), ("right", 1.5))
    ]
    return hsr.view(make_scene(things), (32, 24))


def triangles_of(view: View) -> Any:
    """The first triangle of the face that is seen, for every sample."""
    face = hsr.render(view, "exact").face
    return np.where(face < 0, -1, np.searchsorted(view.triangle_face, face))


def test_triangles_become_the_faces_of_the_view(boxes: View) -> None:
    truth, triangles = hsr.render(boxes, "exact"), triangles_of(boxes)
    shown = from_ids(triangles, boxes, depth=truth.depth, method="mine")
    assert np.array_equal(shown.face, truth.face) and triangles.max() > truth.face.max()
    assert hsr.compare(shown, truth).counts["depth only"] == 0 and shown.tells_depth
    assert shown.name_of(int(shown.face.max())).startswith("right.")


def test_objects_in_place_of_faces(boxes: View) -> None:
    truth = hsr.render(boxes, "exact")
    objects = by_object(truth)
    assert np.array_equal(objects.face, boxes.object_of(truth.face))
    assert objects.name_of(1) == "right"
    seg = np.array([(0, 0, 0), (9, 0, 0), (0, 9, 0)], np.uint8)[objects.face + 1]
    shown = from_pyrender(seg, [(9, 0, 0), (0, 9, 0)], boxes)
    assert hsr.compare(shown, objects).same
    with pytest.raises(MapError, match="no manifest"):
        by_object(VisibilityMap(FACE, np.where(FACE < 0, np.inf, 1.0), "a"))


def test_objects_that_may_own_a_tie_are_named_once(boxes: View) -> None:
    face = np.full((24, 32), -1, np.int32)
    ties = Admissible(np.array([5, 7]), np.array([0, 3, 5]), np.array([0, 1, 6, -1, 8], dtype=np.int32))
    truth = VisibilityMap(face, np.full((24, 32), np.inf), "exact", manifest=boxes.manifest, admissible=ties)
    objects = by_object(truth).admissible
    assert objects is not None
    assert objects.faces(5) == {0, 1} and objects.faces(7) == {-1, 1} and len(objects.face) == 4


@pytest.mark.parametrize(
    ("convert", "complaint"),
    [
        (lambda _: from_ids(np.array([[0.5]])), "id 0.5 at 0,0 is no whole number"),
        (lambda _: from_ids(np.array([[np.nan, 1.0]])), "id nan at 0,0 is no whole number"),
        (
            lambda _: from_ids(np.array([[0xFFFFFFFF]], np.uint32)),
            "id 4294967295 at 0,0 is no triangle",
        ),
        (lambda _: from_ids(np.array([[-2]])), "id -2 at 0,0 is no triangle"),
        (lambda _: from_ids(np.zeros(3)), r"ids must be an \(H, W\) array, not \(3,\)"),
        (lambda _: from_ids(FACE, depth=np.zeros((1, 1))), r"depth \(1, 1\) has not the shape"),
        (lambda view: from_ids(FACE, view), "3x2 is not the size of the view, 32x24"),
        (
            lambda view: from_ids(np.full((24, 32), 24), view),
            "id 24 at 0,0 and 767 more is no triangle",
        ),
        (lambda _: from_ids(np.array([["a"]])), "ids must be an .* array, not .* <U1"),
        (lambda _: from_ids(np.array([[None]])), "ids must be an .* array, not .* object"),
        (lambda _: from_ids(np.zeros((0, 3), int)), "ids must be"),
        (lambda _: from_ids(np.full((1, 1), 2.0**25, np.float32)), "id .* is beyond 2\\^24, where float32"),
        (lambda _: from_ids(FACE, depth=np.full(FACE.shape, "x")), "depth must be"),
        (lambda _: from_open3d(np.full((1, 1), 0.5)), "id 0.5 at 0,0 is no whole number"),
        (lambda _: from_open3d(np.full((1, 1), np.nan)), "id nan at 0,0 is no whole number"),
        (lambda _: from_open3d(FACE, starts=(5,)), "id -1 at 0,0 and 1 more is no triangle"),
        (
            lambda _: from_open3d(FACE, geometry_ids=np.zeros((3, 2), int)),
            r"geometry_ids \(3, 2\) have not the shape of the others, \(2, 3\)",
        ),
        (
            lambda _: from_open3d(np.abs(FACE), geometry_ids=np.full(FACE.shape, -1)),
            "id -1 at 0,0 and 5 more is a geometry without a start",
        ),
        (lambda _: from_pyrender(RED / 255, [(9, 0, 0)]), "must be .* uint8, not .* float64"),
        (lambda _: from_pyrender(RED, [(9, 0, 0), (9, 0, 0)]), r"colour \(9, 0, 0\) is of two nodes"),
        (lambda _: from_pyrender(RED, [(0, 0, 0), (9, 0, 0)]), r"colour \(0, 0, 0\) is of two nodes, or"),
        (lambda _: from_pyrender(RED, [(9, 0, 0, 255)]), r"\(9, 0, 0, 255\) is not red, green and blue"),
        (lambda _: from_pyrender(RED, [(0.5, 0, 0)]), r"\(0.5, 0, 0\) is not red, green and blue"),
        (lambda _: from_pyrender(RED, [(9, 0, 256)]), "each from 0 to 255"),
        (lambda _: from_nvdiffrast(np.zeros((2, 3))), "rast must be"),
        (lambda _: from_nvdiffrast(np.full((1, 1, 4), 2.0**25)), "beyond 2\\^24"),
        (lambda _: from_pyrender(np.zeros((2, 2)), []), "seg must be"),
        (lambda _: from_pyrender(np.full((1, 1, 3), 7, np.uint8), [(9, 9, 9)]), "is the colour of no node"),
    ],
)
def test_what_cannot_be_is_told_in_a_line(boxes: View, convert: Any, complaint: str) -> None:
    with pytest.raises(MapError, match=complaint) as error:
        convert(boxes)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("mode", "name", "complaint"),
    [
        ("P", "p.png", "not PNG P"),
        ("L", "l.png", "not PNG L"),
        ("RGB", "c.jpg", "not a PNG file"),
        ("RGBA", "t.png", "not PNG RGBA"),
    ],
)
def test_pictures_that_hold_no_ids(tmp_path: Path, mode: str, name: str, complaint: str) -> None:
    Image.new(mode, (4, 4)).save(tmp_path / name)
    with pytest.raises(MapError, match=complaint):
        from_png(tmp_path / name)


def test_a_picture_that_is_none(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"no picture")
    with pytest.raises(MapError, match=r"a\.png: not a picture"):
        from_png(tmp_path / "a.png")


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def raw_png(path: Path, width: int, height: int, bits: int, rows: bytes) -> Path:
    """Write an RGB picture as its header says."""
    header = struct.pack(">IIBBBBB", width, height, bits, 2, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*one) for one in chunks))
    return path


def test_ids_in_16_bits_a_channel_are_refused(tmp_path: Path) -> None:
    with pytest.raises(MapError, match="8-bit RGB, not PNG RGB of 16 bits"):
        from_png(raw_png(tmp_path / "a.png", 1, 1, 16, bytes([0, 0, 1, 0, 2, 0, 3])))


def test_pictures_of_any_size_that_we_render_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 2)  # of Pillow, which takes larger ones for an attack
    file = raw_png(tmp_path / "a.png", 3, 2, 8, 2 * bytes([0, 0, 0, 1, 0, 1, 0, 1, 0, 0]))
    assert from_png(file).face.tolist() == 2 * [[0, 255, 65535]]
    with pytest.raises(MapError, match="larger than 16384x16384"):
        from_png(raw_png(tmp_path / "b.png", 16385, 1, 8, b""))


def test_damaged_pictures_are_refused_in_a_line(tmp_path: Path) -> None:
    Image.fromarray(np.arange(192, dtype=np.uint8).reshape(8, 8, 3)).save(tmp_path / "a.png")
    whole, chance = (tmp_path / "a.png").read_bytes(), random.Random(0)
    for _ in range(300):
        content = bytearray(whole[: chance.choice((len(whole), chance.randrange(len(whole))))] or b"x")
        content[chance.randrange(len(content))] = chance.randrange(256)
        (tmp_path / "a.png").write_bytes(content)
        try:
            from_png(tmp_path / "a.png")
        except MapError as error:
            assert "\n" not in str(error)


def test_a_picture_may_say_what_made_it() -> None:
    made = from_ids(np.array([[0, 1]]), model="float32", depth_format="d16")
    assert made.notes["model"] == {"model": "float32", "depth_format": "d16"}
    with pytest.raises(MapError, match="there is no model 'float31'; did you mean 'float32'"):
        from_ids(np.array([[0, 1]]), model="float31")
