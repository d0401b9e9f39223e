"""What is exported, drawn by others from the files alone: Embree by way of trimesh, and tinyrenderer.

They compute in float32. Every sample must show a face that may own it or, by exact arithmetic, a place
``NEXT`` pixels beside it. No other difference is allowed.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.arrays import Bools, Ints
from hsr.cli import app
from hsr.lab.export import as_written, export
from hsr.pictures.png import save_picture

NEXT = 1.0 / 512.0
"""Of a pixel; float32 moves what these scenes show by some 2^-16 of one."""

trimesh = pytest.importorskip("trimesh")


def exported(folder: Path, name: str, size: tuple[int, int], **camera: Any) -> hsr.View:
    scene = hsr.load(name)
    seen = hsr.Orthographic(**camera) if "height" in camera else hsr.Perspective(**camera) if camera else None
    view = hsr.view(scene, size, seen)
    export(view, folder, name)
    return view


def unexplained(view: hsr.View, face: Ints) -> Bools:
    """Tell where (H, W) a map shows a face that owns neither the sample nor a place next to it."""
    seen = as_written(view)
    wrong: Bools = ~hsr.render(seen, "exact").admits(face)
    for across, down in ((-1, -1), (-1, 1), (1, -1), (1, 1), (-1, 0), (1, 0), (0, -1), (0, 1)):
        if not wrong.any():
            break
        clip = seen.clip_from_world.copy()
        clip[0] -= 2.0 * NEXT * across / seen.width * clip[3]
        clip[1] += 2.0 * NEXT * down / seen.height * clip[3]
        wrong &= ~hsr.render(replace(seen, clip_from_world=clip), "exact").admits(face)
    return wrong


def embree(folder: Path) -> Ints:
    """Cast a ray through the centre of every pixel, by OpenCV's camera, at the binary mesh."""
    tracer = pytest.importorskip("trimesh.ray.ray_pyembree")
    told = json.loads((folder / "camera.json").read_text(encoding="utf-8"))
    mesh = trimesh.load(folder / "scene.glb", process=False, force="mesh")
    (width, height), frame = told["size"], np.array(told["opencv"]["camera_from_world"])
    row, column = np.mgrid[:height, :width]
    pixels = np.stack([column.ravel(), row.ravel(), np.ones(width * height)])
    flat = np.linalg.solve(told["opencv"]["K"], pixels).T
    if told["perspective"]:
        origin, ray = np.zeros_like(flat), flat
    else:
        origin, ray = flat * [1.0, 1.0, 0.0], np.broadcast_to([0.0, 0.0, 1.0], flat.shape)
    origin, ray = (origin - frame[:3, 3]) @ frame[:3, :3], ray @ frame[:3, :3]
    hit = tracer.RayMeshIntersector(mesh, scale_to_box=False).intersects_first(origin, ray)
    face = mesh.vertex_attributes["_FACE_ID"].ravel()[mesh.faces[hit, 0]]
    return np.where(hit < 0, -1, face).astype(np.int32).reshape(height, width)


VIEWS: dict[str, tuple[str, dict[str, Any]]] = {
    "teapot": ("teapot", {}),
    "curved": ("solids", {}),
    "overlap": ("cyclic", {}),
    "culled by nothing, mirrored": ("mirrored", {}),
    "quads": ("menger", {}),
    "coincident": ("coplanar", {}),
    "parallel": ("interpenetrating", {"eye": (3, 2, 4), "height": 4.0, "far": 20.0}),
    "close": ("torus-knot", {"eye": (2.1, 1.3, 2.2), "fov": 60.0}),
}


@pytest.mark.jit
@pytest.mark.parametrize("name", VIEWS)
def test_embree(name: str, tmp_path: Path) -> None:
    scene, camera = VIEWS[name]
    view = exported(tmp_path / "out", scene, (96, 64), **camera)
    face = embree(tmp_path / "out")
    expected = hsr.load_map(tmp_path / "out" / "expected.npz")
    wrong = ~expected.admits(face)
    assert (face >= 0).mean() > 0.05
    assert not unexplained(view, face).any()
    assert wrong.sum() <= 2


@pytest.mark.jit
def test_the_truth_is_that_of_rounded_numbers(tmp_path: Path, make_scene: Any) -> None:
    """A million units away float32 moves corners by a sixteenth: what is written is another scene."""
    away = {"translate": [1e6, 0.3, -1e6]}
    box = {"name": "box", "shape": "cube", "transform": [{"rotate_y": 30.0}, away]}
    ball = {"name": "ball", "shape": "sphere", "transform": [{"translate": [1.5, 0.0, 0.5]}, away]}
    camera = {"eye": [1e6 + 1, 2, 5 - 1e6], "target": [1e6, 0, -1e6], "far": 100.0}
    view = hsr.view(make_scene([box, ball], **camera), (96, 64))
    truth = export(view, tmp_path / "out", "far away")
    face = embree(tmp_path / "out")
    assert (~truth.admits(face)).sum() <= 2 and not unexplained(view, face).any()
    assert (hsr.render(view.tessellated(), "exact").face != truth.face).sum() > 20


@pytest.mark.jit
def test_hsr_diff_judges_its_picture(tmp_path: Path, monkeypatch: Any, capsys: Any) -> None:
    exported(tmp_path / "out", "cyclic", (96, 64))
    face = embree(tmp_path / "out")
    colours = np.stack([(face + 1) >> shift & 255 for shift in (16, 8, 0)], axis=-1).astype(np.uint8)
    for picture, code in ((colours, 0), (colours[::-1].copy(), 1)):
        save_picture(picture, tmp_path / "yours.png")
        told = ["hsr", "diff", str(tmp_path / "yours.png"), str(tmp_path / "out" / "expected.npz")]
        monkeypatch.setattr("sys.argv", told)
        with pytest.raises(SystemExit) as ended:
            app.main()
            raise SystemExit(0)
        assert (ended.value.code or 0) == code
    assert "turned upside down: explains" in capsys.readouterr().out


def tinyrenderer(folder: Path) -> Ints:
    """Draw the text mesh, a face an object, by OpenGL's matrices; its samples are lower left corners."""
    tiny = pytest.importorskip("pytinyrenderer")
    told = json.loads((folder / "camera.json").read_text(encoding="utf-8"))
    (width, height), camera = told["size"], told["opengl"]
    rows = [line.split() for line in (folder / "scene.obj").read_text(encoding="utf-8").splitlines()]
    points = [list(map(float, row[1:])) for row in rows if row[0] == "v"]
    scene, light = tiny.TinySceneRenderer(), tiny.TinyRenderLight(has_shadow=False)
    things, face = [], 0
    for word, *rest in rows:
        if word == "g":
            face = int(rest[0].removeprefix("face_"))
        elif word == "f":
            corners = [number for corner in rest for number in points[int(corner) - 1]]
            mesh = scene.create_mesh(corners, [0.0, 0.0, 1.0] * 3, [0.0] * 6, [0, 1, 2], [255] * 3, 1, 1, 1.0)
            things.append(scene.create_object_instance(mesh))
            scene.set_object_double_sided(things[-1], True)
            scene.set_object_segmentation_uid(things[-1], face + 1)
    project = np.array(camera["clip_from_camera"])
    project[0] -= project[3] / width
    project[1] -= project[3] / height
    columns = [np.ravel(matrix, order="F").tolist() for matrix in (camera["camera_from_world"], project)]
    picture = scene.get_camera_image(things, light, tiny.TinyRenderCamera(width, height, *columns))
    return np.reshape(picture.segmentation_mask, (height, width)).astype(np.int32) - 1


@pytest.mark.jit
@pytest.mark.parametrize("name", ["cyclic", "interpenetrating"])
def test_tinyrenderer(name: str, tmp_path: Path) -> None:
    view = exported(tmp_path / "out", name, (96, 64), eye=(2.5, 2.0, 4.0), far=100.0)  # it needs a far plane
    face = tinyrenderer(tmp_path / "out")
    assert (face >= 0).any() and not unexplained(view, face).any()
