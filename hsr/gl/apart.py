"""Drivers tried in a process of its own, because a broken one may end it; what came of it is remembered."""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
import sysconfig
from functools import cache
from pathlib import Path

from hsr.base.errors import NoOpenGLError
from hsr.base.store import MEGABYTES, Store

PATIENCE = 60.0
"""Seconds in which a driver must have drawn the test picture."""

TIMED_OUT = 124
"""Exit code of a process that took longer."""

CRASHED = 0xC0000000
"""Exit codes of Windows from here on are those of processes that crashed; elsewhere they are below 0."""

KILLED = (-2, -9, -15)
"""Exit codes of processes that people end, or a system short of memory: they say nothing of the driver."""

VARIABLES = re.compile(
    r"_*(GALLIUM|MESA|LIBGL|LP|EGL|GLX|GL|DRI|GBM|ST|LD|VK|NV|NVIDIA|CUDA|ZINK|D3D12)_|.*DISPLAY$"
)
"""Names of environment variables that bear on which driver draws, and how."""

FOLDERS = ("/usr/lib", "/usr/lib64", "/usr/share/glvnd/egl_vendor.d", "/etc/glvnd/egl_vendor.d", "/dev/dri")
"""What changes when drivers do."""


def tried(code: str, patience: float) -> subprocess.CompletedProcess[str]:
    """Run code in a process of its own, with what this one may import; one that takes too long is ended."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", code]
    try:
        return subprocess.run(
            command,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=patience,
            check=False,
            env=environment,
        )
    except subprocess.TimeoutExpired:
        return subprocess.CompletedProcess(command, TIMED_OUT, "", f"no answer within {patience:g} seconds")


def check_survives(backend: str) -> None:
    """Have a process of its own open a backend and draw the test picture, once for all processes.

    Raises
    ------
    NoOpenGLError
        If the driver ends that process, or does not come back.
    """
    problem = _outcome(backend, _circumstances())
    if problem:
        raise NoOpenGLError(problem)


HANGS = "the driver hangs"


@cache
def _outcome(backend: str, circumstances: tuple[object, ...]) -> str:
    """Return how a driver ended a process; empty if it did not."""
    store, key = Store(megabytes=MEGABYTES), ("OpenGL", backend, circumstances)
    known = store.get(*key)
    if known is None:
        known = _ended(backend)
        # A machine may have been too busy just then.
        if not known.startswith(HANGS):
            store.put(known, *key)
    return str(known)


def _ended(backend: str) -> str:
    code = f"from hsr.gl.backends import BACKENDS\ntry: BACKENDS[{backend!r}]()\nexcept Exception: pass"
    try:
        run = tried(code, PATIENCE)
    except OSError:  # no process can be started here: all is as if nobody had asked
        return ""
    if run.returncode == TIMED_OUT:
        return f"{HANGS}: {run.stderr}"
    crashed = (run.returncode < 0 and run.returncode not in KILLED) or run.returncode >= CRASHED
    return f"the driver crashes: it ended a process with code {run.returncode}" if crashed else ""


def _circumstances() -> tuple[object, ...]:
    """Return what a driver depends on: machine, environment, and when libraries were changed."""
    folders = [*FOLDERS, f"/usr/lib/{sysconfig.get_config_var('MULTIARCH')}"]
    folders += [f"{folder}/dri" for folder in folders]
    folders += filter(None, os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep))
    changed = [folder.stat().st_mtime_ns for folder in map(Path, folders) if folder.is_dir()]
    chosen = sorted(item for item in os.environ.items() if VARIABLES.match(item[0]))
    return (platform.platform(), platform.node(), *chosen, *changed)
