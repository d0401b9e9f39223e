"""What the command prints: tables, JSON, a progress bar.

Results go to standard output, everything else to standard error.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

PIPED_WIDTH = 120
"""Columns of a table that goes to a file or pipe; a terminal has its own width."""

out = Console(highlight=False, width=None if sys.stdout.isatty() else PIPED_WIDTH)
err = Console(stderr=True, highlight=False)


def print_table(
    head: Sequence[str], rows: Iterable[Sequence[str]], right: Collection[str] | None = None, title: str = ""
) -> None:
    """Print a plain table; all columns but the first are numbers unless ``right`` names them."""
    table = Table(title=escape(title) or None, box=None, pad_edge=False, title_justify="left")
    numbers = head[1:] if right is None else right
    for column in head:
        table.add_column(
            escape(column), justify="right" if column in numbers else "left", no_wrap=column in head[:2]
        )
    for cells in rows:
        table.add_row(*map(escape, cells), style=None if cells[0] else "dim")
    out.print(table)


def say(*lines: str, to: Console = out) -> None:
    """Print lines as they are: never wrapped, nothing in them taken for markup."""
    for line in lines:
        to.print(line, markup=False, soft_wrap=True)


def print_json(value: Any) -> None:
    """Print JSON to standard output."""
    print(json.dumps(value, indent=2))


def tell(as_json: bool, value: Any, lines: Iterable[str]) -> None:
    """Print JSON, or else lines for people."""
    if as_json:
        print_json(value)
    else:
        say(*lines)


def milliseconds(seconds: dict[str, float]) -> str:
    """Return the time of the stage ``render``."""
    return f"{1e3 * seconds.get('render', 0.0):.1f} ms"


@contextmanager
def progress(quiet: bool, total: int) -> Iterator[Callable[[str], None]]:
    """Show a bar on standard error when it is a terminal; the yielded function starts a step."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("{task.description}"))
    with Progress(*columns, console=err, transient=True, disable=quiet or not err.is_terminal) as bar:
        task = bar.add_task("", total=total, completed=-1)

        def step(name: str) -> None:
            bar.update(task, description=name, advance=1)

        yield step
