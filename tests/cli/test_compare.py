"""The command ``hsr compare``."""

from __future__ import annotations

import json
import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hsr.algorithms import registry
from hsr.base.errors import HsrError
from hsr.cli.compare import _explained

CUBE = "scenes/cube.toml"


def test_compare_writes_a_report(run: Any, tmp_path: Path) -> None:
    report = tmp_path / "report.html"
    code, out, _ = run(
        "compare",
        CUBE,
        "--size",
        "24",
        "-a",
        "zbuffer",
        "-a",
        "raycast",
        "--ref",
        "zbuffer",
        "-o",
        str(report),
    )
    assert code == 0 and f"report: {report}" in out
    assert report.read_text(encoding="utf-8").lstrip().lower().startswith("<!doctype html>")


def test_compare_json(run: Any) -> None:
    code, out, _ = run("compare", CUBE, "--size", "24", "-a", "raycast", "--ref", "zbuffer", "--json")
    (study,) = json.loads(out)["studies"]
    assert code == 0 and study["reference"] == "zbuffer"


@pytest.mark.jit
def test_variants_take_part_only_if_all_are_asked_for(run: Any) -> None:
    for extra, names in ((), registry.default_methods()), (("-a", "all"), list(registry.methods())):
        _, out, _ = run("compare", CUBE, "--size", "8", "--json", "-q", *extra)
        (study,) = json.loads(out)["studies"]
        assert {*study["methods"], *study["skipped"]} == set(names), extra


def test_compare_tells_the_time_of_the_reference_below_those_of_the_others(run: Any) -> None:
    _, out, _ = run("compare", CUBE, "--size", "24", "-a", "raycast", "--ref", "zbuffer")
    header, *rows = out.splitlines()[1:4]
    assert len(rows) == 2 and all(row.rstrip().endswith(" ms") for row in rows)
    assert {len(row.rstrip()) for row in rows} == {len(header.rstrip())}


def test_compare_does_not_pass_what_it_cannot_judge(run: Any, tmp_path: Path) -> None:
    (tmp_path / "far.obj").write_text("v 1e60 0 0\nv 0 1e60 0\nv 0 0 1e60\nf 1 2 3\n")
    arguments = ("compare", str(tmp_path / "far.obj"), "--size", "8", "-a", "zbuffer", "--ref", "embree")
    code, out, _ = run(*arguments)
    assert code == 0 and "\nembree: the scene has coordinates beyond float32" in out
    code, _, problems = run(*arguments, "--fail-on", "missing")
    assert code == 2 and "--fail-on: far: embree did not run" in problems


def test_compare_fails_on_a_class_it_meets(run: Any) -> None:
    arguments = ("compare", "scenes/convex-behind.toml", "--size", "24", "-a", "backface", "--ref", "zbuffer")
    assert run(*arguments)[0] == 0
    assert run(*arguments, "--fail-on", "wrong face")[0] == 1
    assert run(*arguments, "--fail-on", "missing,extra")[0] == 0


# ---------------------------------------------------------------- several processes


def ended_from_outside(found: Any) -> None:
    os._exit(1 if found else 0)


def test_a_process_that_is_ended_from_outside_is_no_mistake_of_ours() -> None:
    maps = {"zbuffer": SimpleNamespace(notes={}, large=bytes(1 << 20))}
    studies: Any = [SimpleNamespace(name=str(k), maps=maps) for k in range(20)]
    with pytest.raises(HsrError, match="was ended"):
        list(_explained(studies, ended_from_outside, str))
