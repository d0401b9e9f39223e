"""What the command prints: tables, JSON, a progress bar.

Results go to standard output, everything else to standard error.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rich.console import Console, JustifyMethod
from rich.table import Table

if TYPE_CHECKING:
    from hsr.difference.study import Study

PIPED_WIDTH = 120
"""Columns of a table that goes to a file or pipe; a terminal has its own width."""

out = Console(highlight=False, width=None if sys.stdout.isatty() else PIPED_WIDTH)
err = Console(stderr=True, highlight=False)


def new_table(*columns: str, title: str | None = None, right: Sequence[str] | None = None) -> Table:
    """Return a plain table; all columns but the first are numbers unless ``right`` names them."""
    table = Table(title=title, box=None, pad_edge=False, title_justify="left")
    numbers = columns[1:] if right is None else right
    for column in columns:
        side: JustifyMethod = "right" if column in numbers else "left"
        table.add_column(column, justify=side, no_wrap=column in columns[:2])
    return table


def say(text: str) -> None:
    """Print a line as it is: never wrapped, nothing in it taken for markup."""
    out.print(text, markup=False, soft_wrap=True)


def milliseconds(seconds: dict[str, float]) -> str:
    """Return the time of the stage ``render``."""
    return f"{1e3 * seconds.get('render', 0.0):.1f} ms"


def print_json(value: Any) -> None:
    """Print JSON to standard output."""
    print(json.dumps(value, indent=2))


@contextmanager
def progress(quiet: bool, total: int) -> Iterator[Callable[[str], None]]:
    """Show a bar on standard error when it is a terminal; the yielded function starts a step."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("{task.description}"))
    with Progress(*columns, console=err, transient=True, disable=quiet or not err.is_terminal) as bar:
        task = bar.add_task("", total=total)
        started = False

        def step(name: str) -> None:
            nonlocal started
            bar.update(task, description=name, advance=int(started))
            started = True

        yield step


# ---------------------------------------------------------------- maps and studies


def print_renders(rows: Sequence[dict[str, Any]], verbose: bool) -> None:
    """Print one row a map, and what was written."""
    table = new_table("method", "covered", "faces seen", "nearest", "render")
    for row in rows:
        pixels = row["size"][0] * row["size"][1]
        nearest = "-" if row["nearest"] is None else f"{row['nearest']:.6g}"
        share = f"{row['covered'] / pixels:.1%}"
        table.add_row(row["method"], share, f"{row['faces_seen']:,}", nearest, milliseconds(row["seconds"]))
    out.print(table)
    for row in rows:
        if verbose:
            counts = ", ".join(f"{name} {count:,}" for name, count in row["work"].items())
            say(f"{row['method']}: {counts}")
        for file in row["files"]:
            say(f"wrote {file}")


def print_studies(studies: Sequence[Study], verbose: bool) -> None:
    """Print one table a scene; of several scenes only their sum, unless more is wanted."""
    if len(studies) == 1 or verbose:
        for found in studies:
            _print_study(found, verbose)
    if len(studies) > 1:
        _print_sum(studies)


def _print_study(found: Study, verbose: bool) -> None:
    from hsr.difference.classes import DIFFERENT

    title = f"{found.name}, {found.view.width}x{found.view.height}, against {found.reference or 'nothing'}"
    table = new_table("method", "differ", *DIFFERENT, "largest cluster", "render", title=title)
    for name in found.methods:
        if name in found.skipped:
            table.add_row(name, _absence(found, name))
            continue
        render_time = milliseconds(found.maps[name].seconds)
        if name not in found.differences:
            role = "reference" if name == found.reference else "-"
            table.add_row(name, role, *[""] * (len(DIFFERENT) + 1), render_time)
            continue
        difference = found.differences[name]
        counts = (f"{difference.counts[kind]:,}" for kind in DIFFERENT)
        table.add_row(name, f"{difference.different:,}", *counts, f"{difference.largest:,}", render_time)
    out.print(table)
    for name, why in found.causes.items():
        if why.wrong:
            say(f"{name}: {_counted(why.counts)}")
    for name, reason in found.skipped.items():
        say(f"{name}: {reason}")
    if verbose:
        for difference in found.differences.values():
            say(difference.summary())
    out.print()


def _absence(found: Study, name: str) -> str:
    return "not available" if name in found.missing else "skipped"


def _print_sum(studies: Sequence[Study]) -> None:
    """Print one row a method over all scenes."""
    references = ", ".join(dict.fromkeys(found.reference or "nothing" for found in studies))
    title = f"{len(studies)} scenes, samples that show another face than {references}"
    table = new_table(
        "method", "scenes", "differ", "share", "most of them in", "causes", "render", title=title
    )
    for name in dict.fromkeys(name for found in studies for name in found.methods):
        table.add_row(name, *_sum_cells([found for found in studies if name in found.methods], name))
    out.print(table)
    if any(found.reference in found.tessellating for found in studies):
        out.print("Methods that keep curved shapes exact rightly differ along the outlines of polygons.")


def _sum_cells(studies: Sequence[Study], name: str) -> tuple[str, ...]:
    ran = [found for found in studies if name in found.maps]
    if not ran:
        return ("0", _absence(studies[0], name))
    total = 1e3 * sum(found.maps[name].seconds["render"] for found in ran)
    judged = [found for found in ran if name in found.differences]
    if not judged:
        return (str(len(ran)), "reference", "", "", "", f"{total:,.0f} ms")
    differ = sum(found.differences[name].different for found in judged)
    samples = sum(found.view.width * found.view.height for found in judged)
    worst = max(judged, key=lambda found: found.differences[name].different)
    most = f"{worst.name} {worst.differences[name].different:,}" if differ else ""
    causes = sum((Counter(found.causes[name].counts) for found in judged if name in found.causes), Counter())
    why = _counted(causes)
    return (str(len(ran)), f"{differ:,}", f"{differ / samples:.3%}", most, why, f"{total:,.0f} ms")


def _counted(counts: Mapping[str, int]) -> str:
    """Write counts, the greatest first: ``vertex snapping 192, tessellation 30``."""
    ordered = sorted(counts.items(), key=lambda item: -item[1])
    return ", ".join(f"{name} {count:,}" for name, count in ordered)
