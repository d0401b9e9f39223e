"""The one Numba decorator of the package.

No ``fastmath``, not even contraction of ``a * b + c``: the signs that decide visibility must be
those of plain IEEE arithmetic, on every processor. ``error_model="numpy"`` makes a division by
zero an infinity instead of an exception. Compiled kernels are cached on disk, where that can be written.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache, wraps
from pathlib import Path
from threading import RLock
from types import SimpleNamespace
from typing import Any, TypeVar, cast

# An idle thread of GNU OpenMP spins for some 8 ms before it sleeps. On a busy machine that takes time from
# others, even from the threads it waits for, so let it be some 30 us: less than it takes to wake up.
if "OMP_WAIT_POLICY" not in os.environ:
    os.environ.setdefault("GOMP_SPINCOUNT", "1000")

import numba
from numba.core.caching import FunctionCache
from numba.np.ufunc.parallel import threading_layer

from hsr.base.errors import HsrError

Function = TypeVar("Function", bound=Callable[..., Any])

IMPORT = re.compile(rb"^from hsr\.([\w.]+) import", re.MULTILINE)

prange = numba.prange
thread_count = numba.get_num_threads


def jit(function: Function) -> Function:
    """Compile a kernel of numbers and arrays for one thread."""
    return cast(Function, _cached(function, nogil=True))


def inline_jit(function: Function) -> Function:
    """Compile a small kernel into each of its callers: passing arrays takes longer than some of them do."""
    return cast(Function, _cached(function, nogil=True, forceinline=True))


def parallel_jit(function: Function) -> Function:
    """Compile a kernel whose ``prange`` loops run on all threads, each of which takes one run of iterations.

    The result must not depend on how the iterations are shared out among the threads.
    Only Python may call it.

    Raises
    ------
    HsrError
        When called in a process that was forked from one with threads of GNU OpenMP, which stay there.
    """
    kernel = _cached(function, parallel=True)

    @wraps(function)
    def run(*given: Any) -> Any:
        if _threads.lost:
            raise HsrError(LOST)
        if _layer() in SHARED:
            return kernel(*given)
        with _threads.alone:
            return kernel(*given)

    vars(run)["py_func"] = function  # as kernels for one thread have it
    return cast(Function, run)


class _Cache(FunctionCache):
    """Numba's kernels on disk, where what is damaged is compiled again, and a full disk does not matter."""

    def load_overload(self, *given: Any) -> Any:
        try:
            return super().load_overload(*given)  # type: ignore[no-untyped-call]
        except Exception:  # reading what is damaged raises almost anything
            with suppress(Exception):
                self.flush()  # type: ignore[no-untyped-call]
            return None

    def save_overload(self, *given: Any) -> None:
        with suppress(Exception):
            super().save_overload(*given)  # type: ignore[no-untyped-call]


def _cached(function: Function, **options: Any) -> Any:
    """Compile a kernel that is kept on disk; where no folder can be written, for this process alone."""
    kernel = numba.njit(error_model="numpy", **options)(function)
    _kernels.append(kernel)
    try:
        kernel._cache = _Cache(function)  # type: ignore[no-untyped-call]
    except (OSError, RuntimeError):
        _tell_uncached()
    return kernel


_kernels: list[Any] = []


def kernels_loaded() -> int:
    """Return how many kernels, by the types of what they take, this process has compiled or loaded."""
    return sum(len(getattr(kernel, "overloads", ())) for kernel in _kernels)


@cache
def _tell_uncached() -> None:
    """Say, once, why everything takes long."""
    told = "compiled kernels cannot be kept, so all is compiled every time: name a folder in NUMBA_CACHE_DIR"
    print(f"hsr: {told}", file=sys.stderr)


SHARED = ("omp", "tbb")
"""The layers of threads that several threads of Python may use at once."""

LOST = (
    "this process was forked after kernels had run, and lacks their threads: start processes otherwise, "
    "as by multiprocessing.get_context('spawn'), or before the first picture"
)


_threads = SimpleNamespace(lost=False, alone=RLock())


def _layer() -> str:
    """Name what makes the threads of kernels; empty before the first has run."""
    try:
        return str(threading_layer())  # type: ignore[no-untyped-call]
    except ValueError:
        return ""


def _after_fork() -> None:
    """Forget a lock that a thread of the parent may hold; GNU OpenMP's threads stay behind."""
    _threads.lost |= _layer() == "omp"
    _threads.alone = RLock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


def forget_stale_kernels(package: Path) -> None:
    """Drop cached kernels made of sources that have changed since they were compiled.

    Numba looks at the file of a function only. A kernel cached with an older version of another
    module's function or constant within it would go on computing by that version. Kernels are in the
    folders where the decorators of this module stand, and are made of what they import from these.

    Parameters
    ----------
    package : Path
        Where it cannot be written there is no cache in it.
    """
    folders = {file.parent for file in package.rglob("*.py") if b"jit\ndef " in file.read_bytes()}
    sources = {file: file.read_bytes() for folder in folders for file in folder.glob("*.py")}
    made_of = _made_of(package, sources)
    stamp = package / "kernels" / "__pycache__" / "sources.json"
    try:
        known = _told(stamp)
        if known == made_of:
            return
        for name, digest in made_of.items():
            if known.get(name) != digest:
                file = package / name
                for cached in file.parent.glob(f"__pycache__/{file.stem}.*.nb[ic]"):
                    cached.unlink(missing_ok=True)
        for cached in stamp.parent.glob("*.compiled"):
            cached.unlink(missing_ok=True)
        stamp.parent.mkdir(exist_ok=True)
        unfinished = stamp.with_suffix(f".{os.getpid()}")
        unfinished.write_text(json.dumps(made_of), encoding="ascii")
        unfinished.replace(stamp)
    except OSError:
        pass


def _told(stamp: Path) -> dict[str, str]:
    """Return what the kernels were made of that are kept; nothing is known if that cannot be read."""
    try:
        found = json.loads(stamp.read_bytes())
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _made_of(package: Path, text: dict[Path, bytes]) -> dict[str, str]:
    """Return the digest of each source and of all that it imports, by its path in the package."""
    imported = {file: _imported(package, text, file) for file in text}
    made = {}
    for file in text:
        found: set[Path] = set()
        new = {file}
        while new:
            found |= new
            new = set().union(*(imported[source] for source in new)) - found
        digest = hashlib.sha256(b"".join(text[source] for source in sorted(found)))
        made[file.relative_to(package).as_posix()] = digest.hexdigest()
    return made


def _imported(package: Path, text: dict[Path, bytes], file: Path) -> set[Path]:
    """Return the sources that a file imports from: modules, and all those of a folder."""
    places = {package.joinpath(*name.decode().split(".")) for name in IMPORT.findall(text[file])}
    return {source for source in text if source.with_suffix("") in places or source.parent in places}


def is_compiled(method: str) -> bool:
    """Tell whether the kernels of a method have been compiled here before, as far as is known."""
    return os.path.exists(_stamp(method))  # noqa: PTH110  # not to be read is not to be there


def note_compiled(method: str) -> None:
    """Note that the kernels of a method are compiled."""
    with suppress(OSError):
        _stamp(method).touch()


def _stamp(method: str) -> Path:
    """Return the file that stands for the cached kernels of a method."""
    folder = os.environ.get("NUMBA_CACHE_DIR") or Path(__file__).parents[1] / "kernels" / "__pycache__"
    kind = os.environ.get("NUMBA_CPU_NAME", "host")
    return Path(folder) / f"{method}-{sys.implementation.cache_tag}-{kind}.compiled"


forget_stale_kernels(Path(__file__).parents[1])
