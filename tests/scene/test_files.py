"""Loading scene files and mesh files."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.errors import SceneError
from hsr.scene.camera import projection_of
from hsr.scene.files import load, shape_of
from hsr.scene.model import Perspective, Scene
from hsr.scene.shapes import MAX_FACES

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
CAMERA = '[[camera]]\ntype = "perspective"\neye = [0, 0, 5]\n'


def write(folder: Path, **files: str) -> None:
    for name, text in files.items():
        stem, _, ending = name.rpartition("_")
        (folder / f"{stem}.{ending}").write_text(text, encoding="utf-8")


def problems_of(path: Path) -> list[str]:
    with pytest.raises(SceneError) as caught:
        load(path)
    lines = str(caught.value).splitlines()
    assert all(line.startswith(f"{path}: ") for line in lines)
    return [line.removeprefix(f"{path}: ") for line in lines]


def scene_text(*objects: str) -> str:
    tables = [f'[[object]]\nname = "object {k}"\n{text}\n' for k, text in enumerate(objects)]
    return CAMERA + "".join(tables)


# ---------------------------------------------------------------- scene files


def test_toml_and_json_are_the_same_scene(tmp_path: Path) -> None:
    write(tmp_path, a_toml=scene_text('shape = "cube"\ntransform = [{ scale = 2 }]'))
    table = {"name": "object 0", "shape": "cube", "transform": [{"scale": 2}]}
    write(
        tmp_path,
        a_json=json.dumps({"camera": [{"type": "perspective", "eye": [0, 0, 5]}], "object": [table]}),
    )
    assert load(tmp_path / "a.toml") == load(tmp_path / "a.json")


def test_endings_in_capitals_and_a_byte_order_mark(tmp_path: Path) -> None:
    (tmp_path / "A.TOML").write_bytes(b"\xef\xbb\xbf" + scene_text('shape = "cube"').encode())
    assert load(tmp_path / "A.TOML").object[0].shape == "cube"


def test_every_problem_of_a_scene_is_reported_at_once(tmp_path: Path) -> None:
    objects = (
        'shape = "cube"\ncolour = 3',
        'shape = "mesh"\nfile = "tripot.obj"',
        'shape = "mesh"\nfile = "nan.obj"\ntransform = [{ scale = 1e-200 }, { scale = 1e-200 }]',
        'shape = "polyhedron"\nvertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]\n'
        "faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 2, 3]]",
        'shape = "mesh"\nvertices = []\nfaces = []',
    )
    flat = '[[camera]]\nname = "b"\ntype = "matrix"\nmatrix = [[1,0,0,0],[0,1,0,0],[0,0,1,0],[1,0,0,1]]\n'
    write(
        tmp_path,
        a_toml=flat + scene_text(*objects),
        tripod_obj=TRIANGLE,
        nan_obj=TRIANGLE.replace("1 0 0", "nan 0 0"),
    )
    assert problems_of(tmp_path / "a.toml") == [
        "object[0].colour: expected a list, got 3",
        "camera[0]: its near plane is oblique; the third row must be parallel to the fourth",
        "object[1].file: tripot.obj: no such file; did you mean 'tripod.obj'?",
        "object[2].transform: the steps together over- or underflow float64; use less extreme numbers",
        "object[2].file: nan.obj: vertex 1 (counted from 0) is not finite: nan 0 0",
        "object[3].faces[3]: its corners run clockwise as seen from outside; reverse them",
        "object[4].faces: the mesh has no faces",
    ]


def test_meshes_are_read_while_loading(tmp_path: Path) -> None:
    write(tmp_path, a_toml=scene_text('shape = "mesh"\nfile = "no.obj"'))
    assert problems_of(tmp_path / "a.toml") == ["object[0].file: no.obj: no such file"]


@pytest.mark.parametrize(
    ("file", "problem"),
    [
        ("notes.txt", "not a mesh file; the endings are .obj .ply .stl .off .glb .gltf"),
        ("sub", "this is a folder; name a file in it"),
    ],
)
def test_files_that_are_no_meshes(tmp_path: Path, file: str, problem: str) -> None:
    write(tmp_path, a_toml=scene_text(f'shape = "mesh"\nfile = "{file}"'), notes_txt="hello")
    (tmp_path / "sub").mkdir()
    assert problems_of(tmp_path / "a.toml") == [f"object[0].file: {file}: {problem}"]


def test_only_gltf_files_have_parts(tmp_path: Path) -> None:
    write(tmp_path, a_toml=scene_text('shape = "mesh"\nfile = "t.obj"\npart = "x"'), t_obj=TRIANGLE)
    problem = "only GLB and glTF files have parts; leave out the key 'part'"
    assert problems_of(tmp_path / "a.toml") == [f"object[0].file: t.obj: {problem}"]


def test_more_faces_than_int32_numbers(tmp_path: Path) -> None:
    scatter = "scatter = { count = 1000000, x = [0, 1], z = [0, 1] }"
    write(tmp_path, a_toml=scene_text('shape = "cube"', f'shape = "terrain"\n{scatter}'))
    problem = f"object[1]: with it, the scene has 32768000006 faces; {MAX_FACES} are the most"
    assert problems_of(tmp_path / "a.toml") == [problem]


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("a.toml", b"a = [1", "not valid TOML: Unclosed array (at end of document)"),
        ("a.toml", b"a = 1\na = 2", "not valid TOML: Cannot overwrite a value (at end of document)"),
        ("a.json", b'{"a":', "not valid JSON: Expecting value: line 1 column 6 (char 5)"),
        ("a.json", b'{"a": 1, "a": 2}', "not valid JSON: the key 'a' stands twice in a table"),
        ("a.json", b"[1]", "expected a table, got [1]"),
        ("a.json", b"[" * 100_000, "not valid JSON: maximum recursion depth exceeded"),
        ("a.toml", b"title = '\xff'", "not UTF-8 text (at byte 9); save it as UTF-8"),
        ("a.obj", b"", "the mesh has no faces"),
        ("a.glb", b"glTF", "it does not start as a GLB file of version 2 does"),
        ("a.gltf", b"{}", "no node of its scene has a mesh with triangles"),
        (
            "a.blend",
            b"",
            "not a scene or mesh file; the endings are .toml .json .obj .ply .stl .off .glb .gltf",
        ),
    ],
)
def test_files_that_cannot_be_read(tmp_path: Path, name: str, content: bytes, problem: str) -> None:
    (tmp_path / name).write_bytes(content)
    (line,) = problems_of(tmp_path / name)
    assert line.startswith(problem)


@pytest.mark.parametrize("name", ["a.toml", "a.obj", "a.glb"])
def test_files_that_may_not_be_read(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    (tmp_path / name).write_text("")
    monkeypatch.setattr(Path, "read_text", refuse)
    monkeypatch.setattr(Path, "read_bytes", refuse)
    with pytest.raises(SceneError, match=rf"{name}: cannot be read: Permission denied$"):
        load(tmp_path / name)


def test_a_name_too_long_for_the_system(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="cannot be read: File name too long"):
        load(tmp_path / ("a" * 300 + ".toml"))


def test_a_name_that_no_file_of_ours_can_hold(tmp_path: Path) -> None:
    path = tmp_path / os.fsdecode(b"caf\xe9.obj")
    path.write_text(TRIANGLE)
    with pytest.raises(SceneError, match=r"caf\\udce9.obj: its name is not text in UTF-8; rename it$"):
        load(path)


def test_a_folder_is_no_scene(tmp_path: Path) -> None:
    (tmp_path / "a.toml").mkdir()
    assert problems_of(tmp_path / "a.toml") == ["this is a folder; name a file in it"]


def test_a_missing_file_has_a_near_name(tmp_path: Path) -> None:
    write(tmp_path, cube_toml=scene_text('shape = "cube"'))
    assert problems_of(tmp_path / "cubes.toml") == ["no such file; did you mean 'cube.toml'?"]
    assert problems_of(tmp_path / "no" / "cubes.toml") == ["no such file"]


def test_a_scene_made_in_python_is_checked_when_it_is_seen(make_scene: Any) -> None:
    scene: Scene = make_scene([{"name": "pot", "shape": "mesh", "file": "no-such.obj"}])
    with pytest.raises(SceneError, match=r"^object 'pot': file: no-such.obj: no such file"):
        hsr.view(scene)


# ---------------------------------------------------------------- shapes


def test_objects_of_one_shape_share_it(tmp_path: Path) -> None:
    same = 'shape = "mesh"\nvertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\nfaces = [[0, 1, 2]]'
    texts = [
        same,
        f"{same}\ncull = 'back'",
        'shape = "mesh"\nfile = "t.obj"',
        'shape = "mesh"\nfile = "t.obj"',
    ]
    texts += [
        'shape = "teapot"\ndetail = 2',
        'shape = "teapot"\ndetail = 2\ncolour = [1, 0, 0]',
        'shape = "teapot"',
    ]
    write(tmp_path, a_toml=scene_text(*texts), t_obj=TRIANGLE)
    scene = load(tmp_path / "a.toml")
    shapes = [shape_of(thing, scene.folder) for thing in scene.object]
    assert shapes[0] is shapes[1] and shapes[2] is shapes[3] and shapes[4] is shapes[5]
    assert len({id(shape) for shape in shapes}) == 4


def test_a_changed_file_is_read_again(tmp_path: Path) -> None:
    write(tmp_path, t_obj=TRIANGLE)
    scene = load(tmp_path / "t.obj")
    before = shape_of(scene.object[0], scene.folder)
    assert shape_of(scene.object[0], scene.folder) is before
    write(tmp_path, t_obj=TRIANGLE + "f 3 2 1\n")
    after = shape_of(scene.object[0], scene.folder)
    assert (before.faces, after.faces) == (1, 2)
    os.utime(tmp_path / "t.obj", ns=(1, 1))
    assert shape_of(scene.object[0], scene.folder) is not after


# ---------------------------------------------------------------- mesh files as scenes


@pytest.mark.parametrize("aspect", [0.2, 1.0, 5.0])
def test_the_fitted_camera_has_the_whole_mesh_in_view(tmp_path: Path, aspect: float) -> None:
    random = np.random.default_rng(1)
    corners = random.normal(size=(60, 3)) * [3.0, 1.0, 0.2] + [100.0, -50.0, 7.0]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {k} {k + 1} {k + 2}" for k in range(1, 58)]
    # A vertex that no face uses must not count.
    write(tmp_path, a_obj="\n".join([*lines, "v 1e9 0 0"]))
    scene = load(tmp_path / "a.obj")
    (camera,) = scene.camera
    assert isinstance(camera, Perspective) and camera.name == "fitted" and camera.far is None
    projection = projection_of(camera, aspect)
    x, y, _, w = projection.clip_from_world @ np.column_stack([corners[:59], np.ones(59)]).T
    assert np.abs(x / w).max() < 1.0 and np.abs(y / w).max() < 1.0
    assert max(np.abs(x / w).max(), np.abs(y / w).max()) > 0.2
    assert w.min() > projection.near > 0.2 * w.min()
    assert scene.light and scene.object[0].name == "a"


def test_a_single_point_can_be_looked_at(tmp_path: Path) -> None:
    write(tmp_path, a_obj="v 1 2 3\nf 1 1 1\n")
    view = hsr.view(load(tmp_path / "a.obj"), (8, 8))
    assert view.near > 0.0 and view.faces == 1


def test_the_built_in_scenes_load(scenes: Path) -> None:
    for path in sorted(scenes.glob("*.toml")):
        assert load(path).title


def test_a_scene_file_without_a_camera_gets_one_that_sees_all(tmp_path: Path) -> None:
    strewn = 'shape = "fir"\nscatter = { count = 9, x = [-4, 4], z = [-4, 4] }'
    write(tmp_path, a_toml=scene_text(strewn, 'shape = "sphere"').replace(CAMERA, ""))
    scene = load(tmp_path / "a.toml")
    assert [camera.name for camera in scene.camera] == ["fitted"]
    seen = hsr.render(scene, "raycast", (64, 64))
    assert len(np.unique(seen.face)) > 9
    border = np.concatenate([seen.face[[0, -1]].ravel(), seen.face[:, [0, -1]].ravel()])
    assert (border == -1).all()


def test_built_in_scenes_have_names(scenes: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    assert load("teapot") == load(scenes / "teapot.toml") and load(Path("cube")).title == "Cube"
    with pytest.raises(SceneError, match=r"no file and no built-in scene 'teapt'; did you mean 'teapot'\?"):
        load("teapt")
    with pytest.raises(SceneError, match=r"^teapot.toml: no such file; did you mean 'teapot'\?"):
        load("teapot.toml")
    (tmp_path / "cube").mkdir()
    with pytest.raises(SceneError, match="cube: "):
        load("cube")  # an existing path wins


@pytest.mark.parametrize(
    ("asked", "meant"), [("cub.toml", "cube.toml"), ("cube.ply", "cube.toml"), ("bunny.toml", "")]
)
def test_files_are_suggested_if_their_names_are_alike(tmp_path: Path, asked: str, meant: str) -> None:
    write(tmp_path, cube_toml="", torus_toml="", notes_txt="")
    assert problems_of(tmp_path / asked) == [
        f"no such file; did you mean {meant!r}?" if meant else "no such file"
    ]
