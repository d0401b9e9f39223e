"""The command ``hsr explain``."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import hsr
from hsr.cli.cameras import Cameras, vector

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


@pytest.mark.parametrize(
    ("options", "spelt"),
    [
        ((), ""),
        (("--camera", "side"), "--camera side"),
        (("--eye", "-3,0.1,4", "--fov", "33"), "--eye -3,0.1,4 --fov 33"),
        (("--camera", "side", "--near", "2.5"), "--camera side --near 2.5"),
        (("--eye", "1,2,3", "--target", "0,.5,0", "--up", "0,0,1", "--parallel", "4"), None),
        (("--orbit", "3", "--eye", "0.3,2,5"), None),
    ],
)
def test_the_command_of_a_page_sees_what_the_page_saw(
    options: tuple[str, ...], spelt: str | None, run: Any, two: str, tmp_path: Path
) -> None:
    page = tmp_path / "page.html"
    run("compare", two, "-a", "backface", "--size", "24x18", "-o", str(page), *options, "--ref", "backface")
    data = re.findall(r'id="data-\d+">(.*?)</script>', page.read_text(encoding="utf-8"))
    commands = [json.loads(one)["command"] for one in data]
    assert spelt is None or f"hsr explain {two} X,Y --size 24x18 {spelt} ".replace("  ", " ") in commands[0]
    scene = hsr.load(two)
    assert len(commands) == (3 if "--orbit" in options else 1)
    for command, camera in zip(commands, Cameras(*asked(options)).of(scene), strict=True):
        view = hsr.view(scene, (24, 18), camera)
        told = hsr.history(view, [hsr.render(view, "backface")], x=11, y=9)
        code, out, _ = run(*shlex.split(command.replace("X,Y", "11,9"))[1:])
        assert code == 0 and out.strip() == str(told).strip()


def asked(options: tuple[str, ...]) -> tuple[list[str], int | None, dict[str, Any]]:
    """Read options of cameras as the command does."""
    read: dict[str, Callable[[str], Any]] = {
        "--fov": float,
        "--near": float,
        "--parallel": float,
        "--orbit": int,
        "--camera": str,
    }
    pairs = zip(options[::2], options[1::2], strict=True)
    keys = {key[2:].replace("parallel", "height"): read.get(key, vector)(value) for key, value in pairs}
    names = [keys.pop("camera")] if "camera" in keys else []
    return names, keys.pop("orbit", None), keys
