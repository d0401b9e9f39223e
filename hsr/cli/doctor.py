"""The command ``hsr doctor``: what this machine has of what the methods need, and what to install."""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
from collections.abc import Iterator
from typing import Any

import hsr
from hsr.base.errors import HsrError
from hsr.cli import common as cli

PACKAGES = (
    *("hsr-lab", "numpy", "numba", "scipy", "python-flint", "moderngl", "glcontext"),
    *("matplotlib", "pydantic"),
)

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")

PATIENCE = 300.0
"""Seconds a backend may take: the first run on a machine compiles kernels."""

INSTALL = "apt-get install -y --no-install-recommends"

SCENE = "interpenetrating"
"""Some of its faces hide others, and surfaces meet within the picture."""


def doctor(as_json: cli.Json = False) -> None:
    """Try every OpenGL backend and optional library, and say what to install.

    For example:

        hsr doctor
    """
    found = diagnose()
    cli.tell(as_json, "doctor", found, lines(found))


def diagnose() -> dict[str, Any]:
    """Try every OpenGL backend and optional library.

    Each backend is tried in a process of its own, because a broken driver may end it.

    Returns
    -------
    dict
        JSON values only. ``opengl`` has an entry a backend (see :func:`probe`), ``advice`` the
        lines a person should read: what to install, empty if nothing is missing.
    """
    from numba import get_num_threads

    from hsr.lab.machine import version_of

    threads = {"processors": os.cpu_count(), "numba": get_num_threads()}
    found = {
        "python": platform.python_version(),
        "platform": platform.platform(),
        "packages": {name: version_of(name) for name in PACKAGES},
        "threads": threads | {"LP_NUM_THREADS": os.environ.get("LP_NUM_THREADS")},
        "opengl": {backend: _probe_apart(backend) for backend in ("osmesa", "egl")},
        "embree": version_of("embreex"),
        "browser": next(filter(None, map(shutil.which, BROWSERS)), None),
    }
    return found | {"advice": list(_advice(found))}


def lines(found: dict[str, Any]) -> Iterator[str]:
    """Yield what :func:`diagnose` found as lines for people."""
    yield f"Python {found['python']}, {found['platform']}"
    yield ", ".join(f"{name} {version or 'missing'}" for name, version in found["packages"].items())
    yield "threads: {processors} processors, numba {numba}".format(**found["threads"])
    for backend, state in found["opengl"].items():
        yield f"OpenGL by {backend}: {_opengl_line(state)}"
    yield f"Embree: {'embreex ' + found['embree'] if found['embree'] else 'missing'}"
    yield f"browser for the tests of the report: {found['browser'] or 'missing'}"
    for advice in found["advice"]:
        yield f"to do: {advice}"


def _opengl_line(state: dict[str, Any]) -> str:
    if not state["draws"]:
        return f"not usable: {state['problem']}"
    return (
        f"draws. {state['renderer']}, {state['version']}; corners to 1/{2 ** state['subpixel_bits']} pixel, "
        f"depth of {state['depth_bits']} bits; {state['different']} of {state['samples']} samples "
        "differ from zbuffer"
    )


# ---------------------------------------------------------------- OpenGL


def probe(backend: str) -> dict[str, Any]:
    """Open a backend in this process, have it draw the test picture, and compare it with zbuffer.

    Parameters
    ----------
    backend : {"osmesa", "egl"}

    Returns
    -------
    dict
        ``draws``: whether it opened and drew the test picture right. If so, ``renderer``,
        ``version``, ``subpixel_bits``, ``depth_bits``, ``max_side``, ``threads``, and how many of
        ``samples`` are ``different`` from zbuffer's in a small scene; a few may be, along edges.
        If not, ``problem``.
    """
    from hsr.gl.backends import BACKENDS
    from hsr.gl.depth import D24

    try:
        context = BACKENDS[backend]()
        seen = hsr.view(hsr.load(SCENE), (64, 64))
        drawn, ours = hsr.render(seen, "opengl", backend=backend), hsr.render(seen, "zbuffer")
    except HsrError as error:
        return {"draws": False, "problem": str(error)}
    told = {name: getattr(context, name) for name in ("renderer", "version", "subpixel_bits")}
    told |= {"depth_bits": D24.bits, "max_side": context.max_side, "threads": context.threads}
    different = int((drawn.face != ours.face).sum())
    return {"draws": True, **told, "different": different, "samples": drawn.face.size}


def _probe_apart(backend: str) -> dict[str, Any]:
    from hsr.gl.apart import TIMED_OUT, tried

    code = f"import json, hsr.cli.doctor as d; print(json.dumps(d.probe({backend!r})))"
    run = tried(code, PATIENCE)
    try:
        return dict(json.loads(run.stdout))
    except json.JSONDecodeError:
        last = (run.stderr.strip().splitlines() or ["no message"])[-1]
        ended = f"trying it ended a process with code {run.returncode}: {last}"
        return {"draws": False, "problem": last if run.returncode == TIMED_OUT else ended}


# ---------------------------------------------------------------- the rest


def _advice(found: dict[str, Any]) -> Iterator[str]:
    if not any(state["draws"] for state in found["opengl"].values()):
        yield _opengl_advice()
    if not found["embree"]:
        yield "for Embree: pip install 'hsr-lab[embree]'"
    if not found["browser"]:
        yield f"for the tests of the report: {INSTALL} chromium"


def _opengl_advice() -> str:
    driver = os.environ.get("GALLIUM_DRIVER")
    if driver not in (None, "llvmpipe"):
        return f"for OpenGL: unset GALLIUM_DRIVER, which asks for {driver}"
    if not shutil.which("apt-get"):
        return "for OpenGL: install OSMesa, or EGL with Mesa's llvmpipe, by this system's package manager"
    packages = "libosmesa6" if _apt_knows("libosmesa6") else "libegl1 libgl1 libgl1-mesa-dri"
    return f"for OpenGL: {INSTALL} {packages}"


def _apt_knows(package: str) -> bool:
    """Whether apt can install a package; OSMesa left Mesa with version 25.1."""
    return subprocess.run(["apt-cache", "show", package], capture_output=True, check=False).returncode == 0
