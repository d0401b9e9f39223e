"""The command ``hsr``: its verbs, tied together, and how it ends.

Exit codes: 0 done or same, 1 differs, 2 usage or input, 3 what was asked for by name (OpenGL,
Embree) is missing, 70 a mistake of the program itself. Results go to standard output, everything else to
standard error.
"""

from __future__ import annotations

import sys
import traceback
from io import TextIOWrapper
from typing import Annotated

from typer import Context, Exit, Option, Typer

from hsr import __version__
from hsr.base.errors import HsrError, UnavailableError
from hsr.cli import common as cli
from hsr.cli.accept import accept, report
from hsr.cli.bench import bench_app
from hsr.cli.compare import compare
from hsr.cli.demo import demo
from hsr.cli.diff import diagnose, diff
from hsr.cli.doctor import doctor
from hsr.cli.explain import explain
from hsr.cli.gallery import gallery
from hsr.cli.lesson import lesson
from hsr.cli.lists import algos, scenes, schema
from hsr.cli.render import render
from hsr.cli.scene import scene_app
from hsr.cli.shrink import shrink
from hsr.cli.stability import stability_app

app = Typer(
    help="Which surface does the eye see at each pixel? Every classic method, compared sample by sample.",
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
)
judged = (compare, diff, diagnose, explain, shrink)
for verb in (demo, render, *judged, accept, report, lesson, gallery, scenes, algos, schema, doctor):
    # The sample -1,3 is outside the image, and no unknown option.
    app.command(context_settings={"ignore_unknown_options": verb in (explain, shrink)})(verb)
for name, verbs in (("scene", scene_app), ("bench", bench_app), ("stability", stability_app)):
    app.add_typer(verbs, name=name)


def main() -> None:
    """Run the command; turn every error into one line and an exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # names may have characters that the terminal has not
            stream.reconfigure(errors="backslashreplace")
    try:
        app()
    except HsrError as error:
        _fail(str(error), cli.MISSING if isinstance(error, UnavailableError) else cli.USAGE)
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        what = f"{type(error).__name__}: {error} ({place.filename}:{place.lineno})"
        _fail(f"a mistake of the program, please report it: {what}", cli.MISTAKE)


def _fail(text: str, code: int) -> None:
    cli.say(*(f"hsr: {line}" for line in text.splitlines()), to=cli.err)
    sys.exit(code)


def _version(wanted: bool) -> None:
    if wanted:
        cli.out.print(f"hsr {__version__}")
        raise Exit


Version = Annotated[bool, Option("--version", callback=_version, is_eager=True, help="Print the version.")]


@app.callback(invoke_without_command=True)
def _options(context: Context, version: Version = False) -> None:  # noqa: ARG001
    if context.invoked_subcommand is None and sys.stdout.isatty():
        context.invoke(demo)
    elif context.invoked_subcommand is None:
        cli.out.print(context.get_help(), markup=False)
