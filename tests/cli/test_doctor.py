from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

import pytest

from hsr.base.errors import UnavailableError
from hsr.cli import doctor
from hsr.gl import backends
from tests.gl.conftest import opened

DRAWS = {
    "draws": True,
    "renderer": "llvmpipe",
    "version": "4.5 Mesa",
    "subpixel_bits": 8,
    "depth_bits": 24,
    "max_side": 16384,
    "threads": 2,
    "different": 0,
    "samples": 4096,
}
BROKEN = {"draws": False, "problem": "libOSMesa.so.8 is not installed"}


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Pretend what a machine has."""

    def pretend(osmesa: Any = BROKEN, egl: Any = BROKEN, missing: tuple[str, ...] = ()) -> Any:
        states = {"osmesa": osmesa, "egl": egl}
        monkeypatch.delenv("GALLIUM_DRIVER", raising=False)
        monkeypatch.setattr(doctor, "_probe_apart", states.__getitem__)
        monkeypatch.setattr("hsr.lab.machine.version_of", lambda name: None if name in missing else "1.0")
        monkeypatch.setattr(doctor.shutil, "which", lambda name: None if name in missing else f"/bin/{name}")
        monkeypatch.setattr(doctor, "_apt_knows", lambda name: name not in missing)
        return doctor.diagnose()

    return pretend


def test_nothing_is_advised_where_one_backend_draws(machine: Any) -> None:
    found = machine(egl=DRAWS)
    assert found["advice"] == []
    assert json.loads(json.dumps(found)) == found
    text = "\n".join(doctor.lines(found))
    assert "OpenGL by osmesa: not usable: libOSMesa.so.8 is not installed" in text
    assert "OpenGL by egl: draws. llvmpipe, 4.5 Mesa; corners to 1/256 pixel" in text
    assert "0 of 4096 samples differ from zbuffer" in text
    assert "to do" not in text


def test_osmesa_is_advised_where_apt_knows_it(machine: Any) -> None:
    found = machine()
    assert found["advice"] == ["for OpenGL: apt-get install -y --no-install-recommends libosmesa6"]
    assert f"to do: {found['advice'][0]}" in list(doctor.lines(found))


def test_egl_is_advised_where_mesa_no_longer_has_osmesa(machine: Any) -> None:
    line = "for OpenGL: apt-get install -y --no-install-recommends libegl1 libgl1 libgl1-mesa-dri"
    assert machine(missing=("libosmesa6",))["advice"] == [line]


def test_without_apt_the_libraries_are_named(machine: Any) -> None:
    (line,) = machine(missing=("apt-get",))["advice"]
    assert "OSMesa" in line and "EGL" in line and "apt-get" not in line


def test_a_driver_asked_for_by_name_is_the_first_suspect(
    machine: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = machine()
    monkeypatch.setenv("GALLIUM_DRIVER", "softpipe")
    assert list(doctor._advice(found)) == ["for OpenGL: unset GALLIUM_DRIVER, which asks for softpipe"]


def test_embree_and_a_browser_are_advised(machine: Any) -> None:
    found = machine(osmesa=DRAWS, missing=("embreex", *doctor.BROWSERS))
    assert found["advice"] == [
        "for Embree: pip install 'hsr-lab[embree]'",
        "for the tests of the report: apt-get install -y --no-install-recommends chromium",
    ]


def test_a_backend_that_does_not_open_is_a_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    def gone() -> Any:
        raise UnavailableError("softpipe draws 44 of 64 samples of the test picture wrong")

    monkeypatch.setitem(backends.BACKENDS, "egl", gone)
    assert doctor.probe("egl") == {
        "draws": False,
        "problem": "softpipe draws 44 of 64 samples of the test picture wrong",
    }


@pytest.mark.parametrize(
    ("code", "problem"),
    [
        ("import os; os.abort()", "trying it ended a process with code -6: no message"),
        ("raise OSError('no such device')", "trying it ended a process with code 1: OSError: no such device"),
    ],
)
def test_a_backend_that_crashes_is_a_finding(
    monkeypatch: pytest.MonkeyPatch, code: str, problem: str
) -> None:
    run = subprocess.run

    def crash(_command: Any, **options: Any) -> Any:
        return run([sys.executable, "-c", code], **options)

    monkeypatch.setattr(doctor.subprocess, "run", crash)
    assert doctor._probe_apart("egl") == {"draws": False, "problem": problem}


def test_a_backend_that_hangs_is_a_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "PATIENCE", 0.01)
    assert doctor._probe_apart("egl") == {"draws": False, "problem": "no answer within 0.01 seconds"}


@pytest.mark.jit
@pytest.mark.parametrize("backend", ["osmesa", "egl"])
def test_the_real_machine(backend: str) -> None:
    opened(backend).release()
    state = doctor._probe_apart(backend)
    assert state["draws"], state
    assert state["different"] <= state["samples"] // 200
