"""glTF files: their node tree, their meshes, and cameras as the specification has them."""

from __future__ import annotations

import base64
import json
import math
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.errors import SceneError
from hsr.scene.camera import projection_of
from hsr.scene.files import load, shape_of
from hsr.scene.model import Mesh, Orthographic, Perspective
from hsr.scene.transforms import compose

TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype="<f4")
BUFFER = TRIANGLE.tobytes() + (TRIANGLE + np.float32(5)).tobytes() + struct.pack("<3H2x", 2, 1, 0)
QUARTER = math.sqrt(0.5)


def tree(**keys: Any) -> dict[str, Any]:
    """Two triangles (accessors 0 and 1), three indices that turn one around (2), and ``keys``."""
    points = {"componentType": 5126, "count": 3, "type": "VEC3"}
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(BUFFER)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 36},
            {"buffer": 0, "byteOffset": 72, "byteLength": 6},
        ],
        "accessors": [
            {**points, "bufferView": 0},
            {**points, "bufferView": 1},
            {"componentType": 5123, "count": 3, "type": "SCALAR", "bufferView": 2},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        **keys,
    }


def primitive(points: int, **keys: Any) -> dict[str, Any]:
    return {"attributes": {"POSITION": points}, **keys}


def write_glb(path: Path, content: dict[str, Any]) -> Path:
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    chunks = (
        struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(BUFFER), b"BIN\0") + BUFFER
    )
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
    return path


def load_glb(folder: Path, **keys: Any) -> hsr.Scene:
    return load(write_glb(folder / "a.glb", tree(**keys)))


# ---------------------------------------------------------------- nodes and meshes


def test_every_node_with_a_mesh_is_an_object(tmp_path: Path) -> None:
    nodes = [
        {"name": "root", "children": [1, 2], "translation": [10, 0, 0]},
        {
            "name": "child",
            "mesh": 0,
            "scale": [2, 2, 2],
            "rotation": [0, 0, QUARTER, QUARTER],
            "translation": [0, 3, 0],
        },
        {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1]},
        {"name": "not in the scene", "mesh": 0},
    ]
    scene = load_glb(tmp_path, nodes=nodes, scenes=[{}, {"nodes": [0]}], scene=1)
    assert [thing.name for thing in scene.object] == ["child", "mesh 0"]
    first, second = (compose(thing.transform) for thing in scene.object)
    # (1, 0, 0) is doubled, turned to +y, lifted by 3, and moved by the parent.
    assert np.allclose(first @ [1, 0, 0, 1], [10, 5, 0, 1], atol=1e-15)
    assert second[:3, 3].tolist() == [17.0, 8.0, 9.0]
    shapes = [shape_of(thing, scene.folder) for thing in scene.object]
    assert shapes[0] is shapes[1] and shapes[0].faces == 1


def test_without_a_scene_the_roots_are_the_nodes_that_are_no_children(tmp_path: Path) -> None:
    scene = load_glb(
        tmp_path, nodes=[{"mesh": 0}, {"name": "top", "children": [0], "translation": [1, 0, 0]}]
    )
    assert compose(scene.object[0].transform)[0, 3] == 1.0 and len(scene.object) == 1


def test_primitives_follow_one_another(tmp_path: Path) -> None:
    primitives = [primitive(1), primitive(0, mode=1), primitive(0, indices=2)]
    scene = load_glb(tmp_path, nodes=[{"mesh": 0}], meshes=[{"name": "m", "primitives": primitives}])
    polygons = shape_of(scene.object[0], scene.folder).polygons
    assert polygons is not None
    corners = polygons.vertices[polygons.triangle_vertex]
    assert np.array_equal(corners, [TRIANGLE + 5, TRIANGLE[::-1]])


def test_a_part_of_a_file_and_the_whole_of_it(tmp_path: Path) -> None:
    meshes = [{"name": "a", "primitives": [primitive(0)]}, {"name": "b", "primitives": [primitive(1)]}]
    nodes = [{"mesh": 0, "translation": [0, 0, 1]}, {"mesh": 1}, {"mesh": 0}]
    write_glb(tmp_path / "a.glb", tree(nodes=nodes, meshes=meshes))
    part = shape_of(Mesh(name="x", shape="mesh", file="a.glb", part="b"), tmp_path)
    whole = shape_of(Mesh(name="x", shape="mesh", file="a.glb"), tmp_path)
    assert part.polygons is not None and whole.polygons is not None
    assert np.array_equal(part.polygons.vertices, TRIANGLE + 5)
    assert np.array_equal(
        whole.polygons.vertices, np.concatenate([TRIANGLE + np.array([0, 0, 1]), TRIANGLE + 5, TRIANGLE])
    )
    with pytest.raises(SceneError, match=r"^object 'x': file: a.glb: no part is named 'c'; it has a, b$"):
        shape_of(Mesh(name="x", shape="mesh", file="a.glb", part="c"), tmp_path)


def test_text_gltf_with_its_buffer_inside(tmp_path: Path) -> None:
    content = tree(nodes=[{"mesh": 0}])
    uri = "data:application/octet-stream;base64," + base64.b64encode(BUFFER).decode()
    content["buffers"] = [{"byteLength": len(BUFFER), "uri": uri}]
    (tmp_path / "a.gltf").write_text(json.dumps(content))
    assert hsr.view(load(tmp_path / "a.gltf"), (4, 4)).faces == 1


def test_text_gltf_with_its_buffer_beside_it(tmp_path: Path) -> None:
    content = tree(nodes=[{"mesh": 0}])
    content["buffers"] = [{"byteLength": len(BUFFER), "uri": "a.bin"}]
    (tmp_path / "a.gltf").write_text(json.dumps(content))
    (tmp_path / "a.bin").write_bytes(BUFFER)
    assert hsr.view(load(tmp_path / "a.gltf"), (4, 4)).faces == 1


def test_names_are_made_different(tmp_path: Path) -> None:
    scene = load_glb(tmp_path, nodes=[{"name": "n", "mesh": 0}, {"name": "n", "mesh": 0}])
    assert [thing.name for thing in scene.object] == ["n", "n.1"]


# ---------------------------------------------------------------- cameras


def test_a_camera_stands_where_its_parents_put_it(tmp_path: Path) -> None:
    lens = {"type": "perspective", "perspective": {"yfov": math.pi / 3, "znear": 0.5}}
    nodes = [
        {"mesh": 0},
        {"children": [2], "translation": [10, 0, 0], "scale": [3, 3, 3]},
        {"name": "eye", "camera": 0, "rotation": [0, QUARTER, 0, QUARTER], "translation": [0, 1, 0]},
    ]
    scene = load_glb(tmp_path, nodes=nodes, cameras=[lens])
    camera, fitted = scene.camera
    assert fitted.name == "fitted" and isinstance(camera, Perspective)
    assert (camera.name, camera.near, camera.far, camera.fov_axis) == ("eye", 0.5, None, "y")
    assert camera.fov == pytest.approx(60.0, rel=1e-15)
    assert np.allclose(camera.eye, [10, 3, 0], atol=1e-14)
    # Turned by a quarter about +y, it looks along -x.
    sight = np.subtract(camera.target, camera.eye)
    assert np.allclose(sight / np.linalg.norm(sight), [-1, 0, 0], atol=1e-14)


def test_the_aspect_ratio_is_that_of_the_image(tmp_path: Path) -> None:
    lens = {"type": "perspective", "perspective": {"yfov": 1.0, "znear": 1, "zfar": 9, "aspectRatio": 7.0}}
    scene = load_glb(tmp_path, nodes=[{"mesh": 0}, {"camera": 0}], cameras=[lens])
    x_row, y_row, _, _ = projection_of(scene.camera[0], 2.0).clip_from_world
    assert y_row[1] == pytest.approx(1.0 / math.tan(0.5)) and x_row[0] == pytest.approx(y_row[1] / 2.0)
    assert isinstance(scene.camera[0], Perspective) and scene.camera[0].far == 9.0


def test_an_orthographic_camera(tmp_path: Path) -> None:
    lens = {
        "type": "orthographic",
        "orthographic": {"xmag": 3, "ymag": 2, "znear": 0, "zfar": 50},
        "name": "top",
    }
    camera = load_glb(tmp_path, nodes=[{"mesh": 0}, {"camera": 0}], cameras=[lens]).camera[0]
    assert isinstance(camera, Orthographic)
    assert (camera.name, camera.height, camera.near, camera.far) == ("top", 4.0, 0.0, 50.0)


def test_a_camera_of_the_file_may_be_called_fitted(tmp_path: Path) -> None:
    lens = {"type": "perspective", "perspective": {"yfov": 1.0, "znear": 1}}
    scene = load_glb(tmp_path, nodes=[{"mesh": 0}, {"camera": 0, "name": "fitted"}], cameras=[lens])
    assert [camera.name for camera in scene.camera] == ["fitted", "fitted.1"]


def test_an_eye_far_from_the_origin_keeps_its_direction(tmp_path: Path) -> None:
    lens = {"type": "perspective", "perspective": {"yfov": 1.0, "znear": 1}}
    node = {"camera": 0, "translation": [1e9, 0, 0], "rotation": [0, 0.1, 0, math.sqrt(0.99)]}
    camera = load_glb(tmp_path, nodes=[{"mesh": 0}, node], cameras=[lens]).camera[0]
    assert isinstance(camera, Perspective)
    sight = np.subtract(camera.target, camera.eye)
    expected = [-2 * 0.1 * math.sqrt(0.99), 0.0, -(1 - 2 * 0.01)]
    assert np.allclose(sight / np.linalg.norm(sight), expected, rtol=0.0, atol=4e-16)


# ---------------------------------------------------------------- problems

LINES = [{"primitives": [primitive(0, mode=1)]}]


@pytest.mark.parametrize(
    ("keys", "problem"),
    [
        ({"nodes": [{"mesh": 0}], "meshes": LINES}, "no node of its scene has a mesh with triangles"),
        ({"nodes": []}, "no node of its scene has a mesh with triangles"),
        (
            {"nodes": [{"children": [0], "mesh": 0}], "scenes": [{"nodes": [0]}]},
            "node 0 stands twice in its tree",
        ),
        (
            {"nodes": [{"mesh": 0, "scale": [1, 0, 1]}]},
            "node 0: scale: a scale of 0 makes the transform singular",
        ),
        ({"nodes": [{"mesh": 9}]}, "meshes[9] does not exist; there are 1"),
        (
            {
                "nodes": [
                    {"mesh": 0, "scale": [1e-200] * 3, "children": [1]},
                    {"mesh": 0, "scale": [1e-200] * 3},
                ]
            },
            "object[1]",
        ),
    ],
)
def test_files_that_are_refused(tmp_path: Path, keys: dict[str, Any], problem: str) -> None:
    with pytest.raises(SceneError) as caught:
        load_glb(tmp_path, **keys)
    assert str(caught.value).removeprefix(f"{tmp_path / 'a.glb'}: ").startswith(problem)
    assert "\n" not in str(caught.value)


def test_json_of_another_kind_is_no_gltf(tmp_path: Path) -> None:
    (tmp_path / "list.gltf").write_text("[]", encoding="utf-8")
    with pytest.raises(SceneError, match="no glTF: its outermost value is no object"):
        hsr.load(tmp_path / "list.gltf")
