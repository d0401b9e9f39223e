"""Results on disk, each under the digest of all that it is made of: what is there need not be made again.

A result on disk *is* the state: it is written whole or not at all, and whoever computes the same finds it.
The code of the package and the versions of what it computes with are part of every digest, so nothing is
found that other code has made.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import platform
import time
import zlib
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from hsr.base.errors import HsrError
from hsr.base.files import make_folder, write_whole

PLACE, LIMIT = "HSR_STORE", "HSR_STORE_MB"
"""Environment variables: the folder of the store, and how many megabytes it may hold."""

MEGABYTES = 1000
"""How many it may hold otherwise."""

WITH = ("numpy", "numba", "scipy", "python-flint", "moderngl")
"""Packages whose versions are part of every digest."""


@cache
def code() -> str:
    """Return the digest of this package's code and of the versions of what it computes with."""
    package = Path(__file__).parents[1]
    found = hashlib.sha256(repr([platform.python_version(), *map(version, WITH)]).encode())
    for file in sorted(package.rglob("*")):
        if file.suffix in (".py", ".html", ".js", ".css"):
            found.update(file.relative_to(package).as_posix().encode() + b"\0" + file.read_bytes())
    return found.hexdigest()


def _place() -> Path:
    """Return the folder of the store; for a user without a home one that nobody can make."""
    try:
        caches = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        return Path(os.environ.get(PLACE) or Path(caches) / "hsr")
    except RuntimeError:
        return Path(os.devnull, "hsr")


class Store:
    """A folder of results by their digests; those not asked for the longest go when it is full.

    Parameters
    ----------
    folder : Path, optional
        ``$HSR_STORE``, else ``hsr`` in the user's folder of caches.
    megabytes : int, optional
        ``$HSR_STORE_MB``, else 1000.
    fresh : bool
        Whether to find only what has been kept, or asked for, since now, by whichever process.

    Raises
    ------
    HsrError
        If ``$HSR_STORE_MB`` is no number.
    """

    def __init__(self, folder: Path | None = None, megabytes: int | None = None, fresh: bool = False) -> None:
        self.since = time.time() if fresh else 0.0
        self.folder = folder or _place()
        told = megabytes or os.environ.get(LIMIT) or MEGABYTES
        if not str(told).isdecimal():
            raise HsrError(f"{LIMIT}={told}: write a number of megabytes, such as {MEGABYTES}")
        self.limit = 2**20 * int(told)

    def place(self, *parts: Any) -> Path:
        """Return where the result lies that is made of parts, values that ``repr`` tells whole."""
        digest = hashlib.sha256(repr((code(), *parts)).encode()).hexdigest()
        return self.folder / digest[:2] / digest[2:]

    def get(self, *parts: Any) -> Any:
        """Return the result that is made of parts, or None."""
        place = self.place(*parts)
        try:
            if place.stat().st_mtime < self.since:
                return None
            found = pickle.loads(zlib.decompress(place.read_bytes()))
            place.touch()
            return found
        except Exception:  # What cannot be read, for whatever reason, is made again.
            return None

    def put(self, result: Any, *parts: Any) -> None:
        """Keep a result; :meth:`trim` makes room."""
        data, place = zlib.compress(pickle.dumps(result), level=1), self.place(*parts)
        # Where nothing can be written, nothing is kept.
        with suppress(HsrError):
            make_folder(place.parent)
            write_whole(place, data, "a result in the store")

    def trim(self) -> None:
        """Let go of results that were not asked for the longest, as long as there is no room for all."""
        files = [(file.stat().st_mtime, file.stat().st_size, file) for file in self.folder.glob("??/*")]
        held = sum(size for _, size, _ in files)
        for _, size, file in sorted(files):
            if held <= self.limit:
                break
            file.unlink(missing_ok=True)
            held -= size
