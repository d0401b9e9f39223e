"""The command ``hsr scenes``, and names in place of files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def test_scenes_lists_what_there_is(run: Any, scenes: Path) -> None:
    names = sorted(path.stem for path in scenes.glob("*.toml"))
    assert [line.split()[0] for line in run("scenes")[1].splitlines()[1:]] == names
    told = json.loads(run("scenes", "--json")[1])["scenes"]
    assert [one["name"] for one in told] == names and all(one["title"] for one in told)


def test_a_name_is_taken_for_a_file(run: Any) -> None:
    code, out, _ = run("scene", "check", "cube", "solids")
    assert (code, out) == (0, "cube: ok\nsolids: ok\n")
    assert (
        json.loads(run("compare", "cube", "--size", "8", "-a", "zbuffer", "--json")[1])["studies"][0]["name"]
        == "cube"
    )
