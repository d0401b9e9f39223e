"""What all readers share: bytes, packed or not, lines, and words that are numbers."""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from gzip import BadGzipFile, GzipFile
from io import BytesIO
from math import nan
from pathlib import Path

import numpy as np

from hsr.base.errors import SceneError
from hsr.scene.names import printable

PACKED = ".gz"

MAX_UNPACKED = 1 << 30
"""Bytes that a packed file may hold: a small one may unpack to more than any memory."""

LINE = re.compile(rb"([^\r\n]*)(\r\n|\r|\n|\Z)")
"""A line and how it ends."""

COMMENT = re.compile(rb"(?<!\d\.)#|#(?!IND|INF|QNAN|SNAN)")
"""Where a comment starts; numbers may hold the same character, as ``-1.#IND``."""

NOT_A_NUMBER = re.compile(rb"[+-]?(\d\.#\w+|nan\(\w*\))", re.IGNORECASE)
"""What C libraries write for NaN and infinity, such as ``-1.#IND``."""


def ending_of(path: Path) -> str:
    """Return the ending of a name that says what a file is, in lower case: ``.ply`` of ``a.PLY.gz``."""
    return _unpacked(path).suffix.lower()


def stem_of(path: Path) -> str:
    """Return the name without its ending: ``a`` of ``a.ply.gz``."""
    return _unpacked(path).stem


def _unpacked(path: Path) -> Path:
    return path.with_suffix("") if path.suffix.lower() == PACKED else path


def content_of(path: Path) -> bytes:
    """Return the bytes of a file, unpacked if its name ends in ``.gz``.

    Raises
    ------
    SceneError
        If it cannot be unpacked, or holds more than ``MAX_UNPACKED`` bytes.
    OSError
        If it cannot be read at all.
    """
    content = path.read_bytes()
    if path.suffix.lower() != PACKED:
        return content
    try:
        with GzipFile(fileobj=BytesIO(content)) as packed:
            content = packed.read(MAX_UNPACKED + 1)
    except (BadGzipFile, EOFError, zlib.error) as error:
        raise SceneError(f"not a readable gzip file ({error})") from None
    if len(content) > MAX_UNPACKED:
        raise SceneError(f"it unpacks to more than {MAX_UNPACKED >> 20} MiB; unpack it first")
    return content


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Blame the file for whatever its reader stumbles over in the ``with`` block."""
    try:
        # What overflows, or is no number, is told of when a face uses it.
        with np.errstate(all="ignore"):
            yield
    except SceneError as error:
        # Names that a file gives may have any characters.
        raise SceneError([*map(printable, error.problems)]) from error.__cause__
    except OSError:
        raise
    except Exception as error:
        reason = printable(" ".join(f"{type(error).__name__}: {error}".split()))
        name = ending_of(path).upper().removeprefix(".")
        raise SceneError(f"not a readable {name} file ({reason})") from error


# ---------------------------------------------------------------- text


def plain(content: bytes) -> bytes:
    """Return text without a byte order mark, as UTF-8 if the mark says that it is UTF-16."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16", errors="replace").encode()
    return content.removeprefix(b"\xef\xbb\xbf")


def lines(content: bytes, start: int = 0, first: int = 1) -> Iterator[tuple[int, bytes]]:
    """Yield the lines from the byte ``start`` on with their numbers; they end in LF, CR or both.

    Names and comments in them may be in any encoding.
    """
    for number, found in enumerate(LINE.finditer(content, start), first):
        yield number, found[1]


def bare(line: bytes) -> bytes:
    """Return a line without its comment, which starts with ``#``."""
    return COMMENT.split(line, maxsplit=1)[0] if b"#" in line else line


def unreadable(number: int, line: bytes, why: str = "") -> SceneError:
    """Return the error that names a line."""
    shown = line.decode(errors="replace").strip()[:60]
    return SceneError(f"line {number}: cannot read {shown!r}{why and f': {why}'}")


def decimal(word: bytes) -> float:
    """Return the number that a word says.

    Raises
    ------
    ValueError
        If it says none; Python alone would take ``1_0`` for 10.
    """
    if b"_" in word:
        raise ValueError
    try:
        return float(word)
    except ValueError:
        if NOT_A_NUMBER.fullmatch(word):
            return nan
        raise


def whole(word: bytes) -> int:
    """Return the whole number of at most 64 bits that a word says.

    Raises
    ------
    ValueError
        If it says none.
    """
    if b"_" in word or len(word) > 18:
        raise ValueError
    return int(word)
