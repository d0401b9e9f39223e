"""The errors the package raises: each says what is wrong, where, and what to do."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar

Known = TypeVar("Known")


class HsrError(Exception):
    """Base class of every error this package raises on purpose."""


class SceneError(HsrError):
    """A scene that cannot be used.

    Attributes
    ----------
    problems : tuple of str
        One line a problem, each with its file, the path of its key and what was expected.
    """

    def __init__(self, problems: str | Sequence[str]) -> None:
        self.problems = (problems,) if isinstance(problems, str) else tuple(problems)
        super().__init__("\n".join(self.problems))


class ViewError(HsrError):
    """A view that cannot be made: no such camera, or an image size out of range."""


class MethodError(HsrError):
    """An unknown method or option, or a method that cannot handle this view."""


class MapError(HsrError):
    """A visibility map that cannot be read, or two maps that cannot be compared."""


class UnavailableError(HsrError):
    """A method needs something this machine lacks, such as OpenGL or Embree."""


class NoOpenGLError(UnavailableError):
    """OpenGL is missing, or does not draw what it should."""


class CheckError(HsrError):
    """A check of a test that cannot be made: a tolerance that makes no sense, an unreadable baseline."""


class VisibilityError(HsrError, AssertionError):
    """Maps differ by more than a test allows; the message says by what, where and why."""


def told_briefly(error: Exception) -> str:
    """Say in one line what an error says; of pydantic's errors the first, and where."""
    text, told = str(error), getattr(error, "errors", None)
    if callable(told):
        first = told()[0]
        said = first["msg"].removeprefix("Value error, ")
        text = ": ".join(filter(None, (".".join(map(str, first["loc"])), said)))
    return " ".join(text.split()) or type(error).__name__


def nearest(word: object, known: Iterable[str]) -> str:
    """Return ``did you mean ...? `` if a known word is near, else nothing."""
    near = difflib.get_close_matches(word, known, n=1) if isinstance(word, str) else []
    return f"did you mean {near[0]!r}? " if near else ""


def named(
    name: str,
    known: Mapping[str, Known],
    none: str,
    error: type[HsrError] = HsrError,
    others: str = "there are",
) -> Known:
    """Return what is known by a name.

    Parameters
    ----------
    name : str
    known : mapping
    none : str
        What to say if nothing is: ``"no method is named"``.
    error : type of HsrError
        What to raise then, with the name that is near or else all names.
    others : str
        What to say before those.

    Raises
    ------
    HsrError
        Of the type ``error``.
    """
    if name not in known:
        raise error(f"{none} {name!r}; {nearest(name, known) or others + ' ' + ', '.join(known)}".rstrip())
    return known[name]
