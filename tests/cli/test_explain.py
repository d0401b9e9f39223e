"""The command ``hsr explain``."""

from __future__ import annotations

import json
from typing import Any

import pytest

CUBE = "scenes/cube.toml"


def test_explain_tells_the_same_as_text_and_as_json(run: Any) -> None:
    arguments = ("explain", CUBE, "20,15", "--size", "40x30", "-a", "zbuffer", "-a", "backface")
    code, text, _ = run(*arguments)
    assert code == 0 and text.startswith("column 20, row 15 of 40x30: owned by cube.")
    code, out, _ = run(*arguments, "--json")
    facts = json.loads(out)
    assert (code, facts["kind"], facts["scene"], facts["sample"]) == (0, "explain", CUBE, {"x": 20, "y": 15})
    assert [method["method"] for method in facts["methods"]] == ["zbuffer", "backface"]
    for told in (*facts["methods"], *facts["faces"]):
        assert told["name"] in text
    assert all(method["sentence"] in text for method in facts["methods"])


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (("3",), "sample '3': write COLUMN,ROW, such as 311,204"),
        (("3,x",), "sample '3,x': write COLUMN,ROW, such as 311,204"),
        (("40,3",), "no sample at column 40, row 3: the image is 40x30, counted from 0"),
        (("3,5", "-a", "magic"), "no method is named 'magic'"),
        (("3,5", "--camera", "no"), "no camera is named 'no'"),
    ],
)
def test_explain_refuses_in_one_line(arguments: tuple[str, ...], line: str, run: Any) -> None:
    code, out, err = run("explain", CUBE, *arguments, "--size", "40x30")
    assert code == 2 and out == "" and err.startswith(f"hsr: {line}") and err.count("\n") == 1
