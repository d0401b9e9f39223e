"""What the README shows works as written."""

from __future__ import annotations

import json
import re
import runpy
import shlex
from pathlib import Path
from urllib.parse import parse_qsl

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import hsr
from hsr.base.errors import UnavailableError
from hsr.cli.app import app
from hsr.difference.study import study
from hsr.lab.stability.cases import families, family_named
from hsr.lab.stability.family import at_side
from hsr.pages.report import write_report
from tests.lab.made_up import results, row
from tests.pages.unpacking import scene_of, unpack
from tests.proof_readme import NOT_RUN, commands, skipped

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, flags=re.DOTALL)


@pytest.mark.jit
def test_the_python_example_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(ROOT)
    (example,) = blocks("python")
    try:
        exec(compile(example, "README.md", "exec"), {})
    except UnavailableError as error:
        pytest.skip(str(error))
    assert "opengl vs exact" in capsys.readouterr().out


@pytest.mark.jit
def test_the_link_leads_to_a_sample_with_its_history(tmp_path: Path) -> None:
    (address,) = re.findall(r"report\.html#([^`]*)", README)
    asked = dict(parse_qsl(address))
    found = study(hsr.load(asked["scene"]), [asked["method"]], "exact")
    if asked["method"] in found.missing:
        pytest.skip(found.skipped[asked["method"]])
    write_report([found], tmp_path / "report.html")
    scene = scene_of((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert int(asked["y"]) * 512 + int(asked["x"]) in unpack(scene["told"])


def test_the_commands_exist_with_their_options() -> None:
    lines = [line for block in blocks("") for line in block.splitlines() if line.startswith("hsr ")]
    assert len(lines) >= 10
    for line in lines:
        words = shlex.split(line, comments=True)[1:]
        command = words[:2] if words[0] in ("scene", "bench") else words[:1]
        if words[0] == "bench" and words[1] not in ("scaling", "compare"):
            command = ["bench", "run"]
        if words[0] == "stability":
            command = ["stability", "run"]
        told = CliRunner().invoke(app, [*command, "--help"], env={"COLUMNS": "200", "NO_COLOR": "1"})
        assert told.exit_code == 0
        for option in (word for word in words if word.startswith("-")):
            assert option in told.output, f"{line}: no option {option}"


def test_the_table_is_what_was_measured() -> None:
    """The section stands there if and only if there are results, and says what they say."""
    script = runpy.run_path(str(ROOT / "benchmarks" / "readme.py"))
    found = script["measured"]()
    assert (script["BEGIN"] in README) == bool(found)
    if found:
        assert script["updated"](README, found) == README
        assert all((ROOT / "benchmarks" / "results" / f"{one.stem}.svg").exists() for one in found)


def test_the_hard_cases_are_those_of_the_matrix() -> None:
    script = runpy.run_path(str(ROOT / "benchmarks" / "readme.py"))
    matrix = json.loads(script["MATRIX"].read_text(encoding="utf-8"))
    fresh = script["hard_cases"](matrix)
    assert script["between"](README, script["HARD_BEGIN"], script["HARD_END"], fresh) == README
    assert fresh.count("\n| ") == 11 and (script["MATRIX"].parent / "parallel-pair.svg").exists()
    assert "certified methods: 0 wrong samples" in fresh


def test_the_matrix_has_the_theory_of_today() -> None:
    script = runpy.run_path(str(ROOT / "benchmarks" / "readme.py"))
    matrix = json.loads(script["MATRIX"].read_text(encoding="utf-8"))
    assert [entry["family"] for entry in matrix["families"]] == list(families())
    for entry in matrix["families"]:
        rows = {row["variant"]: row for row in entry["rows"]}
        for variant in family_named(entry["family"]).contenders():
            row = rows[variant.name]
            at, side = row["at"], entry["side"]
            predicted = at_side(variant.breaks, side) if variant.curve is None else variant.curve(at)
            assert row["because"] == variant.because
            close = predicted if predicted is None else pytest.approx(predicted, rel=1e-12)
            assert row["predicted"] == close


def test_the_section_is_written_between_its_marks() -> None:
    script = runpy.run_path(str(ROOT / "benchmarks" / "readme.py"))
    found = [results(row("zbuffer", wrong=1234))]
    text = f"Before.\n\n{script['BEGIN']}\nold figures\n{script['END']}\n\nAfter.\n"
    fresh = script["updated"](text, found)
    assert fresh.startswith("Before.") and fresh.endswith("After.\n") and "old figures" not in fresh
    assert "| zbuffer |  |  | 1 |  | 1,234 | vertex snapping 1,234 |  |" in fresh
    assert script["updated"](fresh, found) == fresh
    with pytest.raises(SystemExit, match="put the lines"):
        script["updated"]("no marks", found)


def test_the_scene_is_valid(tmp_path: Path) -> None:
    import hsr

    (text,) = blocks("toml")
    file = tmp_path / "scene.toml"
    file.write_text(text, encoding="utf-8")
    assert hsr.load(file).object[0].name == "box"


@pytest.mark.jit
def test_the_test_of_another_renderer_runs(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its picture is what OpenGL would draw, in ids of triangles from 1 on."""
    from hsr.models.llvmpipe.driver import predict

    (example,) = [block for block in blocks("py") if "def test_my_renderer" in block]
    (pytester.path / "scene.toml").write_text(blocks("toml")[0], encoding="utf-8")
    view = hsr.view(hsr.load(pytester.path / "scene.toml"), (512, 512))
    first = np.searchsorted(view.triangle_face, np.arange(view.faces))  # a triangle of each face
    ids = np.append(first + 1, 0)[predict(view).face]
    Image.fromarray(np.stack([0 * ids, 0 * ids, ids], axis=-1).astype(np.uint8)).save(
        pytester.path / "ids.png"
    )
    pytester.makepyfile(test_it=example)
    pytester.makeini("[pytest]")
    monkeypatch.delenv("CI", raising=False)
    pytester.runpytest_subprocess("--hsr-update=new").assert_outcomes(failed=1)  # no baseline yet
    pytester.runpytest_subprocess("--hsr-selfcheck").assert_outcomes(passed=1)


def test_every_command_is_run_by_the_proof_or_said_not_to_be() -> None:
    found = commands()
    assert sum(not skipped(command) for command in found) > 15
    assert [start for start in NOT_RUN if not any(command.startswith(start) for command in found)] == []


def test_what_a_newcomer_waits_for_is_what_was_measured() -> None:
    measured = (ROOT / "benchmarks" / "results" / "first-minute.md").read_text(encoding="utf-8")
    told = README[README.index("On a slow\nmachine") : README.index("first_minute.py")]
    (cold, warm, _), (first, _) = (
        re.findall(r"\d+\.\d", next(line for line in measured.splitlines() if line.startswith(start)))
        for start in ("| compare, with its page |", "`hsr demo`, cold")
    )
    assert re.findall(r"(\d+\.\d) s\b", told) == [first, cold, warm]
