"""Drivers that crash or hang do so in a process of their own, once."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hsr.base.errors import NoOpenGLError
from hsr.gl import apart
from hsr.gl.backends import open_context

CRASH = "import os; os.kill(os.getpid(), 11)"


@pytest.fixture
def asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """Run something else in place of the driver; the list is of what was run, its first entry is to be."""
    run, done = apart.tried, [""]

    def instead(_code: str, patience: float) -> subprocess.CompletedProcess[str]:
        done.append(done[0])
        return run(done[0], patience)

    monkeypatch.setenv("HSR_STORE", str(tmp_path / "store"))
    monkeypatch.setattr(apart, "tried", instead)
    apart._outcome.cache_clear()
    yield done
    apart._outcome.cache_clear()


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_a_driver_that_crashes_is_said_to_and_remembered(asked: list[str]) -> None:
    asked[0] = CRASH
    for _ in range(2):  # another process would find it in the store
        with pytest.raises(NoOpenGLError, match=f"osmesa: the driver crashes: .* code {-signal.SIGSEGV}"):
            open_context("osmesa")
        apart._outcome.cache_clear()
    assert len(asked) == 2


def test_another_environment_is_another_driver(asked: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    for count, variable in enumerate(
        ("GALLIUM_DRIVER", "LIBGL_DRIVERS_PATH", "__EGL_VENDOR_LIBRARY_FILENAMES")
    ):
        apart.check_survives("osmesa")
        assert len(asked) == 2 + count
        monkeypatch.setenv(variable, "other")
    monkeypatch.setenv("HOME", "/elsewhere")
    apart.check_survives("osmesa")
    apart.check_survives("osmesa")
    assert len(asked) == 5
    apart.check_survives("egl")
    assert len(asked) == 6


def test_a_driver_that_hangs_is_waited_for_no_longer(
    asked: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(apart, "PATIENCE", 0.3)
    asked[0] = "import time; time.sleep(60)"
    with pytest.raises(NoOpenGLError, match=r"the driver hangs: no answer within 0\.3 seconds"):
        apart.check_survives("egl")


@pytest.mark.parametrize("executable", ["/no/python", sys.executable])
def test_a_process_that_says_nothing_of_the_driver_is_no_judgement(
    asked: list[str], monkeypatch: pytest.MonkeyPatch, executable: str
) -> None:
    asked[0] = "raise SystemExit(3)"
    monkeypatch.setattr(sys, "executable", executable)
    apart.check_survives("egl")


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("number", [2, 9, 15])
def test_a_process_that_others_end_is_no_judgement(asked: list[str], number: int) -> None:
    asked[0] = f"import os, signal; signal.signal(2, signal.SIG_DFL); os.kill(os.getpid(), {number})"
    apart.check_survives("egl")


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_where_nothing_can_be_written_a_crash_is_found_all_the_same(
    asked: list[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("HSR_STORE", str(tmp_path / "file" / "store"))
    asked[0] = CRASH
    for _ in range(2):
        with pytest.raises(NoOpenGLError, match="the driver crashes"):
            apart.check_survives("egl")
    assert len(asked) == 2  # this process remembers


def test_what_tries_a_driver_imports_no_kernels() -> None:
    code = "import sys, hsr.gl.backends; print(*{'numba', 'scipy', 'matplotlib'} & {*sys.modules})"
    assert apart.tried(code, 60.0).stdout == "\n"


def test_a_driver_that_crashes_is_a_column_that_is_left_out(scenes: Path, tmp_path: Path) -> None:
    code = (
        "import sys, hsr.gl.apart as apart\n"
        "apart._ended = lambda backend: 'the driver crashes'\n"
        "from hsr.cli import main\n"
        "main()"
    )
    compare: list[Any] = [sys.executable, "-c", code, "compare", scenes / "cube.toml", "--size", "8", "-q"]
    environment = {**os.environ, "HSR_STORE": str(tmp_path)}
    for asked, ended in (((), 0), (("-a", "opengl"), 3)):
        run = subprocess.run([*compare, *asked], capture_output=True, text=True, check=False, env=environment)
        assert run.returncode == ended
        assert "the driver crashes" in run.stdout + run.stderr
