"""A folder for other programs, read back by others."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.errors import HsrError
from hsr.lab.export import as_written, export
from hsr.testing import from_ids, from_png

NAMES = {
    "README.md",
    "admissible.json",
    "camera.json",
    "expected.npy",
    "expected.npz",
    "expected.png",
    "faces.json",
    "scene.glb",
    "scene.obj",
    "triangle_face.csv",
}


def read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def owners(folder: Path) -> Any:
    """The face of every triangle."""
    table = np.loadtxt(folder / "triangle_face.csv", int, delimiter=",", skiprows=1)
    assert np.array_equal(table[:, 0], np.arange(len(table)))
    return table[:, 1]


def obj_triangles(path: Path) -> tuple[Any, list[int]]:
    """The corners (n, 3, 3) of the triangles of an OBJ file, and the numbers of their groups."""
    rows = [line.split() for line in path.read_text(encoding="utf-8").splitlines()]
    points = np.array([row[1:] for row in rows if row[0] == "v"], dtype=np.float64)
    corners, groups, group = [], [], -1
    for row in rows:
        if row[0] == "g":
            group = int(row[1].removeprefix("face_"))
        elif row[0] == "f":
            corners.append([int(corner) - 1 for corner in row[1:]])
            groups.append(group)
    return points[corners], groups


@pytest.fixture(scope="module", params=["cyclic", "solids", "mirrored", "polyhedra", "concave", "menger"])
def written(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[hsr.View, Path]:
    """A view, and the folder it was exported to."""
    folder = tmp_path_factory.mktemp("export") / request.param
    view = hsr.view(hsr.load(request.param), (48, 32))
    export(view, folder, "made | $up")
    return view, folder


def test_both_meshes_hold_the_same_float32_numbers(written: tuple[hsr.View, Path]) -> None:
    trimesh = pytest.importorskip("trimesh")
    view, folder = written
    mesh = trimesh.load(folder / "scene.glb", process=False, force="mesh")
    triangles, groups = obj_triangles(folder / "scene.obj")
    assert np.array_equal(mesh.vertices[mesh.faces], triangles)
    assert np.array_equal(triangles, triangles.astype(np.float32))
    assert np.array_equal(triangles, view.tessellated().triangles.astype(np.float32))
    owner = owners(folder)
    assert groups == owner.tolist() == view.tessellated().triangle_face.tolist()
    assert np.array_equal(mesh.vertex_attributes["_FACE_ID"].ravel(), np.repeat(owner, 3))


def test_our_own_reader_reads_the_same_triangles(written: tuple[hsr.View, Path]) -> None:
    _, folder = written
    triangles, _ = obj_triangles(folder / "scene.obj")
    for name in ("scene.obj", "scene.glb"):
        back = hsr.view(hsr.load(folder / name), (8, 8))
        assert np.array_equal(back.triangles, triangles)


def test_all_that_is_expected_is_one_thing(written: tuple[hsr.View, Path]) -> None:
    view, folder = written
    assert {path.name for path in folder.iterdir()} == NAMES
    expected = hsr.load_map(folder / "expected.npz")
    assert np.array_equal(np.load(folder / "expected.npy"), expected.face)
    assert np.array_equal(from_png(folder / "expected.png").face, expected.face)
    ties = {
        (tie["x"], tie["y"]): frozenset(tie["faces"]) for tie in read(folder / "admissible.json")["samples"]
    }
    assert expected.admissible is not None and len(ties) == len(expected.admissible.sample)
    for (x, y), faces in ties.items():
        assert faces == expected.admissible.faces(y * expected.width + x) and len(faces) > 1
    objects = read(folder / "faces.json")["objects"]
    assert (
        expected.manifest
        == view.manifest
        == [{k: v for k, v in one.items() if k != "cull"} for one in objects]
    )
    assert np.array_equal(hsr.render(as_written(view), "exact").face, expected.face)
    # Rounding moves edges by far less than a pixel.
    assert np.mean(expected.face != hsr.render(view.tessellated(), "exact").face) < 0.01


def test_the_readme_says_what_is_there(written: tuple[hsr.View, Path]) -> None:
    _, folder = written
    text = (folder / "README.md").read_text(encoding="utf-8")
    assert text.startswith("# made | $up\n") and text.count("$") == 1
    assert set(re.findall(r"^\| `([\w.]+)`", text, flags=re.MULTILINE)) | {"README.md"} == NAMES


def test_the_python_of_the_readme_runs(
    written: tuple[hsr.View, Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _, folder = written
    face, owner = np.load(folder / "expected.npy"), owners(folder)
    first = np.searchsorted(owner, face)  # some triangle of the face
    np.save(folder.parent / "yours.npy", np.where(face < 0, -1, first))
    code = re.findall(
        r"^    (import hsr.*?)\n\n", (folder / "README.md").read_text("utf-8"), re.DOTALL | re.MULTILINE
    )
    monkeypatch.chdir(folder)
    exec(re.sub(r"^    ", "", code[0], flags=re.MULTILINE).replace("yours.npy", "../yours.npy"), {})
    assert capsys.readouterr().out == "ids vs exact  48x32  0 differ\n"


def test_the_truth_is_that_of_the_rounded_numbers(tmp_path: Path, make_scene: Any) -> None:
    """Two squares that are apart in float64, and one in float32: either may own what both cover."""
    front, back = (
        {"name": n, "shape": "square", "transform": [{"translate": [0, 0, 1 + z]}]}
        for n, z in (("a", 1e-9), ("b", 0))
    )
    view = hsr.view(make_scene([back, front]), (16, 16))
    assert hsr.render(view, "exact").face.max() == 1 and set(np.unique(hsr.render(view, "exact").face)) == {
        -1,
        1,
    }
    truth = export(view, tmp_path / "out", "squares")
    assert truth.admissible is not None
    assert truth.admissible.faces(8 * 16 + 8) == {0, 1} and truth.face[8, 8] == 0


def test_what_is_culled_takes_no_part_and_is_told(tmp_path: Path, make_scene: Any) -> None:
    """Mirrored by its transform, too: the loops that are written run counter-clockwise from the front."""
    wall = {"name": "wall", "shape": "square", "cull": "back", "transform": [{"scale": [-1, 1, 1]}]}
    box = {"name": "box", "shape": "cube", "cull": "front"}
    view = hsr.view(make_scene([wall, box]), (24, 24))
    truth = export(view, tmp_path / "out", "culled")
    assert [one["cull"] for one in read(tmp_path / "out" / "faces.json")["objects"]] == ["back", "front"]
    assert np.array_equal(truth.face, hsr.render(view, "exact").face)
    (first, *_), _ = obj_triangles(tmp_path / "out" / "scene.obj")
    normal = np.cross(first[1] - first[0], first[2] - first[0])
    kept = bool((hsr.render(view, "exact").face == 0).any())
    assert (normal @ (np.array([0.3, 0.4, 5.0]) - first[0]) > 0) == kept


def test_ids_of_another_are_judged_by_the_written_map(tmp_path: Path) -> None:
    export(hsr.view(hsr.load("coplanar"), (24, 16)), tmp_path / "out", "coplanar")
    expected = hsr.load_map(tmp_path / "out" / "expected.npz")
    assert expected.admissible is not None and len(expected.admissible.sample)
    other = expected.face.copy()
    k = int(expected.admissible.sample[0])
    other.flat[k] = max(expected.admissible.faces(k) - {int(other.flat[k])})
    assert hsr.compare(from_ids(other), expected).same
    other.flat[k] = 7
    assert not hsr.compare(from_ids(other), expected).same


def test_what_cannot_be_exported_leaves_no_folder(tmp_path: Path, make_scene: Any, monkeypatch: Any) -> None:
    far = {"name": "far", "shape": "square", "transform": [{"scale": 1e39}]}
    with pytest.raises(HsrError, match="beyond float32"):
        export(hsr.view(make_scene([far]), (8, 8)), tmp_path / "out", "far")
    monkeypatch.setattr("hsr.lab.export.MOST_FACES", 5)
    with pytest.raises(HsrError, match=r"^6 faces: of more than 5 no picture"):
        export(hsr.view(hsr.load("cube"), (8, 8)), tmp_path / "out", "cube")
    assert not [*tmp_path.iterdir()]


def test_a_folder_that_is_taken_is_refused_before_the_work(tmp_path: Path, monkeypatch: Any) -> None:
    (tmp_path / "mine.txt").touch()
    monkeypatch.setattr("hsr.lab.export.render", None)
    with pytest.raises(HsrError, match="there is something already"):
        export(hsr.view(hsr.load("cube"), (8, 8)), tmp_path, "cube")
