"""The listing beside a recording: the source of the functions that ran, trimmed to what ran of it."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from itertools import groupby
from textwrap import dedent
from typing import Any

GAP = "…"
"""Stands for lines that have not run."""


def python_of(kernel: Callable[..., Any]) -> Callable[..., Any]:
    """Return the Python function of a kernel, compiled or not."""
    return getattr(kernel, "py_func", kernel)


@dataclass(frozen=True)
class Source:
    """A function as it is written, without decorators and docstring.

    Attributes
    ----------
    name : str
    lines : dict of int to str
        Its lines by their numbers in the file.
    statement : dict of int to int
        From the number of a line to that of the first line of its statement (of a compound one: of its head).
        Comments, blanks and ``else:`` go with what follows them.
    """

    name: str
    lines: dict[int, str]
    statement: dict[int, int]


def source_of(function: Callable[..., Any]) -> Source:
    """Read the source of a function or kernel."""
    text, first = inspect.getsourcelines(python_of(function))
    tree = ast.parse(dedent("".join(text))).body[0]
    assert isinstance(tree, ast.FunctionDef), "a listing is made of functions"
    ast.increment_lineno(tree, first - 1)
    statement: dict[int, int] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.stmt):
            statement |= dict.fromkeys(_lines(node), node.lineno)
    dropped = _lines(tree.body[0]) if ast.get_docstring(tree) else range(0)
    lines: dict[int, str] = {}
    for n, line in reversed(list(enumerate(dedent("".join(text)).splitlines(), first))):
        if n >= tree.lineno and n not in dropped:
            lines[n] = line
            if n not in statement or line.strip().startswith("#"):
                statement[n] = statement[n + 1]
    return Source(tree.name, dict(reversed(lines.items())), statement)


def _lines(node: ast.stmt) -> range:
    """Return the lines of a statement, or of the head of one with a body."""
    body: list[ast.stmt] = getattr(node, "body", [])
    end = max(body[0].lineno, node.lineno + 1) if body else (node.end_lineno or node.lineno) + 1
    return range(node.lineno, end)


def begins(line: str, text: str) -> bool:
    """Tell whether the statement in a line begins with a text."""
    return line.strip().startswith(text)


@dataclass(frozen=True)
class Listing:
    """Functions one after the other, trimmed to the statements that have run.

    Attributes
    ----------
    text : tuple of str
        The lines; :data:`GAP` stands for lines left out.
    place : dict
        From the name of a function and the first line of a statement in its file to the index of that line.
    """

    text: tuple[str, ...]
    place: dict[tuple[str, int], int]

    def lines(self, text: str, of: str = "") -> list[int]:
        """Return the lines, of one function or any, that begin with a text."""
        return [k for (name, _), k in self.place.items() if of in ("", name) and begins(self.text[k], text)]


def listing_of(sources: Sequence[Source], ran: Collection[tuple[str, int]]) -> Listing:
    """Put functions together.

    Parameters
    ----------
    sources : sequence of Source
        Those of which nothing has run are left out.
    ran : collection of (str, int)
        Function and first line of every statement that has run.
    """
    text: list[str] = []
    place: dict[tuple[str, int], int] = {}
    for source in sources:
        if not any(name == source.name for name, _ in ran):
            continue
        start = next(iter(source.lines))
        shown = {n: (source.name, at) in ran or at == start for n, at in source.statement.items()}
        text += [""] if text else []
        for kept, run in groupby(source.lines, key=shown.__getitem__):
            numbers = list(run)
            if kept:
                place |= {(source.name, n): len(text) + k for k, n in enumerate(numbers)}
            text += [source.lines[n] for n in numbers] if kept else [_gap(source.lines[numbers[0]])]
    return Listing(tuple(text), place)


def _gap(line: str) -> str:
    return line[: len(line) - len(line.lstrip())] + GAP
