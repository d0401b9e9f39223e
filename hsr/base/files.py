"""Writing files: whole, or not at all; and the digest of what is written."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from threading import get_ident

from hsr.base.errors import HsrError


def write_whole(path: str | Path, data: bytes | str, what: str, error: type[HsrError] = HsrError) -> None:
    """Write a file, or leave what was there.

    Parameters
    ----------
    path : str or Path
    data : bytes or str
        Text is written as UTF-8, with a question mark for what is no character.
    what : str
        What the file is, for the message: ``"the map"``.
    error : type of HsrError
        What to raise.

    Raises
    ------
    HsrError
        Of the type ``error``, if the file cannot be written.
    """
    target = Path(path)
    # Short enough for every file system, however long the name is.
    unfinished = target.with_name(f".{target.name[:40]}.{os.getpid()}.{get_ident()}")
    try:
        try:
            unfinished.write_bytes(data if isinstance(data, bytes) else data.encode("utf-8", "replace"))
            unfinished.replace(target)
        finally:
            unfinished.unlink(missing_ok=True)
    except OSError as problem:
        raise error(f"{path}: cannot write {what}: {problem.strerror}") from problem


def make_folder(path: str | Path) -> Path:
    """Make a folder, and those above it, unless it is there.

    Raises
    ------
    HsrError
        If that fails.
    """
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise HsrError(f"{path}: cannot make the folder: {problem.strerror}") from problem
    return Path(path)


def check_new_folder(path: str | Path) -> None:
    """Refuse what :func:`write_folder` would not write to, before there is something to write.

    Raises
    ------
    HsrError
        If anything is there but an empty folder.
    """
    target = Path(path)
    if target.exists() and not (target.is_dir() and not any(target.iterdir())):
        raise HsrError(f"{path}: there is something already, which is left as it is; name a new folder")


def write_folder(path: str | Path, files: Mapping[str, bytes | str]) -> None:
    """Write a new folder with all its files, or nothing.

    Parameters
    ----------
    path : str or Path
        Nothing may be there, or an empty folder.
    files : mapping
        What each file holds by its name; text is written as UTF-8.

    Raises
    ------
    HsrError
        If there is something, or the folder cannot be written.
    """
    check_new_folder(path)
    target = Path(path)
    make_folder(target.parent)
    unfinished = target.absolute().with_name(f".{target.name[:40]}.{os.getpid()}.{get_ident()}")
    try:
        unfinished.mkdir()
        for name, data in files.items():
            (unfinished / name).write_bytes(data if isinstance(data, bytes) else data.encode())
        if target.exists():
            target.rmdir()  # where renaming does not replace an empty folder
        unfinished.rename(target)
    except OSError as problem:
        raise HsrError(f"{path}: cannot write the folder: {problem.strerror}") from problem
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)


def digest_of(parts: Iterable[bytes]) -> str:
    """Return the SHA-256 of some parts; where one ends and the next begins counts."""
    digest = hashlib.sha256()
    for part in parts:
        digest.update(len(part).to_bytes(8, "little"))
        digest.update(part)
    return digest.hexdigest()
