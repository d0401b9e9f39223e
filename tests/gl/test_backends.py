from __future__ import annotations

import ctypes
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import moderngl
import pytest

from hsr.base.errors import UnavailableError
from hsr.gl import backends, drawing, selftest
from hsr.gl.backends import open_context
from hsr.gl.context import Context
from hsr.gl.loaders import osmesa, osmesa_library
from hsr.gl.selftest import flaw
from tests.gl.conftest import opened


def handles() -> tuple[int, int]:
    """Open files and threads of this process."""
    return tuple(len(list(Path("/proc/self", what).iterdir())) for what in ("fd", "task"))


def test_a_context_says_what_draws(backend: str) -> None:
    context = open_context(backend)
    assert context.backend == backend
    assert context.renderer and context.version
    assert context.subpixel_bits >= 4
    assert context.max_side >= 1024
    context.release()


def test_a_driver_that_draws_nothing_is_refused(context: Context, monkeypatch: pytest.MonkeyPatch) -> None:
    assert flaw(context) is None
    monkeypatch.setattr(drawing, "_runs", lambda _cull: [])
    assert flaw(context) == "draws 44 of 64 samples of the test picture wrong"
    with pytest.raises(UnavailableError, match=r"draws 44 of 64 .*'hsr doctor'"):
        open_context("auto")


def test_a_driver_without_a_depth_test_is_refused(context: Context, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawing, "_set_culling", lambda gl, _cull: gl.enable_only(moderngl.NOTHING))
    assert "samples of the test picture wrong" in str(flaw(context))


def test_a_driver_with_a_coarse_depth_buffer_is_refused(
    context: Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    exact = drawing.depth_of_window
    monkeypatch.setattr(drawing, "depth_of_window", lambda *given: exact(*given) + 2.0**-16)
    assert flaw(context) == "stores wrong depths of the test picture"


@pytest.mark.skipif(sys.platform != "linux", reason="softpipe is Mesa's")
def test_a_context_that_opens_and_does_not_draw_is_refused() -> None:
    opened("osmesa").release()
    code = (
        "import os; os.environ['GALLIUM_DRIVER'] = 'softpipe'\n"
        "from hsr.gl.backends import open_context\n"
        "from hsr.base.errors import UnavailableError\n"
        "try: print('draws', open_context('osmesa').renderer)\n"
        "except UnavailableError as error: print('refused', error)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "softpipe" in run.stdout
    assert run.stdout.startswith(("refused", "draws softpipe"))


# ---------------------------------------------------------------- the chain


class FakeContext:
    """A context whose driver is the loader's name."""

    opened: int
    released: list[str]

    def __init__(self, _backend: str, loader: Any) -> None:
        self.renderer = loader
        FakeContext.opened += 1
        assert FakeContext.opened - len(self.released) <= 2, "the one that is kept and the one that is tried"

    def release(self) -> None:
        self.released.append(self.renderer)


def walk(devices: dict[int, str], monkeypatch: pytest.MonkeyPatch) -> tuple[str, list[str]]:
    def device(index: int) -> str:
        if index not in devices:
            raise UnavailableError(f"no device {index}")
        return devices[index]

    FakeContext.opened, FakeContext.released = 0, []
    monkeypatch.setattr(backends, "egl", device)
    monkeypatch.setattr(backends, "Context", FakeContext)
    monkeypatch.setattr(backends, "flaw", lambda _context: None)
    return backends._open_egl().renderer, FakeContext.released


def test_egl_prefers_the_device_of_llvmpipe(monkeypatch: pytest.MonkeyPatch) -> None:
    assert walk({0: "GPU 0", 2: "GPU 1", 3: "llvmpipe (LLVM)"}, monkeypatch) == (
        "llvmpipe (LLVM)",
        ["GPU 1", "GPU 0"],
    )


def test_egl_takes_the_first_device_where_none_is_llvmpipe(monkeypatch: pytest.MonkeyPatch) -> None:
    assert walk({1: "GPU 0", 2: "GPU 1"}, monkeypatch) == ("GPU 0", ["GPU 1"])
    assert len(walk({index: f"GPU {index}" for index in range(5)}, monkeypatch)[1]) == 4


def test_egl_without_devices_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UnavailableError, match="no device 0"):
        walk({}, monkeypatch)


def refuse(reason: str) -> Any:
    def open_nothing() -> Context:
        raise UnavailableError(reason)

    return open_nothing


def test_the_first_backend_that_draws_is_used(context: Context, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(backends, "BACKENDS", {"osmesa": refuse("gone"), "egl": lambda: context})
    assert open_context("auto") is context


def test_no_backend_is_one_clear_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(backends, "BACKENDS", {"osmesa": refuse("gone"), "egl": refuse("no device")})
    with pytest.raises(UnavailableError) as caught:
        open_context("auto")
    assert str(caught.value) == (
        "no OpenGL that draws (osmesa: gone; egl: no device); 'hsr doctor' says what to install"
    )
    with pytest.raises(UnavailableError, match=r"\(egl: no device\)"):
        open_context("egl")


def test_a_missing_library_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hsr.gl.loaders.OSMESA_LIBRARIES", ("libOSMesa.so.missing",))
    monkeypatch.setattr("hsr.gl.loaders.find_library", lambda _name: None)
    with pytest.raises(UnavailableError, match=r"libOSMesa\.so\.missing is not installed"):
        open_context("osmesa")


# ---------------------------------------------------------------- living together, leaving


@pytest.mark.parametrize("pair", [("osmesa", "osmesa"), ("egl", "egl"), ("osmesa", "egl")])
def test_two_contexts_alive_at_once_both_draw(pair: tuple[str, str]) -> None:
    alive = [opened(backend) for backend in pair]
    for context in alive * 2:
        assert flaw(context) is None
    alive[0].release()
    assert flaw(alive[1]) is None
    alive[1].release()


def test_no_error_is_left_behind(context: Context) -> None:
    for _ in range(2):
        assert flaw(context) is None
        with context.gl as gl:
            assert gl.error == "GL_NO_ERROR"


def test_a_context_is_current_only_while_it_is_used() -> None:
    opened("osmesa").release()
    loader, current = osmesa(), osmesa_library().OSMesaGetCurrentContext
    current.restype = ctypes.c_void_p
    with loader:
        assert current()
    assert not current()
    loader.release()


def test_threads_take_turns(context: Context) -> None:
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(lambda _: flaw(context), range(40))) == [None] * 40


@pytest.mark.skipif(sys.platform != "linux", reason="counts handles in /proc")
def test_contexts_come_and_go_without_leaving_handles(backend: str) -> None:
    open_context(backend).release()
    before = handles()
    for _ in range(30):
        open_context(backend).release()
    assert handles() == before


def test_the_interpreter_ends_cleanly(backend: str) -> None:
    code = (
        "from hsr.gl.backends import open_context, shared_context\n"
        f"open_context('{backend}'); print(shared_context('{backend}').backend)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stdout, run.stderr) == (0, f"{backend}\n", "")


def test_llvmpipe_says_with_how_many_threads_it_draws(
    context: Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LP_NUM_THREADS", "3")
    monkeypatch.setattr(context, "renderer", "llvmpipe (LLVM 15)")
    assert context.threads == 3
    monkeypatch.setattr(context, "renderer", "some GPU")
    assert context.threads is None


def test_the_test_picture_has_each_triangle_before_the_other() -> None:
    """Drawn without a depth test, the second triangle would own columns 0 to 3 of the last rows too."""
    left, right = selftest.picture().triangles
    assert (selftest.FACE[5:, :4] == 0).all() and (selftest.FACE[5:, 4:] == 1).all()
    assert left[:, 0].max() > 0 > right[:, 0].min()
