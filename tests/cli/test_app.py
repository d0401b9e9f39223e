"""The command line: what it prints, what it writes, how it ends."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms import registry
from hsr.cli import app

CUBE = "scenes/cube.toml"


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, scenes: Path) -> Any:
    """Run the command in this process: ``run("render", ...) -> (exit code, stdout, stderr)``."""

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.chdir(scenes.parent)
        monkeypatch.setattr(sys, "argv", ["hsr", *arguments])
        with pytest.raises(SystemExit) as ended:
            app.main()
            raise SystemExit(0)
        captured = capsys.readouterr()
        return int(ended.value.code or 0), captured.out, captured.err

    return call


def test_help_is_quick() -> None:
    def seconds() -> float:
        start = time.perf_counter()
        subprocess.run([sys.executable, "-m", "hsr.cli", "--help"], check=True, capture_output=True)
        return time.perf_counter() - start

    loaded = subprocess.run(
        [sys.executable, "-c", "import sys, hsr.cli; print(*sys.modules)"],
        check=True,
        capture_output=True,
    ).stdout.decode()
    for heavy in ("numba", "trimesh", "matplotlib", "moderngl", "scipy", "numpy"):
        assert heavy not in loaded.split()
    assert min(seconds() for _ in range(3)) < 2.0  # 0.15 s on an idle machine; this only catches the absurd


def test_version(run: Any) -> None:
    assert run("--version")[:2] == (0, f"hsr {hsr.__version__}\n")


def test_render_writes_map_and_picture(run: Any, tmp_path: Path) -> None:
    target, picture = tmp_path / "map.npz", tmp_path / "cube.png"
    code, out, _ = run("render", CUBE, "--size", "40x30", "-o", str(target), "--png", str(picture))
    assert code == 0 and "zbuffer" in out and f"wrote {target}" in out
    assert hsr.load_map(target).face.shape == (30, 40)
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_render_names_files_after_methods(run: Any, tmp_path: Path) -> None:
    code, _, _ = run(
        "render", CUBE, "--size", "16", "-a", "zbuffer", "-a", "raycast", "-o", str(tmp_path / "m.npz")
    )
    assert code == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["m.raycast.npz", "m.zbuffer.npz"]


def test_render_json(run: Any) -> None:
    code, out, _ = run("render", CUBE, "--size", "16", "--json")
    (row,) = json.loads(out)["maps"]
    assert code == 0 and row["method"] == "zbuffer" and row["size"] == [16, 16] and row["faces_seen"] == 3


def test_diff_of_equal_maps_is_0(run: Any, tmp_path: Path) -> None:
    for name in ("a", "b"):
        run("render", CUBE, "--size", "16", "-o", str(tmp_path / f"{name}.npz"))
    code, out, _ = run("diff", str(tmp_path / "a.npz"), str(tmp_path / "b.npz"))
    assert code == 0 and "0 differ" in out


def test_diff_of_other_faces_is_1(run: Any, tmp_path: Path) -> None:
    run("render", CUBE, "--size", "16", "-o", str(tmp_path / "a.npz"))
    answer = hsr.load_map(tmp_path / "a.npz")
    answer.face[8, 8] = 1
    answer.save(tmp_path / "b.npz")
    code, out, _ = run("diff", str(tmp_path / "a.npz"), str(tmp_path / "b.npz"))
    assert code == 1 and "1 differ" in out
    code, out, _ = run("diff", str(tmp_path / "a.npz"), str(tmp_path / "b.npz"), "--json")
    found = json.loads(out)
    assert code == 1 and found["counts"]["wrong face"] == 1
    assert found["files"] == [str(tmp_path / "a.npz"), str(tmp_path / "b.npz")]


def test_diff_of_other_sizes_is_2(run: Any, tmp_path: Path) -> None:
    for side in ("8", "16"):
        run("render", CUBE, "--size", side, "-o", str(tmp_path / f"{side}.npz"))
    code, _, problem = run("diff", str(tmp_path / "8.npz"), str(tmp_path / "16.npz"))
    assert code == 2 and problem.startswith("hsr: ") and "8x8" in problem and "16x16" in problem


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


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (("render", "none.toml"), "none.toml"),
        (("render", CUBE, "-a", "zbufer"), "no method is named 'zbufer'"),
        (("render", CUBE, "--camera", "left"), "no camera is named 'left'"),
        (("render", CUBE, "--size", "0x5"), "size 0x5: width and height must be from 1"),
        (("render", CUBE, "--size", "16", "-o", "no/folder/map.npz"), "there is no folder no/folder"),
        (("render", CUBE, "--size", "16", "--png", "no/folder/a.png"), "no/folder/a.png"),
        (("compare", CUBE, "-a", "raycats"), "no method is named 'raycats'"),
        (("compare", CUBE, "--ref", "truth"), "no method is named 'truth'"),
        (("compare", CUBE, "--size", "8", "-a", "zbuffer", "-o", "no/folder/r.html"), "no/folder/r.html"),
        (("explain", CUBE, "-1,3"), "no sample at column -1, row 3: the image is 512x512"),
        (("diff", "none.npz", "none.npz"), "none.npz: no such file"),
        (("scene", "info", "none.toml"), "none.toml"),
        (("scene", "schema", "no/folder/schema.json"), "cannot write the schema"),
    ],
)
def test_bad_input_is_one_clear_line_and_2(run: Any, arguments: tuple[str, ...], line: str) -> None:
    code, out, problem = run(*arguments)
    assert code == 2 and out == ""
    assert problem.count("\n") == 1 and line in problem and problem.startswith("hsr: ")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("render", CUBE, "--size", "big"), "WIDTHxHEIGHT"),
        (("compare", CUBE, "--fail-on", "blurred"), "blurred"),
        (("compare",), "Missing argument"),
        (("paint",), "No such command"),
    ],
)
def test_usage_errors_are_2(run: Any, arguments: tuple[str, ...], words: str) -> None:
    code, _, problem = run(*arguments)
    assert code == 2 and words in problem


def test_missing_opengl_is_3_only_when_asked_for(run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    from hsr.algorithms import opengl
    from hsr.base.errors import UnavailableError

    def no_driver(*_arguments: Any, **_options: Any) -> Any:
        raise UnavailableError("no OpenGL here; run 'hsr doctor'")

    monkeypatch.setattr(opengl, "render", no_driver)
    assert run("render", CUBE, "--size", "8", "-a", "opengl")[0] == 3
    assert run("compare", CUBE, "--size", "8", "-a", "zbuffer", "--ref", "opengl")[0] == 3
    code, out, _ = run("compare", CUBE, "--size", "8")
    assert code == 0 and "not available" in out


def test_algos_lists_every_method(run: Any) -> None:
    code, out, _ = run("algos", "--json")
    assert code == 0
    assert [row["name"] for row in json.loads(out)["methods"]] == list(hsr.methods())
    assert "raycast-list" in run("algos")[1]


def test_scene_check(run: Any, tmp_path: Path) -> None:
    bad = tmp_path / "bad.toml"
    bad.write_text('hsr = 1\ncolor = 3\n[[object]]\nname = "a"\nshape = "cube"\n', encoding="utf-8")
    assert run("scene", "check", CUBE)[:2] == (0, f"{CUBE}: ok\n")
    code, out, _ = run("scene", "check", CUBE, str(bad))
    assert code == 2 and "color" in out and "camera" in out
    assert len(json.loads(run("scene", "check", str(bad), "--json")[1])["problems"][str(bad)]) == 2


def test_scene_info_and_schema(run: Any, tmp_path: Path) -> None:
    assert "cube" in run("scene", "info", CUBE)[1]
    assert json.loads(run("scene", "info", CUBE, "--json")[1])
    assert json.loads(run("scene", "schema")[1])["properties"]["hsr"]
    target = tmp_path / "schema.json"
    assert run("scene", "schema", str(target))[0] == 0 and json.loads(target.read_text(encoding="utf-8"))


def test_output_is_plain_with_no_color(scenes: Path) -> None:
    environment = {"NO_COLOR": "1", "FORCE_COLOR": "1", "PATH": "/usr/bin:/bin"}
    command = [sys.executable, "-m", "hsr.cli", "algos"]
    done = subprocess.run(command, check=True, capture_output=True, env=environment, cwd=scenes.parent)
    assert b"\x1b[3" not in done.stdout


def test_python_and_command_agree(run: Any, tmp_path: Path, scenes: Path) -> None:
    run("render", CUBE, "--size", "20", "-a", "raycast", "-o", str(tmp_path / "m.npz"))
    here = hsr.render(hsr.load(scenes / "cube.toml"), "raycast", size=(20, 20))
    assert np.array_equal(hsr.load_map(tmp_path / "m.npz").face, here.face)


def test_explain_tells_the_same_as_text_and_as_json(run: Any) -> None:
    arguments = ("explain", CUBE, "20,15", "--size", "40x30", "-a", "zbuffer", "-a", "backface")
    code, text, _ = run(*arguments)
    assert code == 0 and text.startswith("column 20, row 15 of 40x30: owned by cube.")
    code, out, _ = run(*arguments, "--json")
    facts = json.loads(out)
    assert (code, facts["hsr"], facts["scene"], facts["sample"]) == (0, 1, CUBE, [20, 15])
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


def test_shrink_writes_a_scene_that_still_disagrees(run: Any, tmp_path: Path) -> None:
    hidden = tmp_path / "hidden.toml"
    hidden.write_text(
        'camera = [{ type = "perspective", eye = [0.0, 0.0, 9.0] }]\n'
        'object = [{ name = "near", shape = "square", transform = [{ translate = [0.1, 0.0, 3.0] }] },\n'
        '  { name = "far", shape = "square" }]\n'
    )
    small, arguments = tmp_path / "small.toml", (str(hidden), "8,8", "-a", "backface", "-b", "zbuffer")
    code, out, _ = run("shrink", *arguments, "--size", "16", "-o", str(small))
    assert code == 0 and out == (f"wrote {small}: 2 faces left; backface shows far, zbuffer near\n")
    assert run("shrink", *arguments, "--size", "16")[1] == small.read_text()
    told = json.loads(run("shrink", *arguments, "--size", "16", "--json")[1])
    assert told["scene"] == small.read_text() and set(told["shown"]) == {"backface", "zbuffer"}
    faces = [hsr.render(hsr.load(small), method, (16, 16)).face[8, 8] for method in ("backface", "zbuffer")]
    assert faces == [1, 0]


def test_shrink_of_what_agrees_is_one_line(run: Any) -> None:
    code, out, err = run("shrink", CUBE, "0,0", "-a", "backface", "-b", "zbuffer", "--size", "16")
    assert (code, out) == (2, "")
    assert err == "hsr: backface and zbuffer agree at column 0, row 0: both show background\n"
