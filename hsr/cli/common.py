"""What the commands have in common: options, exit codes, how input is checked, and what is printed.

Results go to standard output, everything else to standard error.
"""

from __future__ import annotations

import inspect
import json
import os
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial, wraps
from pathlib import Path
from typing import Annotated, Any

from rich.cells import cell_len
from rich.console import Console, JustifyMethod
from rich.markup import escape
from rich.table import Table
from typer import Argument, BadParameter, Option
from typer.core import TyperGroup

import hsr
from hsr.base.errors import HsrError

MAPS = (".npz", ".png", ".exr", ".npy", ".raw")
"""Endings of maps."""

WRITTEN = (".npz", ".png", ".html", ".json", ".csv", ".md", ".svg", ".toml")
"""Endings of all that verbs write: who names a folder so means a file."""

ALL = "all"
"""In place of the name of a method: every one there is."""

FORMAT = 1
"""Of the JSON that verbs print: a number for each way of writing it, from 1."""

DIFFERS, USAGE, MISSING, MISTAKE, UNREAD = 1, 2, 3, 70, 141
"""Exit codes: something differs, usage or input, a method asked for by name is missing, a mistake of ours,
nobody reads standard output any more."""


def output(about: str, *endings: str, name: str = "--output", **more: Any) -> Any:
    """Return the option of where to write: a folder, or a file with one of these endings."""

    def check(value: Path | None) -> Path | None:
        if value is not None:
            check_output(value, *endings)
        return value

    names = (name, "-o") if name == "--output" else (name,)
    return Option(*names, help=about, callback=check, **more)


def method_completion(incomplete: str) -> list[str]:
    """Return the methods whose names begin so, for the shell."""
    return [name for name in hsr.methods() if name.startswith(incomplete)]


def scene_completion(incomplete: str) -> list[str]:
    """Return the built-in scenes whose names begin so; where there is none the shell completes files."""
    from hsr.scene.files import built_in

    return [name for name in built_in() if name.startswith(incomplete)]


Verb = Callable[..., None]

Text = str | None
"""Of an option that may be left out."""

Texts = list[str] | None
"""Of one that may be repeated."""

Json = Annotated[bool, Option("--json", help="Print JSON instead of a table.")]
Quiet = Annotated[bool, Option("--quiet", "-q", help="No progress, no notes.")]
Verbose = Annotated[bool, Option("--verbose", "-v", help="Also print work counts and clusters.")]
METHOD = Option("--method", "-a", help="Repeatable; see 'hsr algos'.", autocompletion=method_completion)
Methods = Annotated[Texts, METHOD]
Size = Annotated[str, Option(help="Image size in pixels, WxH or N.")]
MapSize = Annotated[Text, Option(help="Image size in pixels, WxH or N; that of the maps, or else 512.")]
NamedMaps = Annotated[
    Texts, Option("--map", metavar="[NAME=]FILE", help="Map, as for 'hsr diff'; repeatable.")
]
SCENES = Argument(help="Scenes or mesh files.", autocompletion=scene_completion)
SceneFiles = Annotated[list[Path], SCENES]
SceneFile = Annotated[Path, Argument(help="Scene or mesh file.", autocompletion=scene_completion)]
SceneOutput = Annotated[Path | None, output("Scene to write, .toml; standard output by default.", ".toml")]
ExportFolder = Annotated[Path, output("Folder to write; nothing may be in it yet.")]
MapFile = Annotated[Path, Argument(help="Map, .npz, or an image of ids: .png, .exr, .npy, .npz, .raw.")]
Against = Annotated[Path, Argument(help="What it should show: another map, or the scene, for the exact one.")]
Sample = Annotated[str, Argument(metavar="X,Y", help="Column and row, counted from 0 at the top left.")]


class RunByDefault(TyperGroup):
    """A group whose command ``run`` need not be named: ``hsr bench X`` is ``hsr bench run X``."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put ``run`` before arguments that begin with no command."""
        named = args and (args[0] in self.commands or args[0] in ctx.help_option_names)
        return list(super().parse_args(ctx, args if named else ["run", *args]))


def named(method: Texts) -> list[str]:
    """Return the methods asked for by their names: none of them by '-a all', and none without -a."""
    return [] if method in (None, [ALL]) else list(method or ())


def names(method: Texts) -> list[str]:
    """Return the methods that take part."""
    from hsr.algorithms.registry import default_methods

    return list(hsr.methods()) if method == [ALL] else method or default_methods()


def with_options(
    name: str, options: Mapping[str, Any], made: Callable[[dict[str, Any]], Any]
) -> Callable[[Verb], Verb]:
    """Return a decorator that gives a verb options in place of its argument ``name``, made of those given."""

    def decorated(verb: Verb) -> Verb:
        signature = inspect.signature(verb, eval_str=True)
        added = partial(inspect.Parameter, kind=inspect.Parameter.KEYWORD_ONLY, default=None)
        own = [one for key, one in signature.parameters.items() if key != name]
        whole = [*own, *(added(key, annotation=hint) for key, hint in options.items())]

        @wraps(verb)
        def command(**given: Any) -> None:
            keys = {key: value for key in options if (value := given.pop(key, None)) is not None}
            verb(**given, **{name: made(keys)})

        vars(command)["__signature__"] = signature.replace(parameters=whole)
        command.__annotations__ = {one.name: one.annotation for one in whole}
        return command

    return decorated


def parse_size(text: str) -> tuple[int, int]:
    """Read an image size, WxH or N.

    Raises
    ------
    typer.BadParameter
        If it is written in another way.
    """
    width, _, height = text.lower().partition("x")
    try:
        return int(width), int(height or width)
    except ValueError:
        raise BadParameter(f"--size {text!r}: write WIDTHxHEIGHT, such as 640x480") from None


def parse_sample(text: str, view: hsr.View) -> tuple[int, int]:
    """Read X,Y: column and row of a sample of a view.

    Raises
    ------
    HsrError
        If it is written in another way, or lies outside the image.
    """
    from hsr.difference.nearby import check_sample

    x, _, y = text.partition(",")
    try:
        column, row = int(x), int(y)
    except ValueError:
        raise HsrError(f"sample {text!r}: write COLUMN,ROW, such as 311,204") from None
    check_sample(view, column, row)
    return column, row


def check_output(path: Path, *endings: str) -> None:
    """Refuse a file, or without endings a folder, that cannot be written: before the work is done, not after.

    Raises
    ------
    HsrError
        If a file has another ending than what is written, or its folder is not there; or if a folder is
        called as files are.
    """
    if not endings:
        if path.suffix.lower() in WRITTEN and not path.is_dir():
            raise HsrError(f"{path}: what is written is a folder; say {path.with_suffix('')}")
        return
    if path.suffix.lower() not in endings:
        kinds, said = " or ".join(endings), path.with_suffix(endings[0])
        raise HsrError(f"{path}: what is written ends in {kinds}; say {said}")
    if not path.parent.is_dir():
        raise HsrError(f"{path}: there is no folder {path.parent}; make it first")


# ---------------------------------------------------------------- what is printed

PIPED_WIDTH = 120
"""Columns of a table that goes to a file or pipe; a terminal has its own width, and COLUMNS sets any."""

READABLE = 28
"""Columns that a text needs at least, lest it be a word a line."""

out = Console(highlight=False, width=None if sys.stdout.isatty() or "COLUMNS" in os.environ else PIPED_WIDTH)
err = Console(stderr=True, highlight=False)


def print_table(
    head: Sequence[str],
    rows: Iterable[Sequence[str]],
    right: Collection[str] | None = None,
    title: str = "",
    below: Collection[str] = (),
    least: Collection[str] = (),
) -> None:
    """Print a plain table of which no cell is cut, however narrow the terminal.

    All columns but the first are numbers unless ``right`` names them; only texts are wrapped. Where it is too
    wide, the texts of ``below`` go below it, a line a row; then the columns of ``least`` are left out, one by
    one; and what still does not fit is a table of its own.
    """
    lines = [[*cells, *[""] * (len(head) - len(cells))] for cells in rows]
    column = {name: [cells[k] for cells in lines] for k, name in enumerate(head)}
    numbers = head[1:] if right is None else right
    label = next(name for name in head if name not in numbers)
    most = {name: None if name in (*numbers, label) else READABLE for name in head}
    widths = {name: max(map(cell_len, (name, *texts))) for name, texts in column.items()}

    def fit(names: Sequence[str]) -> bool:
        return sum(min(widths[name], most[name] or widths[name]) + 2 for name in names) - 2 <= out.width

    kept = list(head)
    for name in (*below, *least):
        if name in kept and not fit(kept):
            kept.remove(name)
    parts: list[list[str]] = [[]]
    for name in kept:
        if len(parts[-1]) > 1 and not fit([*parts[-1], name]):
            parts.append([label])
        parts[-1].append(name)
    out.print(escape(title), style="italic", end="\n" if title else "")
    for names in parts:
        table = Table(box=None, pad_edge=False)
        for name in names:
            side: JustifyMethod = "right" if name in numbers else "left"
            table.add_column(escape(name), justify=side, no_wrap=most[name] is None, overflow="fold")
        for k, cells in enumerate(lines):
            table.add_row(*(escape(column[name][k]) for name in names), style=None if cells[0] else "dim")
        out.print(table)
    for name in (name for name in head if name in below and name not in kept):
        told = zip(column[label], column[name], strict=True)
        say(*(f"{one.strip()}: {text}" for one, text in told if text), to=out)
    if left_out := [name for name in head if name not in (*kept, *below)]:
        out.print(escape(f"Not shown for want of room: {', '.join(left_out)}."), style="dim")


def say(*lines: str, to: Console = out) -> None:
    """Print lines as they are: never wrapped, nothing in them taken for markup."""
    for line in lines:
        to.print(line, markup=False, soft_wrap=True)


def print_json(kind: str, value: Mapping[str, Any]) -> None:
    """Print JSON to standard output; ``hsr schema KIND`` says what it is made of."""
    print(json.dumps({"format": FORMAT, "kind": kind, **value}, indent=2))


def print_list(
    as_json: bool, kind: str, rows: Sequence[Mapping[str, Any]], least: Sequence[str] = ()
) -> None:
    """Print things of one kind as JSON, or else a line each."""
    if as_json:
        return print_json(kind, {kind: rows})
    words = {False: "no", True: "yes"}
    told = [[words[value] if isinstance(value, bool) else value for value in row.values()] for row in rows]
    return print_table(list(rows[0]), told, right=(), least=least)


def tell(as_json: bool, kind: str, value: Mapping[str, Any], lines: Iterable[str]) -> None:
    """Print JSON, or else lines for people."""
    if as_json:
        print_json(kind, value)
    else:
        say(*lines)


def milliseconds(seconds: dict[str, float]) -> str:
    """Return the time of the stage ``render``; nothing if another program rendered."""
    return f"{1e3 * seconds['render']:.1f} ms" if "render" in seconds else ""


@contextmanager
def progress(quiet: bool, total: int) -> Iterator[Callable[[str], None]]:
    """Show a bar and the time left, if standard error is a terminal; the yielded function starts a step."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    what, left = TextColumn("{task.description}"), (TextColumn("left"), TimeRemainingColumn())
    columns = (BarColumn(20), MofNCompleteColumn(), *left, what)
    with Progress(*columns, console=err, transient=True, disable=quiet or not err.is_terminal) as bar:
        task = bar.add_task("", total=total, completed=-1)
        yield lambda name: bar.update(task, description=name, advance=1)
