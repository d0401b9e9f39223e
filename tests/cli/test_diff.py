"""The command ``hsr diff``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import hsr

CUBE = "scenes/cube.toml"


def test_diff_of_equal_maps_is_0(run: Any, tmp_path: Path) -> None:
    for name in ("a", "b"):
        run("render", CUBE, "--size", "16", "-o", str(tmp_path / f"{name}.npz"))
    code, out, _ = run("diff", str(tmp_path / "a.npz"), str(tmp_path / "b.npz"))
    assert code == 0 and "0 differ" in out


def test_diff_of_other_faces_is_1(run: Any, tmp_path: Path) -> None:
    run("render", CUBE, "--size", "16", "-o", str(tmp_path / "a.npz"))
    answer = hsr.load_map(tmp_path / "a.npz")
    answer.face[8, 8] = 1
    answer.save(tmp_path / "b.npz")
    code, out, _ = run("diff", str(tmp_path / "a.npz"), str(tmp_path / "b.npz"))
    assert code == 1 and "1 differ" in out
    code, out, _ = run("diff", str(tmp_path / "a.npz"), str(tmp_path / "b.npz"), "--json")
    found = json.loads(out)
    assert code == 1 and found["counts"]["wrong face"] == 1
    assert found["files"] == [str(tmp_path / "a.npz"), str(tmp_path / "b.npz")]


def test_diff_of_other_sizes_is_2(run: Any, tmp_path: Path) -> None:
    for side in ("8", "16"):
        run("render", CUBE, "--size", side, "-o", str(tmp_path / f"{side}.npz"))
    code, _, problem = run("diff", str(tmp_path / "8.npz"), str(tmp_path / "16.npz"))
    assert code == 2 and problem.startswith("hsr: ") and "8x8" in problem and "16x16" in problem
