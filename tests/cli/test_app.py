"""The command line: what it prints, what it writes, how it ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

import hsr
from hsr.algorithms import registry
from hsr.scene.names import printable

CUBE = "scenes/cube.toml"


def test_help_loads_nothing_heavy() -> None:
    loaded = subprocess.run(
        [sys.executable, "-c", "import sys, hsr.cli; print(*sys.modules)"],
        check=True,
        capture_output=True,
    ).stdout.decode()
    for heavy in ("numba", "matplotlib", "moderngl", "scipy", "numpy"):
        assert heavy not in loaded.split()


def test_version(run: Any) -> None:
    assert run("--version")[:2] == (0, f"hsr {hsr.__version__}\n")


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


def test_output_is_plain_with_no_color(scenes: Path) -> None:
    environment = {"NO_COLOR": "1", "FORCE_COLOR": "1", "PATH": "/usr/bin:/bin"}
    command = [sys.executable, "-m", "hsr.cli", "algos"]
    done = subprocess.run(command, check=True, capture_output=True, env=environment, cwd=scenes.parent)
    assert b"\x1b[3" not in done.stdout


@pytest.mark.parametrize("verb", [["algos"], ["algos", "--json"]])
def test_a_mistake_of_the_program_is_one_line_and_70(
    run: Any, monkeypatch: pytest.MonkeyPatch, verb: list[str]
) -> None:
    def broken() -> Any:
        raise KeyError("no such thing")

    monkeypatch.setattr(registry, "methods", broken)
    code, out, problem = run(*verb)
    assert code == 70 and out == "" and problem.count("\n") == 1
    assert problem.startswith("hsr: a mistake of the program, please report it: KeyError: 'no such thing' (")


@pytest.mark.parametrize("encoding", ["ascii", "utf-8"])
def test_names_may_have_any_characters(tmp_path: Path, encoding: str) -> None:
    names = ["gr\xfc\xdfe \U0001f600.obj", "nbsp\xa0.obj", "no\x07bell.obj"]
    for name in names:
        (tmp_path / name).write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    for arguments in (["check", *names], ["info", names[0]]):
        done = subprocess.run(
            [sys.executable, "-m", "hsr.cli", "scene", *arguments],
            cwd=tmp_path,
            env={**os.environ, "PYTHONIOENCODING": encoding, "PYTHONPATH": os.pathsep.join(sys.path)},
            capture_output=True,
        )
        assert (done.returncode, done.stderr) == (0, b"")
        (*lines, last) = done.stdout.decode(encoding).split("\n")
        assert lines and last == "" and [*map(printable, lines)] == lines


def test_debug_adds_where_an_error_arose(run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> Any:
        raise KeyError("no such thing")

    monkeypatch.setattr(registry, "methods", broken)
    code, _, problem = run("--debug", "algos")
    assert code == 70 and "in broken" in problem and problem.splitlines()[-1].startswith("hsr: a mistake")
    code, _, problem = run("--debug", "diff", "none.npz", "none.npz")
    assert code == 2 and "in load_map" in problem and problem.splitlines()[-1].startswith("hsr: none.npz")


# ---------------------------------------------------------------- ended by others

HSR = [sys.executable, "-m", "hsr.cli"]


def started(scenes: Path, *arguments: str, **how: Any) -> subprocess.Popen[str]:
    return subprocess.Popen([*HSR, *arguments], cwd=scenes.parent, stderr=subprocess.PIPE, text=True, **how)


def interrupted(process: subprocess.Popen[str]) -> None:
    """Send Ctrl-C as a terminal does: to all processes of the group."""
    os.killpg(process.pid, signal.SIGINT)
    problem = process.communicate(timeout=60)[1]
    assert (process.returncode, problem) == (130, "hsr: interrupted\n")


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("seconds", [0.0, 0.05, 0.1, 0.2, 0.4, 0.8, 1.5, 3.0])
def test_ctrl_c_is_one_line_and_130(scenes: Path, seconds: float) -> None:
    # What a shell starts in the background has SIGINT ignored; a terminal's command has not.
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    watched = ["-c", heard + "from hsr.cli import main; print('ready', flush=True); main()"]
    arguments = ["compare", "teapot", "-a", "zbuffer", "-a", "raycast", "--size", "2000", "--fresh"]
    process = subprocess.Popen(
        [sys.executable, *watched, *arguments],
        cwd=scenes.parent,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None and process.stdout.readline() == "ready\n"
    time.sleep(0.02 + seconds)
    interrupted(process)


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")
def test_a_reader_that_has_gone_is_no_difference(scenes: Path) -> None:
    process = started(scenes, "schema", "compare", stdout=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.close()
    process.stdout = None
    assert process.communicate() == (None, "") and process.returncode == 141


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no full disk here")
def test_a_full_disk_is_one_line_and_2(scenes: Path) -> None:
    with Path("/dev/full").open("w", encoding="ascii") as full:
        for arguments in (["scenes"], ["schema", "compare"], ["algos", "--json"]):
            process = started(scenes, *arguments, stdout=full)
            problem = process.communicate()[1]
            assert (process.returncode, problem) == (
                2,
                "hsr: standard output: No space left on device\n",
            )
