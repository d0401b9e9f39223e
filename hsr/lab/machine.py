"""The machine a benchmark runs on: what it is, what else it does, and how much memory is taken.

Linux tells all of it under ``/proc``; elsewhere the figures are None.
"""

from __future__ import annotations

import ctypes
import os
import platform
import re
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from hsr.base.jit import thread_count
from hsr.lab.results import Machine

PACKAGES = ("hsr-lab", "numpy", "numba", "scipy", "moderngl", "embreex")
VARIABLES = ("OMP_WAIT_POLICY", "GOMP_SPINCOUNT", "NUMBA_NUM_THREADS", "NUMBA_CPU_NAME", "LP_NUM_THREADS")

ROOT = Path(__file__).parents[2]
"""The checkout, if the package is not installed for good."""

Made = TypeVar("Made")

Clocks = tuple[float, float, float]
"""Seconds of the wall clock, of all processors busy, and of this process and its children."""

STAT = Path("/proc/stat")
STATUS = Path("/proc/self/status")
CLEAR_REFS = Path("/proc/self/clear_refs")


def equal_threads() -> int:
    """Give llvmpipe as many threads as Numba has, unless the environment says otherwise.

    Must run before the first OpenGL context of the process opens.

    Returns
    -------
    int
        The number of threads.
    """
    threads = int(thread_count())
    os.environ.setdefault("LP_NUM_THREADS", str(threads))
    return threads


def machine() -> Machine:
    """Describe the machine and what the figures were made with."""
    cpu, threads = _cpu(), int(thread_count())
    known = {package: version_of(package) for package in PACKAGES}
    versions = {"python": platform.python_version()} | {name: told for name, told in known.items() if told}
    environment = {name: os.environ[name] for name in VARIABLES if name in os.environ}
    name = f"{re.sub('[^a-z0-9]+', '-', cpu.lower()).strip('-')}-{threads}"
    on: dict[str, Any] = {"cpu": cpu, "processors": os.cpu_count() or 1, "threads": threads}
    return Machine(name=name, system=platform.platform(), versions=versions, environment=environment, **on)


def version_of(package: str) -> str | None:
    """Return the version of an installed package, None if it is missing."""
    with suppress(PackageNotFoundError):
        return version(package)
    return None


def _cpu() -> str:
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def commit() -> str | None:
    """Return the checkout's commit, with ``-dirty`` if files differ from it; None outside a checkout."""
    if not (ROOT / ".git").exists():
        return None
    describe = ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--exclude", "*"]
    with suppress(OSError, subprocess.CalledProcessError):
        return subprocess.check_output(describe, text=True, stderr=subprocess.DEVNULL).strip()
    return None


# ---------------------------------------------------------------- load


def foreign_load(since: Clocks | None) -> float | None:
    """Return how many processors others kept busy since then, on average; None if the system does not say."""
    now = clocks()
    if since is None or now is None:
        return None
    wall, busy, own = np.subtract(now, since)
    return round(max(float(busy - own), 0.0) / float(wall), 2)


def clocks() -> Clocks | None:
    """Read the clocks; None if the system does not say."""
    try:
        user, nice, system, _, _, irq, softirq, steal = map(int, STAT.read_text().split()[1:9])
    except (OSError, ValueError):
        return None
    busy = (user + nice + system + irq + softirq + steal) / os.sysconf("SC_CLK_TCK")
    return time.perf_counter(), busy, sum(os.times()[:4])


NUMBERS = np.random.default_rng(1).random(2**16)
"""What the yardstick sorts, in a third of a millisecond or so."""


def yardstick() -> float:
    """Return the milliseconds of a fixed piece of work on one thread: how fast the machine itself is."""
    start = time.perf_counter()
    np.sort(NUMBERS)
    return 1e3 * (time.perf_counter() - start)


# ---------------------------------------------------------------- memory


def peak_of(work: Callable[[], Made]) -> tuple[Made, int | None]:
    """Do some work; return what it makes, and how many bytes the resident memory rose, None if nothing says.

    Freed memory that the allocator still holds is given back first, lest it hide what the work takes.
    """
    before: int | None = None
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).malloc_trim(0)
    with suppress(OSError):
        CLEAR_REFS.write_text("5")  # Linux forgets how much was resident at most: proc(5), clear_refs
        before = _resident("VmRSS")
    made, after = work(), _resident("VmHWM")
    return made, None if before is None or after is None else max(after - before, 0)


def _resident(field: str) -> int | None:
    with suppress(OSError):
        found = re.search(rf"^{field}:\s*(\d+) kB$", STATUS.read_text(), flags=re.MULTILINE)
        return None if found is None else 1024 * int(found[1])
    return None
