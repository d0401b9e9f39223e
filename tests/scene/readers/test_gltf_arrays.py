"""glTF files: what moves, hides, copies or replaces vertices, and what bears on no shape."""

from __future__ import annotations

import base64
import gzip
import json
import math
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hsr.base.arrays import Array, Floats
from hsr.base.errors import SceneError
from hsr.scene import files, transforms
from hsr.scene.files import load, shape_of
from hsr.scene.model import Perspective
from hsr.scene.readers import gltf
from hsr.scene.readers.gltf import Document
from hsr.scene.transforms import compose, placed

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32)
QUARTER = math.sqrt(0.5)
KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
CODES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}


class Made:
    """A glTF document that is made array by array; accessor 0 holds four corners, mesh 0 two triangles."""

    def __init__(self) -> None:
        self.buffer = b""
        self.tree: dict[str, Any] = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": []}
        self.tree |= {"meshes": [], "nodes": [], "scenes": [{"nodes": [0]}]}
        self.mesh(POSITION=self.array(CORNERS, "f4"), indices=self.array([0, 1, 2, 0, 1, 3], "u2"))

    def view(self, values: Any, code: str, **keys: Any) -> int:
        content = np.asarray(values, f"<{code}").tobytes()
        self.buffer += bytes(-len(self.buffer) % 4)
        self.tree["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(content), **keys}
        )
        self.buffer += content
        return len(self.tree["bufferViews"]) - 1

    def array(self, values: Any, code: str, **keys: Any) -> int:
        values = np.asarray(values, code)
        width = 1 if values.ndim == 1 else values.shape[1]
        self.tree["accessors"].append(
            {"bufferView": self.view(values, code), "count": len(values), "type": KINDS[width]}
            | {"componentType": CODES[code], **keys}
        )
        return len(self.tree["accessors"]) - 1

    def mesh(self, mode: int = 4, indices: int | None = None, **attributes: int) -> dict[str, Any]:
        primitive: dict[str, Any] = {"attributes": attributes, "mode": mode}
        if indices is not None:
            primitive["indices"] = indices
        self.tree["meshes"].append({"primitives": [primitive]})
        return primitive

    def node(self, **keys: Any) -> None:
        self.tree["nodes"].append({"mesh": len(self.tree["meshes"]) - 1, **keys})
        self.tree["scenes"][0]["nodes"] = [*range(len(self.tree["nodes"]))]

    def glb(self) -> bytes:
        text = json.dumps({**self.tree, "buffers": [{"byteLength": len(self.buffer)}]}).encode()
        parts = [
            (b"JSON", text + b" " * (-len(text) % 4)),
            (b"BIN\0", self.buffer + bytes(-len(self.buffer) % 4)),
        ]
        body = b"".join(struct.pack("<I4s", len(content), kind) + content for kind, content in parts)
        return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


@pytest.fixture
def made() -> Made:
    return Made()


def triangles(folder: Path, made: Made) -> list[Floats]:
    """Corners (n, 3, 3) of every object's triangles in the world."""
    path = folder / "a.glb"
    path.write_bytes(made.glb())
    scene = load(path)
    found = []
    for thing in scene.object:
        polygons = shape_of(thing, folder).polygons
        assert polygons is not None
        found.append(placed(polygons.vertices, compose(thing.transform)[:3])[polygons.triangle_vertex])
    return found


def refused(folder: Path, made: Made) -> str:
    with pytest.raises(SceneError) as caught:
        triangles(folder, made)
    (line,) = str(caught.value).splitlines()
    return line.partition("a.glb: ")[2]


TWO = CORNERS[[[0, 1, 2], [0, 1, 3]]].astype(np.float64)


# ---------------------------------------------------------------- arrays


def test_positions_may_be_whole_numbers(tmp_path: Path, made: Made) -> None:
    made.node()
    for code, keys, scale in (
        ("i1", {"normalized": True}, 127.0),
        ("u2", {"normalized": True}, 65535.0),
        ("i2", {}, 1.0),
    ):
        corners = [[0, 0, 0], [100, 0, 0], [0, 100, 0]]
        made.mesh(POSITION=made.array(corners, code, **keys))
        made.node()
        assert np.array_equal(triangles(tmp_path, made)[-1][0], np.array(corners) / scale)
    made.mesh(POSITION=made.array([[-128, -127, 127]] * 3, "i1", normalized=True))
    made.node()
    assert triangles(tmp_path, made)[-1][0].tolist() == [[-1, -1, 1]] * 3


def test_arrays_may_be_interleaved(tmp_path: Path, made: Made) -> None:
    rows = np.hstack([CORNERS, CORNERS + 5])
    made.array(CORNERS, "f4", bufferView=made.view(rows, "f4", byteStride=24), byteOffset=12)
    made.mesh(POSITION=len(made.tree["accessors"]) - 1, indices=1)
    made.node()
    assert np.array_equal(triangles(tmp_path, made)[0], TWO + 5)


@pytest.mark.parametrize("based", [True, False])
def test_sparse_accessors(tmp_path: Path, made: Made, based: bool) -> None:
    sparse = {
        "count": 2,
        "indices": {"bufferView": made.view([1, 3], "u1"), "componentType": 5121},
        "values": {"bufferView": made.view([[7, 8, 9], [4, 5, 6]], "f4")},
    }
    index = made.array(CORNERS, "f4", sparse=sparse)
    if not based:
        del made.tree["accessors"][index]["bufferView"]
    made.mesh(POSITION=index, indices=1)
    made.node()
    expected = CORNERS.astype(np.float64) * based
    expected[[1, 3]] = [[7, 8, 9], [4, 5, 6]]
    assert np.array_equal(triangles(tmp_path, made)[0], expected[[[0, 1, 2], [0, 1, 3]]])
    sparse["indices"]["bufferView"] = made.view([1, 4], "u1")
    assert refused(tmp_path, made) == "a sparse accessor of 4 values replaces number 4"


@pytest.mark.parametrize(("mode", "expected"), [(5, [[3, 0, 1], [2, 1, 0]]), (6, [[3, 0, 1], [3, 1, 2]])])
def test_strips_and_fans(tmp_path: Path, made: Made, mode: int, expected: list[list[int]]) -> None:
    made.mesh(mode, POSITION=0, indices=made.array([3, 0, 1, 2], "u1"))
    made.node()
    made.mesh(mode, POSITION=made.array(CORNERS[[3, 0, 1, 2]], "f4"))
    made.node()
    for found in triangles(tmp_path, made):
        assert np.array_equal(found, CORNERS[expected])


def test_primitives_without_faces_are_passed_over(tmp_path: Path, made: Made) -> None:
    made.tree["meshes"][0]["primitives"] += [{"attributes": {}}, {"attributes": {"POSITION": 0}, "mode": 1}]
    made.node()
    made.mesh()
    made.node()
    (found,) = triangles(tmp_path, made)
    assert np.array_equal(found, TWO)


def test_primitives_share_their_vertices(tmp_path: Path, made: Made) -> None:
    primitives = made.tree["meshes"][0]["primitives"]
    primitives += [
        {"attributes": {"POSITION": made.array(CORNERS + 5, "f4")}, "indices": 1},
        {"attributes": {"POSITION": 0}, "indices": 1},
    ]
    made.node()
    assert np.array_equal(triangles(tmp_path, made)[0], np.concatenate([TWO, TWO + 5, TWO]))
    path = tmp_path / "a.glb"
    assert len(Document(path).faces("mesh 0").vertices) == 8


# ---------------------------------------------------------------- what moves vertices


def test_morph_targets(tmp_path: Path, made: Made) -> None:
    targets = [
        {"POSITION": made.array(CORNERS * 4, "f4")},
        {"NORMAL": 0},
        {"POSITION": made.array(CORNERS * 8, "f4")},
    ]
    made.tree["meshes"][0]["primitives"][0]["targets"] = targets
    made.tree["meshes"][0]["weights"] = [1, 1, 0]
    for keys in (
        {},
        {"weights": [0, 0, 0.5], "name": "open"},
        {"weights": [0, 0, 0]},
        {"weights": [0, 0, 0.5]},
    ):
        made.node(**keys)
    assert [found.max() for found in triangles(tmp_path, made)] == [5.0, 5.0, 1.0, 5.0]
    scene = load(tmp_path / "a.glb")
    assert [thing.part for thing in scene.object] == [  # type: ignore[attr-defined]
        "mesh 0",
        "mesh 0 of open",
        "mesh 0 of mesh 0",
        "mesh 0 of open",
    ]
    targets[0]["POSITION"] = made.array(CORNERS[:1], "f4")
    assert refused(tmp_path, made).endswith("has 1 values, not 4")


def moved(x: float) -> Array:
    return np.array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, 0, 0, 1], np.float32)


@pytest.mark.parametrize("bound", [True, False])
def test_a_skin_moves_vertices_into_the_world(tmp_path: Path, made: Made, bound: bool) -> None:
    weights = [[1, 0, 0, 0], [0.25, 0.75, 0, 0], [0, 3, 0, 0], [0, 0, 0, 1]]
    made.mesh(
        POSITION=0,
        indices=1,
        JOINTS_0=made.array([[0, 1, 0, 0], [0, 1, 0, 0], [0, 1, 0, 0], [0, 1, 1, 0]], "u1"),
        WEIGHTS_0=made.array(weights, "f4"),
    )
    made.node(skin=0, translation=[1000, 0, 0], name="body")
    made.tree["nodes"] += [
        {"translation": [10, 0, 0], "children": [2]},
        {"scale": [2, 2, 2], "rotation": [0, 0, QUARTER, QUARTER], "translation": [0, 5, 0]},
    ]
    made.tree["skins"] = [{"joints": [1, 2]}]
    if bound:
        made.tree["skins"][0]["inverseBindMatrices"] = made.array([moved(-1), moved(-2)], "f4")
    one = CORNERS + np.array([10.0 - bound, 0.0, 0.0])
    # Turned by a quarter about z, doubled, then moved.
    away = CORNERS - np.array([2.0 * bound, 0.0, 0.0])
    two = np.column_stack([-2 * away[:, 1], 2 * away[:, 0], 2 * away[:, 2]]) + np.array([10.0, 5.0, 0.0])
    expected = np.array([one[0], 0.25 * one[1] + 0.75 * two[1], two[2], one[3]])
    (found,) = triangles(tmp_path, made)
    assert np.allclose(found, expected[[[0, 1, 2], [0, 1, 3]]], rtol=0, atol=1e-14)
    del made.tree["meshes"][1]["primitives"][0]["attributes"]["JOINTS_0"]
    assert refused(tmp_path, made) == "a node has a skin, and its mesh has no joints; export it without skin"


def test_instances(tmp_path: Path, made: Made) -> None:
    attributes = {
        "TRANSLATION": made.array([[0, 0, 0], [3, 0, 0], [6, 0, 0]], "f4"),
        "ROTATION": made.array([[0, 0, 0, 127], [0, 0, 127, 0], [0, 0, 0, 127]], "i1", normalized=True),
        "SCALE": made.array([[1, 1, 1], [1, 2, 1], [0, 0, 0]], "f4"),
    }
    extensions = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    made.node(name="n", translation=[0, 0, 100], extensions=extensions)
    one, two = triangles(tmp_path, made)
    assert np.array_equal(one, TWO + np.array([0, 0, 100]))
    assert np.array_equal(two, TWO * [-1, -2, 1] + np.array([3, 0, 100]))
    assert [thing.name for thing in load(tmp_path / "a.glb").object] == ["n", "n.1"]
    attributes["SCALE"] = made.array([[1, 1, 1]], "f4")
    assert refused(tmp_path, made).endswith("has 3 values, not 1")
    extensions["EXT_mesh_gpu_instancing"]["attributes"] = {}
    assert refused(tmp_path, made) == "node 0 has instances without transforms"


def test_hidden_nodes_are_left_out(tmp_path: Path, made: Made) -> None:
    hidden = {"extensions": {"KHR_node_visibility": {"visible": False}}}
    made.tree["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 1}}]
    made.node(children=[2], **hidden)
    made.node(extensions={"KHR_node_visibility": {"visible": True}}, name="seen", camera=0)
    made.tree["nodes"].append({"mesh": 0})
    made.tree["extensionsRequired"] = ["KHR_node_visibility"]
    assert len(triangles(tmp_path, made)) == 1
    assert load(tmp_path / "a.glb").object[0].name == "seen"


def test_what_has_no_size_is_left_out(tmp_path: Path, made: Made) -> None:
    made.node(scale=[0, 0, 0], children=[4])
    made.node(scale=[0, 0, 1])
    made.node(matrix=[0] * 15 + [1])
    made.node(name="seen")
    made.tree["nodes"].append({"mesh": 0})
    made.tree["scenes"][0]["nodes"] = [0, 1, 2, 3]
    assert len(triangles(tmp_path, made)) == 1
    made.tree["nodes"][3]["scale"] = [1, 0, 1]
    assert refused(tmp_path, made) == "node 3: scale: a scale of 0 makes the transform singular"


@pytest.mark.parametrize(
    "lens",
    [
        {"type": "perspective", "perspective": {"yfov": 4.0, "znear": 1}},
        {"type": "perspective", "perspective": {"yfov": 1.0}},
        {"type": "orthographic", "orthographic": {"ymag": 0.0, "znear": 0, "zfar": 1}},
        {"type": "fisheye"},
        None,
        {"type": "perspective", "perspective": {"yfov": 1e-320, "znear": 1}},
    ],
)
def test_a_camera_that_nobody_asked_for_never_refuses(
    tmp_path: Path, made: Made, lens: dict[str, Any]
) -> None:
    made.tree["cameras"] = [lens] if lens else []
    made.node(camera=0)
    assert len(triangles(tmp_path, made)) == 1
    assert [camera.name for camera in load(tmp_path / "a.glb").camera] == ["fitted"]


def test_a_camera_stands_where_its_node_is_that_has_a_skin(tmp_path: Path, made: Made) -> None:
    made.tree["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 1}}]
    made.tree["skins"] = [{"joints": [0]}]
    made.mesh(
        POSITION=0,
        indices=1,
        JOINTS_0=made.array([[0] * 4] * 4, "u1"),
        WEIGHTS_0=made.array([[1, 0, 0, 0]] * 4, "f4"),
    )
    made.node(camera=0, skin=0, translation=[0, 0, 7], name="both")
    triangles(tmp_path, made)
    scene = load(tmp_path / "a.glb")
    assert scene.camera[0].name == scene.object[0].name == "both"
    assert isinstance(scene.camera[0], Perspective) and scene.camera[0].eye == (0, 0, 7)


def test_the_work_grows_with_the_number_of_primitives(tmp_path: Path, made: Made) -> None:
    primitive = made.tree["meshes"][0]["primitives"][0]
    made.tree["meshes"][0]["primitives"] = [{**primitive, "extras": k} for k in range(5000)]
    made.node()
    triangles(tmp_path, made)
    faces = Document(tmp_path / "a.glb").faces()
    assert faces.vertices.shape == (4, 3) and len(faces.sides) == 10_000


def test_what_is_repeated_is_bounded(tmp_path: Path, made: Made, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gltf, "MANY", 100)
    primitive = made.tree["meshes"][0]["primitives"][0]
    made.tree["meshes"][0]["primitives"] = [primitive] * 1000
    made.node()
    assert refused(tmp_path, made) == "its meshes repeat what is in its buffers too often; export fewer"
    made.tree["meshes"][0]["primitives"] = [primitive]
    for _ in range(100):
        made.node()
    assert refused(tmp_path, made) == "it has more than 100 nodes and instances; export fewer"


# ---------------------------------------------------------------- extensions


def test_looks_never_refuse(tmp_path: Path, made: Made) -> None:
    made.tree["extensionsRequired"] = [
        *("EXT_texture_webp", "KHR_texture_basisu", "KHR_materials_variants", "KHR_lights_punctual"),
        *("KHR_xmp_json_ld", "KHR_mesh_quantization", "FOO_glitter"),
    ]
    made.tree["materials"] = [{"extensions": {"FOO_glitter": {}}}]
    made.tree["extensionsUsed"] = made.tree["extensionsRequired"]
    made.node(extensions={"KHR_lights_punctual": {"light": 0}, "BAR_unknown": {}})
    assert len(triangles(tmp_path, made)) == 1
    made.tree["extensionsRequired"] += ["BAR_unknown", "BAZ_nowhere"]
    assert refused(tmp_path, made) == "it requires BAR_unknown, BAZ_nowhere; export it without extensions"


def test_draco(tmp_path: Path, made: Made) -> None:
    primitive = made.tree["meshes"][0]["primitives"][0]
    primitive["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}
    made.node()
    assert np.array_equal(triangles(tmp_path, made)[0], TWO)  # the file has it uncompressed, too
    made.tree["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    message = "a primitive is compressed by KHR_draco_mesh_compression; export it uncompressed"
    assert refused(tmp_path, made) == message
    del made.tree["extensionsRequired"], made.tree["accessors"][1]["bufferView"]
    assert refused(tmp_path, made) == message


@pytest.mark.parametrize("name", ["EXT_meshopt_compression", "KHR_meshopt_compression"])
def test_meshopt(tmp_path: Path, made: Made, name: str) -> None:
    content = made.glb()
    tree = {**made.tree, "extensionsRequired": [name], "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}]}
    tree["bufferViews"][0]["extensions"] = {name: {"buffer": 1, "byteLength": 20}}
    tree["buffers"] = [{"byteLength": len(made.buffer), "extensions": {name: {"fallback": True}}}]
    path = tmp_path / "a.gltf"
    path.write_text(json.dumps(tree))
    with pytest.raises(SceneError, match=rf"bufferViews\[0\] is compressed by {name}; export it"):
        load(path)
    tree["buffers"][0]["uri"] = "data:;base64," + base64.b64encode(made.buffer).decode()
    path.write_text(json.dumps(tree))
    assert len(load(path).object) == 1 and content


# ---------------------------------------------------------------- files


def test_names_in_any_encoding(tmp_path: Path, made: Made) -> None:
    made.node(name="Geh\xe4use\xa0\ud800")
    made.tree["meshes"][0]["name"] = "\x00\U0001f600"
    triangles(tmp_path, made)
    scene = load(tmp_path / "a.glb")
    thing = scene.object[0]
    assert (thing.name, thing.part) == ("Gehäuse\\xa0\\ud800", "\\x00\U0001f600")  # type: ignore[attr-defined]
    faces = Document(tmp_path / "a.glb").faces
    assert faces("\x00\U0001f600") is faces("\\x00\U0001f600")


def test_a_file_may_be_latin_1_and_have_a_mark(tmp_path: Path, made: Made) -> None:
    made.node(name="NAME")
    tree = {**made.tree, "buffers": [{"byteLength": len(made.buffer), "uri": "a%20b%C3%A9.bin"}]}
    (tmp_path / "a bé.bin").write_bytes(made.buffer + b"more")
    text = json.dumps(tree).encode().replace(b"NAME", b"caf\xe9")
    for content in (text, b"\xef\xbb\xbf" + text):
        (tmp_path / "a.gltf").write_bytes(content)
        assert load(tmp_path / "a.gltf").object[0].name == "caf\ufffd"
    (tmp_path / "a bé.bin").write_bytes(made.buffer[:-1])
    with pytest.raises(SceneError, match=r"^buffers\[0\] has 59 bytes, not 60 as announced$"):
        Document(tmp_path / "a.gltf")
    (tmp_path / "a bé.bin").unlink()
    with pytest.raises(SceneError, match=r"buffers\[0\] is in a file that does not exist: 'a bé.bin'$"):
        Document(tmp_path / "a.gltf")


def test_packed_files(tmp_path: Path, made: Made) -> None:
    made.node()
    uri = "data:;base64," + base64.b64encode(made.buffer).decode()
    text = json.dumps({**made.tree, "buffers": [{"byteLength": len(made.buffer), "uri": uri}]}).encode()
    for name, content in (
        ("a.glb.gz", made.glb()),
        ("b.gltf.gz", text),
        ("c.gltf.GZ", text.decode().encode("utf-16")),
    ):
        (tmp_path / name).write_bytes(gzip.compress(content))
        assert np.array_equal(Document(tmp_path / name).faces().vertices, CORNERS)
        assert load(tmp_path / name).object[0].name == "mesh 0"


def test_a_file_cut_off_anywhere_is_refused(tmp_path: Path, made: Made) -> None:
    made.node()
    content, path = made.glb(), tmp_path / "a.glb"
    for end in range(len(content)):
        path.write_bytes(content[:end])
        with pytest.raises(SceneError):
            Document(path).faces()
    path.write_bytes(content + b"trailing")
    assert len(Document(path).faces().sides) == 2


@pytest.mark.parametrize(
    ("keys", "problem"),
    [
        ({"accessors": [{"count": 3, "bufferView": 0}] * 2}, "not a readable GLB file (KeyError: 'type')"),
        ({"asset": {"version": "1.0"}, "meshes": {"m": {}}}, "it is of glTF 1.0; export it as glTF 2.0"),
        ({"bufferViews": []}, "bufferViews[0] does not exist; there are 0"),
        ({"meshes": [{"primitives": [{"attributes": {"POSITION": -1}}]}]}, "accessors[-1] does not exist"),
        (
            {"meshes": [{"primitives": [{"attributes": {"POSITION": 1}}]}]},
            "accessors[1] has the type SCALAR, not VEC3",
        ),
        (
            {"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]},
            "a primitive has 4 corners, which ",
        ),
        (
            {"nodes": [{"children": [1]}, {"children": [2]}, {"children": [1]}]},
            "node 1 stands twice in its tree",
        ),
        (
            {"nodes": [{"children": [k + 1]} for k in range(600)] + [{}]},
            "its nodes stand more than 500 below",
        ),
    ],
)
def test_files_that_are_refused(tmp_path: Path, made: Made, keys: dict[str, Any], problem: str) -> None:
    made.node()
    made.tree.update(keys)
    assert refused(tmp_path, made).startswith(problem)


@pytest.mark.parametrize(
    ("number", "keys", "problem"),
    [
        (0, {"count": 5}, "bufferViews[0] has 48 bytes, not the 60 announced"),
        (0, {"byteOffset": -12}, "bufferViews[0] has 48 bytes, not the 36 announced"),
        (0, {"count": 2}, "a primitive names vertex 3; there are 2, counted from 0"),
        (0, {"bufferView": None}, "a primitive has no data"),
        (
            0,
            {"count": 10**12, "bufferView": None, "sparse": {}},
            "accessors[0] announces 1000000000000 ",
        ),
    ],
)
def test_accessors_that_are_refused(
    tmp_path: Path, made: Made, number: int, keys: dict[str, Any], problem: str
) -> None:
    made.node()
    table = made.tree["accessors"][number]
    table.update(keys)
    if table["bufferView"] is None:
        del table["bufferView"]
    assert refused(tmp_path, made).startswith(problem)


def test_the_work_grows_with_the_number_of_nodes(
    tmp_path: Path, made: Made, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks = 0
    version = files._version

    def count(path: Path) -> tuple[int, int]:
        nonlocal looks
        looks += 1
        return version(path)

    monkeypatch.setattr(files, "_version", count)
    made.tree["nodes"] = [{"mesh": 0, "name": "n", "translation": [k, 0.125, 0]} for k in range(2000)]
    made.tree["scenes"][0]["nodes"] = [*range(2000)]
    (tmp_path / "a.glb").write_bytes(made.glb())
    before = transforms._composed.cache_info().misses
    scene = load(tmp_path / "a.glb")
    assert scene.object[-1].name == "n.1999"
    # Whether the file has changed is looked for once a pass, and every matrix is made once.
    assert looks <= 3 and transforms._composed.cache_info().misses - before <= 2000
