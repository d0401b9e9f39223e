"""The command ``hsr``: its verbs, tied together, and how it ends.

Exit codes: 0 done or same, 1 differs, 2 usage or input, 3 what was asked for by name (OpenGL,
Embree) is missing, 70 a mistake of the program itself, 130 interrupted by Ctrl-C, 141 nobody reads
any more what is printed. Results go to standard output, everything else to standard error.
"""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence
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


def main(heard: Sequence[int] = ()) -> None:
    """Run the command; turn every error into one line and an exit code.

    Parameters
    ----------
    heard : sequence of int
        Signals that were heard: what is raised then is no mistake, and goes to the caller.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # names may have characters that the terminal has not
            stream.reconfigure(errors="backslashreplace")
    try:
        try:
            app()
        finally:
            sys.stdout.flush()
    except SystemExit as end:
        if not isinstance(end.__context__, BrokenPipeError):
            raise
        _print_no_more()
        sys.exit(cli.UNREAD)
    except BrokenPipeError:
        _print_no_more()
        sys.exit(cli.UNREAD)
    except HsrError as error:
        _fail(str(error), cli.MISSING if isinstance(error, UnavailableError) else cli.USAGE)
    except OSError as error:
        if error.filename is None:
            _print_no_more()
        _fail(f"{error.filename or 'standard output'}: {error.strerror or error}", cli.USAGE)
    except MemoryError as error:
        _fail(f"there is not enough memory for this: {error}", cli.USAGE)
    except Exception as error:
        if heard:
            raise
        place = traceback.extract_tb(error.__traceback__)[-1]
        what = f"{type(error).__name__}: {' '.join(str(error).split())} ({place.filename}:{place.lineno})"
        _fail(f"a mistake of the program, please report it: {what}; 'hsr --debug' tells more", cli.MISTAKE)


def _fail(text: str, code: int) -> None:
    if "--debug" in sys.argv:
        cli.say(traceback.format_exc(), to=cli.err)
    cli.say(*(f"hsr: {line}" for line in text.splitlines()), to=cli.err)
    sys.exit(code)


def _print_no_more() -> None:
    """Let go of what cannot be printed, lest Python tries again at the end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _version(wanted: bool) -> None:
    if wanted:
        cli.out.print(f"hsr {__version__}")
        raise Exit


Debug = Annotated[bool, Option("--debug", help="Also print where in the program an error arose.")]
Version = Annotated[bool, Option("--version", callback=_version, is_eager=True, help="Print the version.")]


@app.callback(invoke_without_command=True)
def _options(context: Context, version: Version = False, debug: Debug = False) -> None:  # noqa: ARG001
    if context.invoked_subcommand is None and sys.stdout.isatty():
        context.invoke(demo)
    elif context.invoked_subcommand is None:
        cli.out.print(context.get_help(), markup=False)
