"""The command ``hsr render``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

import hsr

CUBE = "scenes/cube.toml"


def test_render_writes_map_and_picture(run: Any, tmp_path: Path) -> None:
    target, picture = tmp_path / "map.npz", tmp_path / "cube.png"
    code, out, _ = run("render", CUBE, "--size", "40x30", "-o", str(target), "--png", str(picture))
    assert code == 0 and "zbuffer" in out and f"wrote {target}" in out
    assert hsr.load_map(target).face.shape == (30, 40)
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_render_names_files_after_methods(run: Any, tmp_path: Path) -> None:
    code, _, _ = run(
        "render", CUBE, "--size", "16", "-a", "zbuffer", "-a", "raycast", "-o", str(tmp_path / "m.npz")
    )
    assert code == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["m.raycast.npz", "m.zbuffer.npz"]


def test_render_json(run: Any) -> None:
    code, out, _ = run("render", CUBE, "--size", "16", "--json")
    (row,) = json.loads(out)["maps"]
    assert code == 0 and row["method"] == "zbuffer" and row["size"] == [16, 16] and row["faces_seen"] == 3


def test_python_and_command_agree(run: Any, tmp_path: Path, scenes: Path) -> None:
    run("render", CUBE, "--size", "20", "-a", "raycast", "-o", str(tmp_path / "m.npz"))
    here = hsr.render(hsr.load(scenes / "cube.toml"), "raycast", size=(20, 20))
    assert np.array_equal(hsr.load_map(tmp_path / "m.npz").face, here.face)
