"""The plug-in on a sample project: what passes, fails, is written, and is told."""

from __future__ import annotations

import io
import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from hsr.base.errors import HsrError
from hsr.cli.app import app
from hsr.pytest_plugin import _check_results
from tests.damage import damaged

BASELINES = "__visibility__/test_baselines"


def results(project: pytest.Pytester) -> dict[str, Any]:
    told: dict[str, Any] = json.loads(
        (project.path / ".hsr-results/results.json").read_text(encoding="utf-8")
    )
    return told


def checks(project: pytest.Pytester) -> dict[str, Any]:
    """The checks of the last run by test and name."""
    return {
        f"{record['test']} {check['name']}": check
        for record in results(project)["tests"]
        for check in record["checks"]
    }


def change(project: pytest.Pytester, old: str, new: str) -> None:
    """Let the renderer paint something else."""
    file = project.path / "scene.txt"
    text = file.read_text(encoding="ascii")
    assert old in text
    file.write_text(text.replace(old, new), encoding="ascii")


def files(project: pytest.Pytester) -> set[str]:
    """All files of the project but those that Python and pytest make."""
    return {
        path.relative_to(project.path).as_posix()
        for path in project.path.rglob("*")
        if path.is_file() and not {"__pycache__", ".pytest_cache"} & set(path.parts)
    }


@pytest.fixture
def written(project: pytest.Pytester) -> pytest.Pytester:
    """The project with a baseline of ``test_scene``."""
    project.runpytest("test_baselines.py::test_scene", "--hsr-update=new").assert_outcomes(failed=1)
    return project


def test_nothing_heavy_is_imported_before_it_is_used(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        import sys

        def test_nothing(pytestconfig):
            assert pytestconfig.pluginmanager.hasplugin("hsr-gatherer")
            heavy = {"numpy", "numba", "scipy", "matplotlib", "moderngl", "pydantic", "PIL"}
            assert not heavy & set(sys.modules)
        """
    )
    pytester.runpytest_subprocess().assert_outcomes(passed=1)
    assert not (pytester.path / ".hsr-results").exists()


def test_a_missing_baseline_fails_and_writes_none(project: pytest.Pytester) -> None:
    before = files(project)
    run = project.runpytest("test_baselines.py::test_scene")
    run.assert_outcomes(failed=1)
    run.stdout.fnmatch_lines(["E *VisibilityError: test_scene: there is no baseline*test_scene.npz"])
    new = files(project) - before
    assert new and all(name.startswith(".hsr-results/") for name in new)
    assert any(name.endswith("1-shown.npz") for name in new)


def test_baselines_are_written_and_pass_the_next_time(project: pytest.Pytester) -> None:
    run = project.runpytest("test_baselines.py", "--hsr-update=new")
    run.assert_outcomes(failed=6)
    run.stdout.fnmatch_lines([f"E *wrote {BASELINES}/test_scene.npz*"])
    names = {path.name for path in (project.path / BASELINES).iterdir()}
    assert len({name.lower() for name in names}) == 6  # test_two stops at its first check
    assert max(map(len, names)) < 100
    project.runpytest("test_baselines.py", "--hsr-update=new").assert_outcomes(passed=5, failed=1)
    project.runpytest("test_baselines.py").assert_outcomes(passed=6)


@pytest.mark.parametrize("what", ["failed", "all"])
def test_an_update_never_makes_a_failing_run_pass(written: pytest.Pytester, what: str) -> None:
    change(written, "aab", "acb")
    written.runpytest("test_baselines.py::test_scene", "--hsr-update=new").assert_outcomes(failed=1)
    run = written.runpytest("test_baselines.py::test_scene", f"--hsr-update={what}")
    run.assert_outcomes(failed=1)
    run.stdout.fnmatch_lines([f"E *wrote {BASELINES}/test_scene.npz*"])
    written.runpytest("test_baselines.py::test_scene").assert_outcomes(passed=1)


def test_an_update_is_refused_in_ci(project: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CI", "true")
    before = files(project)
    run = project.runpytest("--hsr-update=all")
    assert run.ret == pytest.ExitCode.USAGE_ERROR
    run.stderr.fnmatch_lines(["*--hsr-update is refused where CI is set*"])
    assert files(project) == before


def test_a_failure_says_what_where_and_by_which_limit(written: pytest.Pytester) -> None:
    change(written, "aab", "acb")
    run = written.runpytest("test_baselines.py::test_scene")
    run.stdout.fnmatch_lines(
        [
            "E *test_scene vs test_scene.npz, 8x8: 3 samples count as different",
            "E *wrong face 3, 1 cluster, the largest: 3 wrong face  column 1, rows 0..2*",
            "E *limit max_diff_pixels=0 (default): 3 differ",
            "E *since test_scene.npz was written: scene unknown, camera unknown, depths same, size same, *",
            "E *file://*/.hsr-results/report.html#scene=*/1&method=test_scene&x=1&y=0",
        ]
    )


def test_what_changed_is_told(written: pytest.Pytester) -> None:
    text = (written.path / "painter.py").read_text(encoding="utf-8")
    (written.path / "painter.py").write_text(text.replace('"painter"', '"brush"'), encoding="utf-8")
    change(written, "........\n", "........\n........\n")
    run = written.runpytest_subprocess("test_baselines.py::test_scene")
    run.stdout.fnmatch_lines(
        ["E *8x11 is not 8x8", "E *size changed*, renderer changed from painter to brush"]
    )


def test_a_marker_is_stronger_than_the_command_line_and_that_than_the_ini_file(
    written: pytest.Pytester,
) -> None:
    change(written, "aab", "acb")
    one = "test_baselines.py::test_scene"
    written.makeini("[pytest]\nhsr_max_diff_pixels = 2\n")
    run = written.runpytest(one)
    run.stdout.fnmatch_lines(["*limit max_diff_pixels=2 (tox.ini): 3 differ"])
    written.runpytest(one, "--hsr-max-diff-pixels=3").assert_outcomes(passed=1)
    run = written.runpytest(one, "--hsr-max-diff-pixels=1", "--hsr-max-cluster=2")
    run.stdout.fnmatch_lines(
        ["*max_diff_pixels=1 (command line): 3 differ", "*max_cluster=2 (command line): 3 hang together at *"]
    )
    text = (written.path / "test_baselines.py").read_text(encoding="utf-8")
    marked = text.replace("def test_scene", "@pytest.mark.visibility(max_diff_pixels=0)\ndef test_scene")
    (written.path / "test_baselines.py").write_text(marked, encoding="utf-8")
    run = written.runpytest(one, "--hsr-max-diff-pixels=3")
    run.stdout.fnmatch_lines(["*limit max_diff_pixels=0 (marker): 3 differ"])


@pytest.mark.parametrize(
    ("limit", "complaint"),
    [
        ("max_diff_pixels=1.5", "is no number"),
        ("max_diff_ratio=2", "at most 1"),
        ("allow=rain", "no cause 'rain'"),
    ],
)
def test_limits_that_make_no_sense(written: pytest.Pytester, limit: str, complaint: str) -> None:
    name, _, value = limit.partition("=")
    run = written.runpytest("test_baselines.py::test_scene", f"--hsr-{name.replace('_', '-')}={value}")
    assert run.ret != 0
    assert complaint in run.stdout.str() + run.stderr.str()


def test_any_of_several_baselines_will_do(written: pytest.Pytester) -> None:
    one, folder = "test_baselines.py::test_scene", written.path / BASELINES
    (folder / "test_scene.npz").rename(folder / "test_scene~2.npz")
    change(written, "aab", "acb")
    written.runpytest(one, "--hsr-update=failed").assert_outcomes(failed=1)
    (folder / "test_scene~2.npz").rename(folder / "test_scene~7.npz")
    change(written, "acb", "aab")
    text = (written.path / "scene.txt").read_text(encoding="ascii")
    written.runpytest(one).assert_outcomes(failed=1)
    assert decide(written, "variant").exit_code == 0
    assert sorted(path.name for path in folder.iterdir()) == ["test_scene~7.npz", "test_scene~8.npz"]
    written.runpytest(one).assert_outcomes(passed=1)  # the second of them matches
    (written.path / "scene.txt").write_text(text.replace("aab", "acb"), encoding="ascii")
    written.runpytest(one).assert_outcomes(passed=1)  # the first
    (written.path / "scene.txt").write_text(text.replace("bbbb", "beeb"), encoding="ascii")
    run = written.runpytest(one)
    run.stdout.fnmatch_lines(
        [
            "E *none of 2 baselines matches; the nearest:",
            "*vs test_scene~8.npz*: 6 samples count as different",
        ]
    )


def test_unused_baselines_are_told_after_a_whole_run_alone(project: pytest.Pytester) -> None:
    project.runpytest("test_baselines.py", "--hsr-update=new")
    project.runpytest("test_baselines.py", "--hsr-update=new")
    for name in ("test_baselines/test_gone.npz", "test_nowhere/test_x.npz"):
        (project.path / "__visibility__" / name).parent.mkdir(exist_ok=True)
        (project.path / "__visibility__" / name).write_bytes(b"")
    unused = ["unused baseline: __visibility__/test_baselines/test_gone.npz"]
    unused.append("unused baseline: __visibility__/test_nowhere/test_x.npz")
    for processes in ("0", "2"):
        run = project.runpytest("test_baselines.py", "-n", processes)
        run.assert_outcomes(passed=6)
        run.stdout.fnmatch_lines(unused)
    assert project.runpytest("test_baselines.py", "--hsr-unused=fail").ret == pytest.ExitCode.TESTS_FAILED
    ignored = project.runpytest("test_baselines.py", "--hsr-unused=ignore")
    assert ignored.ret == pytest.ExitCode.OK
    ignored.stdout.no_fnmatch_line("unused baseline*")
    for some in (
        ("test_baselines.py::test_two", "--hsr-unused=fail"),
        ("test_baselines.py", "-k", "two", "-n", "1"),
    ):
        project.runpytest(*some).stdout.no_fnmatch_line("unused baseline*")


def foreign() -> bytes:
    file = io.BytesIO()
    np.savez(file, ids=np.zeros((8, 8)))
    return file.getvalue()


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 torn", b"not a map", foreign()])
def test_a_damaged_baseline_is_told_in_a_line(written: pytest.Pytester, content: bytes) -> None:
    (written.path / BASELINES / "test_scene.npz").write_bytes(content)
    run = written.runpytest("test_baselines.py::test_scene")
    run.assert_outcomes(failed=1)
    errors = [line for line in run.stdout.lines if line.startswith("E ")]
    assert len(errors) == 1 and "test_scene.npz: not a visibility map" in errors[0]


def test_hashes_in_place_of_maps(project: pytest.Pytester) -> None:
    project.makeini("[pytest]\nhsr_baselines = hashes\n")
    one = "test_baselines.py::test_scene"
    project.runpytest(one, "--hsr-update=new").assert_outcomes(failed=1)
    held = json.loads((project.path / BASELINES / "test_scene.json").read_text(encoding="utf-8"))
    assert len(held["faces"]) == len(held["depths"]) == 64 and held["size"] == "8x8"
    project.runpytest(one).assert_outcomes(passed=1)
    change(project, "aab", "acb")
    project.runpytest(one).stdout.fnmatch_lines(
        ["E *test_scene vs test_scene.json: faces changed", "E *keep maps*"]
    )


def test_two_checks_need_two_names(project: pytest.Pytester) -> None:
    text = (project.path / "test_baselines.py").read_text(encoding="utf-8")
    (project.path / "test_baselines.py").write_text(text.replace('"second"', '"first"'), encoding="utf-8")
    project.runpytest("--hsr-update=new", "test_baselines.py")
    run = project.runpytest("test_baselines.py::test_two")
    run.stdout.fnmatch_lines(["E *CheckError: two checks of one test need different names*"])


# ---------------------------------------------------------------- the truth


def test_no_baseline_is_needed_where_the_truth_is_known(project: pytest.Pytester) -> None:
    run = project.runpytest("test_truth.py")
    run.assert_outcomes(passed=3, failed=1)
    run.stdout.fnmatch_lines(
        [
            "E *painted vs exact, 24x16: * samples count as different",
            "E *no depth test *, * the largest: *",
            "E *backface shows * (no depth test); exactly, *",
            "E *limit max_diff_pixels=0 (default): * differ",
            "E *hsr explain *room.toml *,* --size 24x16 --map .hsr-results/items/*/1-shown.npz",
        ]
    )
    told = checks(project)
    assert set(told["test_truth.py::test_wrong painted"]["counts"]) == {"no depth test"}
    assert told["test_truth.py::test_wrong_for_a_known_cause painted"]["passed"]
    assert not (project.path / "__visibility__").exists()


def test_the_command_of_a_failure_explains_it(project: pytest.Pytester) -> None:
    run = project.runpytest("test_truth.py::test_wrong")
    (line,) = [line for line in run.stdout.lines if "hsr explain" in line]
    told = CliRunner().invoke(app, line.split("hsr ")[1].split())
    assert told.exit_code == 0
    assert "(no depth test); exactly" in told.output


def test_the_self_check_names_what_would_pass(project: pytest.Pytester) -> None:
    run = project.runpytest("test_truth.py", "-k", "right or lax", "--hsr-selfcheck")
    run.assert_outcomes(passed=2)
    assert run.ret == pytest.ExitCode.TESTS_FAILED
    run.stdout.fnmatch_lines(["test_truth.py::test_lax: raycast would pass with the mistake *"])
    run.stdout.fnmatch_lines(["2 of 2 checks were tried on planted mistakes; *"])
    run.stdout.no_fnmatch_line("test_truth.py::test_right: *")
    told = checks(project)
    assert "flipped y" in told["test_truth.py::test_lax raycast"]["lets_pass"]
    assert told["test_truth.py::test_right mine"]["lets_pass"] == {}


@pytest.mark.parametrize(
    ("which", "told"),
    [
        ("test_baselines.py::test_scene", "0 of 1 checks were tried on planted mistakes; tell them what *"),
        ("test_other.py", "no check was tried on planted mistakes: there is none"),
    ],
)
def test_a_self_check_that_tries_nothing_fails(written: pytest.Pytester, which: str, told: str) -> None:
    written.makepyfile(test_other="def test_nothing(): pass")
    assert written.runpytest(which).ret == pytest.ExitCode.OK
    run = written.runpytest(which, "--hsr-selfcheck")
    run.assert_outcomes(passed=1)
    assert run.ret == pytest.ExitCode.TESTS_FAILED
    run.stdout.fnmatch_lines([told])


def test_a_marker_may_tell_the_model(project: pytest.Pytester) -> None:
    project.makepyfile(
        test_model="""
        import hsr, pytest

        @pytest.fixture
        def view():
            return hsr.view(hsr.load("room.toml"), (48, 32))

        @pytest.fixture
        def mine(view):
            rounded = {"arithmetic": "float32", "stepping": "direct", "subpixel_bits": 4}
            return hsr.testing.from_ids(hsr.render(view, "scanline", **rounded).face)

        @pytest.mark.visibility(allow={"vertex snapping"}, model="float32", subpixel_bits=4)
        def test_told(visibility, view, mine):
            visibility.agree({"mine": mine}, hsr.render(view, "exact"), scene=view)

        def test_not_told(visibility, view, mine):
            visibility.agree({"mine": mine}, hsr.render(view, "exact"), scene=view)
        """
    )
    run = project.runpytest("test_model.py")
    run.assert_outcomes(passed=1, failed=1)
    run.stdout.fnmatch_lines(["E *vertex snapping *", "E *causes by the model float32, subpixel_bits 4"])
    told = (
        "--hsr-model=float32",
        "--hsr-subpixel-bits=4",
        "--hsr-max-in-window=8,0",
        "--hsr-expect-diff=1,90",
    )
    run = project.runpytest("test_model.py", "-k", "not_told", *told)
    run.stdout.fnmatch_lines(["E *limit max_in_window=(8, 0) (command line): * differ in the window from *"])
    run.stdout.no_fnmatch_line("E *limit expect_diff*")


# ---------------------------------------------------------------- results


def outcome(project: pytest.Pytester, *options: str) -> dict[str, Any]:
    run = project.runpytest("test_baselines.py", "test_truth.py", "--junitxml=junit.xml", *options)
    run.assert_outcomes(passed=4, failed=6)
    return checks(project)


def test_results_are_the_same_whoever_runs_the_tests(written: pytest.Pytester) -> None:
    alone = outcome(written)
    shared = outcome(written, "-n", "2")
    assert alone == shared and len(alone) == 10


def test_results_for_programs_and_for_people(written: pytest.Pytester) -> None:
    told = outcome(written)
    folder = written.path / ".hsr-results"
    summary = (folder / "summary.md").read_text(encoding="utf-8")
    assert summary.startswith("## Visibility: 10 checks, 6 failed\n")
    assert summary.count("### ") == 6 and "test_truth.py::test_wrong" in summary
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert all(check["passed"] or f'id="{check["key"]}"' in page for check in told.values())
    assert page.index("test_truth.py::test_wrong") < page.index("test_truth.py::test_right")
    cases = ElementTree.parse(written.path / "junit.xml").iter("testcase")
    (wrong,) = [case for case in cases if case.get("name") == "test_wrong"]
    (entry,) = list(wrong.iter("property"))
    assert entry.get("name") == "visibility painted"
    assert str(entry.get("value")).startswith("failed: ") and "no depth test" in str(entry.get("value"))


def test_results_tell_where_they_were_made_and_make_the_page_again(written: pytest.Pytester) -> None:
    outcome(written)
    told, page = results(written)["environment"], written.path / ".hsr-results/report.html"
    assert told["versions"].keys() >= {"python", "hsr-lab", "numpy"} and told["system"]
    assert {"backface", "painter", "raycast"} <= set(told["renderers"])
    text = page.read_text(encoding="utf-8")
    page.unlink()
    done = CliRunner().invoke(app, ["report", str(page.with_name("results.json"))])
    assert done.exit_code == 0 and done.output.startswith("10 checks: ")
    assert page.read_text(encoding="utf-8") == text


def test_what_was_expected_stands_beside_a_picture_of_another_size(written: pytest.Pytester) -> None:
    change(written, "........\n", "........\n........\n")
    written.runpytest("test_baselines.py::test_scene")
    page = (written.path / ".hsr-results/report.html").read_text(encoding="utf-8")
    assert "<figcaption><b>expected, 8x8</b></figcaption>" in page


def test_results_go_where_they_are_told(project: pytest.Pytester) -> None:
    before = files(project)
    project.runpytest("test_truth.py", "--hsr-results=out/here")
    assert all(name.startswith("out/here/") for name in files(project) - before)
    project.runpytest("test_truth.py::test_right", "--hsr-results=out/here")
    assert not list((project.path / "out/here").rglob("1-shown.npz"))  # those of the last run are gone
    before = {name: (project.path / name).read_bytes() for name in files(project)}
    project.runpytest("--collect-only", "--hsr-results=out/here")
    assert {name: (project.path / name).read_bytes() for name in files(project)} == before


def test_a_folder_of_other_things_is_refused(project: pytest.Pytester) -> None:
    run = project.runpytest("test_truth.py", "--hsr-results=.")
    assert run.ret == pytest.ExitCode.USAGE_ERROR
    run.stderr.fnmatch_lines(["*not empty, and no results of checks; name another folder"])
    assert (project.path / "room.toml").exists()


def test_an_unfinished_mark_is_ours_and_a_like_name_is_not(tmp_path: Path) -> None:
    (tmp_path / "..gitignore.4711").write_text("", encoding="ascii")  # see hsr.base.files.write_whole
    _check_results(tmp_path)
    (tmp_path / "my.gitignore").write_text("", encoding="ascii")
    with pytest.raises(pytest.UsageError, match="not empty"):
        _check_results(tmp_path)


# ---------------------------------------------------------------- decisions


def decide(project: pytest.Pytester, choice: str, **changed: Any) -> Any:
    told = results(project)
    (check,) = told["tests"][0]["checks"]
    made = {"hsr": 1, "run": told["run"], "decisions": {check["key"]: choice}} | changed
    (project.path / "decisions.json").write_text(json.dumps(made), encoding="utf-8")
    return CliRunner().invoke(app, ["accept", "decisions.json"])


@pytest.mark.parametrize(
    ("choice", "left", "passes"),
    [
        ("accept", ["test_scene.npz"], True),
        ("variant", ["test_scene.npz", "test_scene~2.npz"], True),
        ("reject", ["test_scene.npz"], False),
    ],
)
def test_decisions_are_carried_out(
    written: pytest.Pytester, choice: str, left: list[str], passes: bool
) -> None:
    change(written, "aab", "acb")
    written.runpytest("test_baselines.py::test_scene")
    assert decide(written, choice).exit_code == 0
    assert sorted(path.name for path in (written.path / BASELINES).iterdir()) == left
    run = written.runpytest("test_baselines.py::test_scene")
    run.assert_outcomes(passed=int(passes), failed=int(not passes))


def test_a_missing_baseline_can_be_accepted(project: pytest.Pytester) -> None:
    project.runpytest("test_baselines.py::test_scene")
    assert decide(project, "accept").exit_code == 0
    project.runpytest("test_baselines.py::test_scene").assert_outcomes(passed=1)


@pytest.mark.parametrize(
    ("changed", "complaint"),
    [
        ({"run": "another"}, "made of another run"),
        ({"decisions": {"nothing/1": "accept"}}, "no such check"),
        ({"hsr": 2}, "holds no decisions"),
    ],
)
def test_decisions_about_something_else(
    written: pytest.Pytester, changed: dict[str, Any], complaint: str
) -> None:
    change(written, "aab", "acb")
    written.runpytest("test_baselines.py::test_scene")
    before = (written.path / BASELINES / "test_scene.npz").read_bytes()
    refused = decide(written, "accept", **changed)
    assert refused.exit_code != 0 and complaint in str(refused.exception)
    assert (written.path / BASELINES / "test_scene.npz").read_bytes() == before


# ---------------------------------------------------------------- what a machine lacks

NEEDY = """
    import pytest
    from hsr.base.errors import NoOpenGLError, UnavailableError

    @pytest.mark.visibility
    def test_gl():
        raise NoOpenGLError("no OpenGL here")

    @pytest.fixture
    def drawn():
        raise UnavailableError("no Embree here")

    def test_embree(drawn, visibility):
        pass

    def test_of_its_own():
        raise UnavailableError("not for the plug-in")
"""


@pytest.mark.parametrize(("options", "skipped"), [((), 2), (("--hsr-require-gl",), 1)])
def test_what_is_missing_is_skipped_unless_it_is_required(
    project: pytest.Pytester, options: tuple[str, ...], skipped: int
) -> None:
    file = project.makepyfile(test_needy=NEEDY)
    run = project.runpytest(file, "-rs", *options)
    run.assert_outcomes(skipped=skipped, failed=3 - skipped)
    run.stdout.fnmatch_lines(["SKIPPED*: no Embree here"])


def test_pictures_are_a_weaker_check(project: pytest.Pytester) -> None:
    file = project.makepyfile(
        test_shaded="""
        import numpy as np

        def test_shaded(visibility):
            picture = np.zeros((16, 16, 3), np.uint8)
            other = picture.copy()
            other[4:9, 4:9] = 255
            visibility.similar(picture, picture)
            visibility.similar(other, picture)
        """
    )
    run = project.runpytest(file)
    run.stdout.fnmatch_lines(
        [
            "E *pictures: similarity 0.*, 25 pixels of another colour",
            "E *weaker check: *",
            "2 of the checks*weaker*",
        ]
    )
    assert sorted(path.name for path in project.path.glob(".hsr-results/items/*/*.png")) == [
        "2-expected.png",
        "2-shown.png",
    ]


# ---------------------------------------------------------------- damage, full disks, links


def test_damaged_results_and_decisions_are_one_line(
    written: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    change(written, "aab", "acb")
    written.runpytest("test_baselines.py::test_scene")
    decide(written, "accept")
    folder = written.path / ".hsr-results"
    (kept,) = folder.glob("items/*/*inspection.json")
    # How pages are built is not what this is about, and takes long.
    monkeypatch.setattr("hsr.pages.checks.page", lambda *_, **shown: str(shown["causes"]))
    for file, verb, count in (
        (folder / "results.json", ["report", str(folder / "results.json")], 150),
        (folder / "results.json", ["accept", "decisions.json"], 100),
        (written.path / "decisions.json", ["accept", "decisions.json"], 50),
        (kept, ["report", str(folder / "results.json")], 50),
    ):
        whole = file.read_text(encoding="utf-8")
        texts = [json.dumps(value) for value in damaged(json.loads(whole), count)]
        for text in (*texts, "", "{", "[" * 10_000, whole[: len(whole) // 2], '{"hsr": 1, "run": "x"}'):
            file.write_text(text, encoding="utf-8")
            done = CliRunner().invoke(app, verb)
            if done.exception is not None:
                assert isinstance(done.exception, HsrError), (text, done.exception)
                assert "\n" not in str(done.exception) and file.suffix in str(done.exception)
        file.write_text(whole, encoding="utf-8")
        assert CliRunner().invoke(app, verb).exit_code == 0


@pytest.mark.parametrize("where", ["test_baselines/test_scene.npz", "test_baselines", ""])
def test_nothing_is_written_through_links(written: pytest.Pytester, where: str) -> None:
    change(written, "aab", "acb")
    written.runpytest("test_baselines.py::test_scene")
    link, elsewhere = written.path / "__visibility__" / where, written.path / "elsewhere"
    link.rename(elsewhere)
    link.symlink_to(elsewhere)
    before = {file: file.read_bytes() for file in [elsewhere, *elsewhere.rglob("*")] if file.is_file()}
    refused = decide(written, "accept")
    assert isinstance(refused.exception, HsrError) and "a link leads to" in str(refused.exception)
    run = written.runpytest("test_baselines.py::test_scene", "--hsr-update=failed")
    run.stdout.fnmatch_lines(["E *a link leads to *elsewhere*; nothing is written there"])
    assert {
        file: file.read_bytes() for file in [elsewhere, *elsewhere.rglob("*")] if file.is_file()
    } == before


@pytest.mark.parametrize(
    "baseline",
    [
        "painter.py",
        "/tmp/a.npz",
        "__visibility__/a.npz",
        "__visibility__/../a/b.npz",
        "__visibility__/a/b.py",
    ],
)
def test_only_baselines_are_replaced(written: pytest.Pytester, baseline: str) -> None:
    change(written, "aab", "acb")
    written.runpytest("test_baselines.py::test_scene")
    told = results(written)
    told["tests"][0]["checks"][0]["baseline"] = baseline
    (written.path / ".hsr-results/results.json").write_text(json.dumps(told), encoding="utf-8")
    assert "has no baseline in this project" in str(decide(written, "accept").exception)


@pytest.mark.parametrize("room", [0, 1, 3, 6])
def test_a_full_disk_changes_no_judgement(
    project: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, room: int
) -> None:
    free = room
    whole = Path.write_bytes

    def write(path: Path, data: bytes) -> int:
        nonlocal free
        free -= 1
        whole(path, data if free >= 0 else data[:1])
        if free < 0:
            raise OSError(28, "No space left on device")
        return len(data)

    monkeypatch.setattr(Path, "write_bytes", write)
    run = project.runpytest_inprocess("test_truth.py", "-k", "right or wrong", "-p", "no:cacheprovider")
    run.assert_outcomes(passed=2, failed=1)
    assert run.ret == pytest.ExitCode.TESTS_FAILED
    run.stdout.fnmatch_lines(["E *no depth test*", "*results are not whole: *No space left on device"])
    for file in project.path.glob(".hsr-results/**/*"):
        assert file.is_dir() or file.stat().st_size > 1
        assert file.suffix != ".json" or json.loads(file.read_text(encoding="utf-8"))


def test_results_of_another_run_that_cannot_be_removed_are_not_taken_for_this_one(
    written: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    def read_only(*_: Any) -> None:
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr("shutil.rmtree", read_only)
    run = written.runpytest_inprocess("test_baselines.py::test_scene")
    run.assert_outcomes(passed=1)
    run.stdout.fnmatch_lines(["*not whole: *those of the last run are still there: Read-only file system"])
