"""The JSON of every verb is of the kind it says, and of that kind's schema."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest

SAMPLE = ("explain", "solids", "7,5", "--size", "16", "-a", "backface", "-a", "zbuffer")
VERBS = [
    ("render", "cube", "--size", "16", "--orbit", "2"),
    ("render", "cube", "--size", "16", "--far", "0.5"),
    ("compare", "solids", "--size", "24", "-a", "backface", "-a", "zbuffer"),
    ("compare", "solids", "--size", "24", "-a", "backface", "--ref", "zbuffer"),
    SAMPLE,
    ("scenes",),
    ("algos",),
    ("stability", "--list"),
    ("stability", "integer-overflow", "--quick", "-a", "zbuffer"),
    ("scene", "info", "solids"),
    ("scene", "check", "solids", "none"),
    ("bench", "cube", "--size", "16", "--repeat", "3", "-a", "backface", "-q"),
]


@pytest.fixture
def checked(run: Any) -> Any:
    """Run a verb, and hold its JSON to the schema of its kind."""

    def call(*arguments: str) -> Any:
        told = json.loads(run(*arguments, "--json")[1])
        schema = json.loads(run("schema", told["kind"])[1])
        jsonschema.Draft202012Validator.check_schema(schema)
        jsonschema.validate(told, schema)
        return told

    return call


@pytest.mark.parametrize("verb", VERBS, ids=" ".join)
def test_json_is_of_its_schema(checked: Any, verb: tuple[str, ...]) -> None:
    assert checked(*verb)["format"] == 1


def test_maps_and_small_scenes_too(checked: Any, run: Any, tmp_path: Path) -> None:
    for name in ("backface", "zbuffer"):
        run("render", "convex-behind", "--size", "24", "-a", name, "-o", str(tmp_path / f"{name}.npz"))
    told = checked("diff", *(str(tmp_path / f"{name}.npz") for name in ("backface", "zbuffer")))
    checked("diagnose", str(tmp_path / "backface.npz"), "convex-behind")
    place = told["clusters"][0]["sample"]
    asked = ("convex-behind", f"{place['x']},{place['y']}", "--size", "24")
    assert checked("explain", *asked, "-a", "backface")["methods"][0]["right"] is False
    assert checked("shrink", *asked, "-a", "backface", "-b", "zbuffer")["sample"] == place


def test_unknown_kinds_are_told(run: Any) -> None:
    assert run("schema", "compar")[2] == "hsr: no JSON is of the kind 'compar'; did you mean 'compare'?\n"
    assert "$ref" not in json.loads(run("schema")[1])
