"""The command ``hsr bench``: what it prints and writes, how it ends."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest

from hsr.cli import app
from tests.lab.made_up import noisy, results, row

CUBE = "scenes/cube.toml"
TINY = ("--size", "16", "--repeat", "3", "-a", "exact", "-a", "backface")


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, scenes: Path) -> Any:
    """Run the command in this process: ``run("compare", ...) -> (exit code, stdout, stderr)``."""

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.chdir(scenes.parent)
        monkeypatch.setattr(sys, "argv", ["hsr", "bench", *arguments])
        with pytest.raises(SystemExit) as ended:
            app.main()
            raise SystemExit(0)
        captured = capsys.readouterr()
        return int(ended.value.code or 0), captured.out, captured.err

    return call


@pytest.fixture
def runs(tmp_path: Path) -> tuple[str, str, str]:
    """Three files of results: one, the same again, and one by a fifth slower."""
    names = []
    for name, seed, median in (("a", 1, 0.002), ("b", 2, 0.002), ("c", 3, 0.0024)):
        file = tmp_path / f"{name}.json"
        file.write_text(results(row("zbuffer", noisy(median, seed))).to_json(), encoding="utf-8")
        names.append(str(file))
    return names[0], names[1], names[2]


@pytest.mark.jit
def test_a_run_prints_a_table_and_writes_a_folder(run: Any, tmp_path: Path) -> None:
    code, out, err = run(CUBE, *TINY, "--cull", "none", "--cull", "back", "-o", str(tmp_path / "new"))
    assert code == 0
    written = next((tmp_path / "new").glob("*.csv")).read_text(encoding="utf-8")
    assert "cube, 12 triangles, 16x16, nothing culled" in out and "16x16, back faces culled" in out
    assert (
        all(f"cube/16x16/{cull}/backface" in written for cull in ("none", "back"))
        and "Medians of 3 interleaved turns" in err
    )
    assert {file.suffix for file in (tmp_path / "new").iterdir()} == {".json", ".csv", ".md", ".svg"}


@pytest.mark.jit
def test_json_is_the_file(run: Any) -> None:
    code, out, err = run(CUBE, *TINY, "--json", "-q")
    told = json.loads(out)
    assert code == 0 and err == "" and (told["hsr"], told["kind"], told["repeat"]) == (1, "bench", 3)
    assert [made["id"] for made in told["rows"]] == ["cube/16x16/scene/exact", "cube/16x16/scene/backface"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((CUBE, "-a", "zbufer"), "no method is named 'zbufer'"),
        (("scenes/nothing.toml",), "scenes/nothing.toml: no such file"),
        ((CUBE, CUBE), "more than one file is called cube"),
        ((CUBE, "--cull", "front"), "--cull 'front': choose none or back"),
        ((CUBE, "-o", "/proc/nowhere"), "/proc/nowhere: cannot write results there"),
        (("scaling", "-a", "zbufer", "--quick"), "no method is named 'zbufer'"),
        (("compare", "nothing.json", "nothing.json"), "nothing.json: cannot read the results"),
        (("compare", CUBE, CUBE), "scenes/cube.toml: no benchmark results of version 1"),
        (("compare", "a", "b", "--fail", "10%"), "--fail '10%': write median:PERCENT%"),
        (("compare", "a", "b", "-o", "c.txt"), "c.txt: what is written ends in .csv or .md; say c.csv"),
    ],
)
def test_mistakes_are_one_line(run: Any, arguments: tuple[str, ...], message: str) -> None:
    code, out, err = run(*arguments)
    assert code == 2 and out == "" and message in err and err.count("\n") == 1


def test_the_same_speed_passes(run: Any, runs: tuple[str, str, str]) -> None:
    code, out, err = run("compare", runs[0], runs[1], "--fail", "median:10%")
    assert code == 0 and "same" in out and err == ""


def test_a_slow_down_fails_only_beyond_a_limit(run: Any, runs: tuple[str, str, str], tmp_path: Path) -> None:
    code, out, _ = run("compare", runs[0], runs[2], "--fail", "median:10%")
    assert code == 1 and "slower" in out and "1.19" in out
    assert run("compare", runs[0], runs[2])[0] == 0, "no limit was set"
    assert run("compare", runs[0], runs[2], "--fail", "median:30%")[0] == 0
    target = tmp_path / "changes.md"
    assert run("compare", runs[0], runs[2], "-o", str(target))[0] == 0
    assert "| slower |" in target.read_text(encoding="utf-8")


def test_more_wrong_samples_always_fail(run: Any, tmp_path: Path) -> None:
    for name, wrong in (("a", 0), ("b", 1)):
        (tmp_path / f"{name}.json").write_text(
            results(row("zbuffer", wrong=wrong)).to_json(), encoding="utf-8"
        )
    code, out, _ = run("compare", str(tmp_path / "a.json"), str(tmp_path / "b.json"), "--json")
    assert code == 1 and json.loads(out)["changes"][0]["verdict"] == "more wrong"


def test_help_names_the_commands(run: Any) -> None:
    code, out, _ = run("--help")
    assert code == 0 and all(command in out for command in ("run", "scaling", "compare"))
