"""The command ``hsr scene``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

import hsr
from hsr.scene.info import schema

CUBE = "scenes/cube.toml"


def test_scene_check(run: Any, tmp_path: Path) -> None:
    bad = tmp_path / "bad.toml"
    bad.write_text('hsr = 1\ncolor = 3\n[[object]]\nname = "a"\nshape = "cub"\n', encoding="utf-8")
    assert run("scene", "check", CUBE)[:2] == (0, f"{CUBE}: ok\n")
    code, out, _ = run("scene", "check", CUBE, str(bad))
    assert code == 2 and "color" in out and "did you mean 'cube'" in out
    assert len(json.loads(run("scene", "check", str(bad), "--json")[1])["problems"][str(bad)]) == 2


def test_scene_info_and_schema(run: Any, tmp_path: Path) -> None:
    assert "cube" in run("scene", "info", CUBE)[1]
    assert json.loads(run("scene", "info", CUBE, "--json")[1])
    assert json.loads(run("scene", "schema")[1])["properties"]["hsr"]
    target = tmp_path / "schema.json"
    assert run("scene", "schema", str(target))[0] == 0 and json.loads(target.read_text(encoding="utf-8"))


def test_scene_init_writes_what_can_be_edited(run: Any, tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    mesh, target = tmp_path / "meshes" / "t.obj", tmp_path / "t.toml"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", encoding="utf-8")
    code, out, _ = run("scene", "init", str(mesh), "-o", str(target))
    assert code == 0 and out == f"wrote {target}; 'hsr render {target}' shows it\n"
    text = target.read_text(encoding="utf-8")
    assert 'file = "meshes/t.obj"' in text and "# far =\n" in text and '# cull = "none"\n' in text
    before, after = hsr.load(mesh), hsr.load(target)
    assert (after.camera, after.light) == (before.camera, before.light)
    assert hsr.view(after, (8, 8)).hashes == hsr.view(before, (8, 8)).hashes
    lines = [line for line in text.splitlines() if line]
    assert all(line.startswith(("#", "[[")) or lines[k - 1].startswith("# ") for k, line in enumerate(lines))


def test_the_schema_describes_every_key() -> None:
    whole = schema()
    tables = {"Scene": whole, **whole["$defs"]}
    bare = [
        f"{name}.{key}"
        for name, table in tables.items()
        for key, what in table.get("properties", {}).items()
        if "description" not in what
    ]
    assert bare == []


def test_scene_export(run: Any, tmp_path: Path) -> None:
    target = tmp_path / "made" / "cube"
    code, out, err = run(
        "scene", "export", CUBE, "-o", str(target), "--size", "24x16", "--eye", "2,2,4", "--far", "9"
    )
    assert (code, err) == (0, "") and out == f"wrote {target}; {target / 'README.md'} says how to compare\n"
    camera = json.loads((target / "camera.json").read_text(encoding="utf-8"))
    assert camera["size"] == [24, 16] and camera["far"] == 9.0
    assert run("diff", str(target / "expected.png"), str(target / "expected.npz"))[0] == 0
    np.save(
        tmp_path / "yours.npy", 2 * np.load(target / "expected.npy")
    )  # two triangles to a face, -2 for none
    told = (
        str(tmp_path / "yours.npy"),
        str(target / "expected.npz"),
        "--faces",
        str(target / "triangle_face.csv"),
    )
    assert run("diff", *told, "--background", "-2")[0] == 0
    before = {path: path.read_bytes() for path in target.iterdir()}
    code, out, err = run("scene", "export", CUBE, "-o", str(target))
    assert code == 2 and "there is something already, which is left as it is" in err and out == ""
    assert {path: path.read_bytes() for path in target.iterdir()} == before


def test_scene_export_needs_one_camera_and_a_folder(run: Any, two: str, tmp_path: Path) -> None:
    code, _, err = run("scene", "export", two, "-o", str(tmp_path / "out"), "--camera", "all")
    assert code == 2 and "choose one by --camera" in err
    assert run("scene", "export", two)[0] == 2
    assert run("scene", "export", two, "-o", str(tmp_path / "out.png"))[0] == 2
    assert not (tmp_path / "out").exists()
