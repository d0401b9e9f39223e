"""The command ``hsr algos``."""

from __future__ import annotations

import json
from typing import Any

import hsr

CUBE = "scenes/cube.toml"


def test_algos_lists_every_method(run: Any) -> None:
    code, out, _ = run("algos", "--json")
    assert code == 0
    assert [row["name"] for row in json.loads(out)["methods"]] == list(hsr.methods())
    assert "raycast-list" in run("algos")[1]
