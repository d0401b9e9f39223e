"""The command ``hsr stability``."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest

import hsr
from hsr.base.errors import UnavailableError
from hsr.cli import app
from hsr.lab.stability.family import Variant


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Any:
    """Run the command in this process: ``run("fan") -> (exit code, stdout, stderr)``."""

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["hsr", "stability", *arguments])
        with pytest.raises(SystemExit) as ended:
            app.main()
            raise SystemExit(0)
        captured = capsys.readouterr()
        return int(ended.value.code or 0), captured.out, captured.err

    return call


ONE = ("integer-overflow", "--quick", "-a", "zbuffer", "-a", "int32")


def test_the_matrix(run: Any) -> None:
    code, out, err = run(*ONE)
    assert code == 0 and err == ""
    assert "integer-overflow" in out and "breaks as predicted" in out and "0 unexplained of 0 traced" in out
    assert run("run", *ONE)[1] == out


def test_json(run: Any) -> None:
    code, out, _ = run(*ONE, "--json")
    (family,) = json.loads(out)["families"]
    assert code == 0 and [row["variant"] for row in family["rows"]] == ["zbuffer", "int32"]


def test_a_row_against_theory_is_exit_1(run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    from dataclasses import replace

    from hsr.lab.stability.cases import families

    family = families()["integer-overflow"]
    int32 = replace(family.variants[0], breaks=None)
    monkeypatch.setitem(families(), "integer-overflow", replace(family, variants=(int32,)))
    code, out, _ = run(*ONE)
    assert code == 1 and "breaks early" in out


def test_a_method_asked_for_that_is_missing_here_is_exit_3(run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(*_: Any, **__: Any) -> Any:
        raise UnavailableError("no OpenGL here")

    monkeypatch.setattr(Variant, "render", missing)
    code, out, err = run("huge-triangle", "--quick", "-a", "opengl")
    assert code == 3 and out == "" and "no OpenGL here" in err
    assert run("huge-triangle", "--quick")[0] == 0  # nobody in particular was asked for


def test_the_report(run: Any, tmp_path: Path) -> None:
    code, out, _ = run(*ONE, "-o", str(tmp_path / "lab"))
    assert code == 0 and f"report: {tmp_path / 'lab' / 'index.html'}" in out
    assert (tmp_path / "lab" / "integer-overflow.svg").exists()


def test_scenes_are_for_every_other_command(run: Any, tmp_path: Path) -> None:
    file = tmp_path / "needle.toml"
    code, out, _ = run("scene", "needle", "--at", "0.125", "-o", str(file))
    assert code == 0 and out == f"wrote {file}; render it with --size 64x64\n"
    seen = hsr.render(hsr.load(file), "zbuffer", size=(64, 64))
    assert len(set(seen.face.ravel().tolist())) == 17
    assert run("scene", "needle", "--at", "0.125")[1] == file.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("nope",), "hsr: no family is named 'nope'; there are "),
        (("fan", "-a", "nope"), "hsr: no method or variant is named 'nope'; 'hsr algos' lists the methods"),
        (("fan", "-o", "/proc/none/lab"), "hsr: /proc/none/lab: cannot make the folder: "),
        (("scene", "fan", "--at", "1e9"), "hsr: fan: --at 1e+09 is outside the sweep, 4 to 8192"),
        (("scene", "nope", "--at", "1"), "hsr: no family is named 'nope'; there are "),
        (
            ("scene", "fan", "--at", "8", "-o", "/proc/none/x.toml"),
            "hsr: /proc/none/x.toml: there is no folder /proc/none",
        ),
    ],
)
def test_bad_input_is_one_line_and_exit_2(run: Any, arguments: tuple[str, ...], told: str) -> None:
    code, out, err = run(*arguments)
    assert code == 2 and out == "" and err.startswith(told) and err.count("\n") == 1


def test_help_names_both_commands(run: Any) -> None:
    code, out, _ = run("--help")
    assert code == 0 and "scene" in out and "run" in out


def test_export(run: Any, tmp_path: Path) -> None:
    target = tmp_path / "needle"
    code, out, err = run("export", "needle", "--at", "0.125", "--side", "32", "-o", str(target))
    assert (code, err) == (0, "") and out == f"wrote {target}; {target / 'README.md'} says how to compare\n"
    assert (target / "README.md").read_text(encoding="utf-8").startswith("# needle, ")
    expected = hsr.load_map(target / "expected.npz")
    assert (expected.width, expected.height) == (32, 32) and (expected.face >= 0).any()
    code, _, err = run("export", "needel", "-o", str(tmp_path / "other"))
    assert code == 2 and "needle" in err and not (tmp_path / "other").exists()
