"""What to watch of a method while it runs; one file a method, named by its row.

A file has a function ``probe(view, options)`` that returns the :class:`Probe` of one run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from hsr.base.arrays import Array, Ints
from hsr.base.errors import MethodError
from hsr.lessons.listing import begins, python_of, source_of
from hsr.problem.map import BACKGROUND

Function = Callable[..., Any]

Names = Mapping[str, Any]
"""The variables of a running function."""

Buffers = tuple[Ints, Array]
"""Faces and depths (H, W), as they are at the moment."""


class Look(NamedTuple):
    """Where a function keeps the buffers.

    Attributes
    ----------
    once : str
        The variable that must have been assigned before they can be read.
    read : callable, optional
        From the variables to a way to read the buffers; asked once a call.
    before : callable, optional
        What to do with the variables until then: memory may hold anything when it is handed out.
    """

    once: str
    read: Callable[[Names], Callable[[], Buffers]] | None = None
    before: Callable[[Names], None] | None = None


class Beat(NamedTuple):
    """When a method turns to a sample.

    Attributes
    ----------
    function : callable
    line : str
        The statement at which it does, as it begins in the source.
    sample : callable
        From the variables to row and column, None where it is no sample of the image.
    face : callable
        From the variables to the face that asks for the sample, -1 if none does yet.
    """

    function: Function
    line: str
    sample: Callable[[Names], tuple[int, int] | None]
    face: Callable[[Names], int]


class Probe(NamedTuple):
    """What to watch while a method runs.

    Attributes
    ----------
    shown : dict
        The functions of the listing in reading order, and of each the variables to show, or expressions, as
        in a debugger.
    buffers : dict
        The functions that have the buffers among their variables.
    beats : tuple of Beat
    counters : dict
        What is counted: the function and the statement whose runs are the count.
    rival : tuple, optional
        A function, and what reads from its arguments a face met at the sample, -1 for none.
    until : callable, optional
        The function at whose first return the recording ends.
    """

    shown: dict[Function, tuple[str, ...]]
    buffers: dict[Function, Look]
    beats: tuple[Beat, ...]
    counters: dict[str, tuple[Function, str]]
    rival: tuple[Function, Callable[[Names], int]] | None = None
    until: Function | None = None

    def check(self) -> None:
        """Make sure that all that is watched is there.

        Raises
        ------
        MethodError
            If a function has no such variable or statement: the probe is older than the method.
        """
        watched = [(function, text) for function, texts in self.shown.items() for text in texts]
        watched += [(function, look.once) for function, look in self.buffers.items()]
        for function, text in watched:
            code = python_of(function).__code__
            for name in compile(text, "<watched>", "eval").co_names:
                if name not in code.co_varnames + code.co_cellvars + code.co_freevars:
                    raise MethodError(f"{function.__name__} has no variable {name!r}, which a lesson watches")
        for function, line in [(beat.function, beat.line) for beat in self.beats] + [*self.counters.values()]:
            source = source_of(function)
            if not any(begins(source.lines.get(n, ""), line) for n in source.statement.values()):
                raise MethodError(f"no statement of {function.__name__} begins with {line!r}")


def nobody(_: Names) -> int:
    """Say that no face asks for the sample yet."""
    return BACKGROUND


def answered(names: Names) -> Callable[[], Buffers]:
    """Return what reads the buffers from the variables ``face`` and ``depth``."""
    face, depth = names["face"], names["depth"]
    return lambda: (face, depth)


def place(row: str, column: str) -> Callable[[Names], tuple[int, int]]:
    """Return what reads a sample from two variables."""
    return lambda names: (int(names[row]), int(names[column]))
