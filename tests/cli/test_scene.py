"""The command ``hsr scene``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

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
