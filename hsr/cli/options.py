"""What the commands have in common: options, exit codes, and how sizes, samples and files are checked."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from typer import Argument, BadParameter, Option
from typer.core import TyperGroup

import hsr
from hsr.base.errors import HsrError

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
Sample = Annotated[str, Argument(metavar="X,Y", help="Column and row, counted from 0 at the top left.")]


class RunByDefault(TyperGroup):
    """A group whose command ``run`` need not be named: ``hsr bench X`` is ``hsr bench run X``."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Put ``run`` before arguments that begin with no command."""
        named = args and (args[0] in self.commands or args[0] in ctx.help_option_names)
        parsed: list[str] = super().parse_args(ctx, args if named else ["run", *args])
        return parsed


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


def check_folder(output: Path | None) -> None:
    """Refuse a file that cannot be written before the work is done, not after.

    Raises
    ------
    HsrError
        If its folder is not there.
    """
    if output is not None and not output.parent.is_dir():
        raise HsrError(f"{output}: there is no folder {output.parent}; make it first")
