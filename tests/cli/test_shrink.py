"""The command ``hsr shrink``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import hsr

CUBE = "scenes/cube.toml"


def test_shrink_writes_a_scene_that_still_disagrees(run: Any, tmp_path: Path) -> None:
    hidden = tmp_path / "hidden.toml"
    hidden.write_text(
        'camera = [{ type = "perspective", eye = [0.0, 0.0, 9.0] }]\n'
        'object = [{ name = "near", shape = "square", transform = [{ translate = [0.1, 0.0, 3.0] }] },\n'
        '  { name = "far", shape = "square" }]\n'
    )
    small, arguments = tmp_path / "small.toml", (str(hidden), "8,8", "-a", "backface", "-b", "zbuffer")
    code, out, _ = run("shrink", *arguments, "--size", "16", "-o", str(small))
    assert code == 0 and out == (f"wrote {small}: 2 faces left; backface shows far, zbuffer near\n")
    assert run("shrink", *arguments, "--size", "16")[1] == small.read_text()
    told = json.loads(run("shrink", *arguments, "--size", "16", "--json")[1])
    assert told["scene"] == small.read_text() and set(told["shown"]) == {"backface", "zbuffer"}
    faces = [hsr.render(hsr.load(small), method, (16, 16)).face[8, 8] for method in ("backface", "zbuffer")]
    assert faces == [1, 0]


def test_shrink_of_what_agrees_is_one_line(run: Any) -> None:
    code, out, err = run("shrink", CUBE, "0,0", "-a", "backface", "-b", "zbuffer", "--size", "16")
    assert (code, out) == (2, "")
    assert err == "hsr: backface and zbuffer agree at column 0, row 0: both show background\n"
