"""What the commands have in common: options, exit codes, how input is checked, and what is printed.

Results go to standard output, everything else to standard error.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

from rich.console import Console, JustifyMethod
from rich.markup import escape
from rich.table import Table
from typer import Argument, BadParameter, Option
from typer.core import TyperGroup

import hsr
from hsr.base.errors import HsrError

MAPS = (".npz", ".png")
"""Endings of maps."""

ALL = "all"
"""In place of the name of a method: every one there is."""

DIFFERS, USAGE, MISSING, MISTAKE = 1, 2, 3, 70
"""Exit codes: something differs, usage or input, a method asked for by name is missing, a mistake of ours."""


def output(about: str, **more: Any) -> Any:
    """Return the option of where to write."""
    return Option("--output", "-o", help=about, **more)


Text = str | None
"""Of an option that may be left out."""

Texts = list[str] | None
"""Of one that may be repeated."""

Json = Annotated[bool, Option("--json", help="Print JSON instead of a table.")]
Quiet = Annotated[bool, Option("--quiet", "-q", help="No progress, no notes.")]
Verbose = Annotated[bool, Option("--verbose", "-v", help="Also print work counts and clusters.")]
Methods = Annotated[Texts, Option("--method", "-a", help="Method, repeatable; 'hsr algos' lists them.")]
Size = Annotated[str, Option(help="Image size in pixels, WxH or N.")]
CameraName = Annotated[Text, Option(help="Camera; the scene's first by default.")]
SceneFiles = Annotated[list[Path], Argument(help="Scenes or mesh files.")]
SceneFile = Annotated[Path, Argument(help="Scene or mesh file.")]
SceneOutput = Annotated[Path | None, output("Scene to write, .toml; standard output by default.")]
MapFile = Annotated[Path, Argument(help="Map, .npz, or a PNG whose colours are ids, from 1 on.")]
Against = Annotated[Path, Argument(help="What it should show: another map, or the scene, for the exact one.")]
Model = Annotated[Text, Option(help="What made the map: exact, opengl, float32, float64 or a method.")]
SubpixelBits = Annotated[int | None, Option(help="Of the model: bits of a pixel that corners keep.")]
DepthFormat = Annotated[Text, Option(help="Of the model: what its depth buffer holds.")]
FillRule = Annotated[Text, Option(help="Of the model: who owns samples on edges, top-left or bottom-left.")]
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
    check_sample(view, row, column)
    return column, row


def read_map(path: Path, view: hsr.View | None = None) -> hsr.VisibilityMap:
    """Read a map, or a picture of ids; those of a view are its triangles."""
    return hsr.testing.from_png(path, view) if path.suffix.lower() == ".png" else hsr.load_map(path)


def check_folder(output: Path | None) -> None:
    """Refuse a file that cannot be written before the work is done, not after.

    Raises
    ------
    HsrError
        If its folder is not there.
    """
    if output is not None and not output.parent.is_dir():
        raise HsrError(f"{output}: there is no folder {output.parent}; make it first")


# ---------------------------------------------------------------- what is printed

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
    for name in head:
        side: JustifyMethod = "right" if name in numbers else "left"
        table.add_column(escape(name), justify=side, no_wrap=name in head[:2])
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
        yield lambda name: bar.update(task, description=name, advance=1)
