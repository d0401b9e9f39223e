"""A method of another package takes part in everything by its row alone."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

BRUSH, SCENES = Path(__file__).with_name("brush"), Path(__file__).parents[2] / "scenes"

SEEN = """
import json
import hsr
from hsr.algorithms.registry import certified_methods, default_methods, method_named
from hsr.lab.scaling import law_of
from hsr.lessons.lesson import record_by
from hsr.testing import VisibilityError, check_method

seen = hsr.view(hsr.load({scene!r}), (12, 9))
brush = method_named("brush")
check_method(brush)
torn, truth = hsr.render(seen, "brush", margin=0.5), hsr.render(seen, "exact")
found = hsr.causes(seen, torn, truth, margin=0.5)
recording = record_by(seen, brush, {{}})
print(json.dumps({{
    "default": "brush" in default_methods(),
    "certified": "brush" in certified_methods(),
    "law": law_of("brush", "triangles"),
    "causes": [found.counts, found.unexplained, found.reproduced, found.wrong],
    "right": bool(truth.admits(hsr.render(seen, "brush").face).all()),
    "turns": len(recording.turns),
    "shown": bool((recording.answer.face == hsr.render(seen, "brush").face).all()),
}}))
"""


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Variables of a process in which the package is installed, as far as Python can tell."""
    site = tmp_path_factory.mktemp("site")
    told = site / "brush-1.0.dist-info"
    told.mkdir()
    project = tomllib.loads((BRUSH / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    (told / "METADATA").write_text(f"Metadata-Version: 2.1\nName: brush\nVersion: {project['version']}\n")
    (told / "entry_points.txt").write_text(
        "".join(
            f"[{group}]\n" + "".join(f"{name} = {value}\n" for name, value in entries.items())
            for group, entries in project["entry-points"].items()
        )
    )
    paths = [str(site), str(BRUSH), str(SCENES.parent), os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}


def run(environment: dict[str, str], *arguments: str) -> str:
    """Run Python with the package at hand, and return what it prints."""
    ran = subprocess.run(
        [sys.executable, *arguments], env=environment, capture_output=True, text=True, check=False
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


def cli(environment: dict[str, str], *arguments: str) -> Any:
    return json.loads(run(environment, "-m", "hsr.cli", *arguments, "--json"))


def test_it_is_listed_compared_and_timed(environment: dict[str, str]) -> None:
    scene = str(SCENES / "cube.toml")
    assert "brush" in [method["name"] for method in cli(environment, "algos")["methods"]]
    told = cli(environment, "compare", scene, "-a", "brush", "--size", "12x9")
    assert "brush" in json.dumps(told)
    (row,) = cli(environment, "bench", scene, "-a", "brush", "--size", "12x9", "--repeat", "3", "-q")["rows"]
    assert (row["method"], row["absent"]) == ("brush", "")


def test_it_takes_part_in_checks_causes_laws_and_lessons(environment: dict[str, str]) -> None:
    scene = str(SCENES / "cube.toml")
    told = json.loads(run(environment, "-c", SEEN.format(scene=scene)).splitlines()[-1])
    causes, unexplained, reproduced, wrong = told.pop("causes")
    assert causes == {"intersector": wrong} and wrong > 0 and unexplained == 0 and reproduced
    assert told == {
        "default": True,
        "certified": False,
        "law": "c x",
        "right": True,
        "turns": 12 * 9,
        "shown": True,
    }
