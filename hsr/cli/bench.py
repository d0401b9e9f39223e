"""The command ``hsr bench``: speed against error, scaling, and runs compared."""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Argument, Exit, Option, Typer

import hsr
from hsr.base.errors import HsrError
from hsr.base.files import write_whole
from hsr.cli import common as cli
from hsr.cli.cameras import Cameras, with_cameras

if TYPE_CHECKING:
    from hsr.lab.speed import Case

SCENES = ("teapot", "menger", "solids")
"""The built-in scenes that are measured if none is named: a mesh, a deep one, one with curved shapes."""

LEAST = ("dominated by", "read [ms]", "prepare [ms]", "build [ms]", "rank", "law", "off by up to", "grows as")
"""Columns that give way where there is no room, in that order."""

BUSY = "Other programs were busy: measure again on a quiet machine before you trust the times."

bench_app = Typer(
    cls=cli.RunByDefault,
    help="Measure how fast methods are, and how wrong. 'hsr bench SCENE...' means 'hsr bench run SCENE...'.",
)

Folder = Annotated[Path | None, cli.output("Folder for results, tables and charts.", metavar="DIR")]
Quick = Annotated[bool, Option("--quick", help="Small pictures and few turns.")]


# ---------------------------------------------------------------- what is measured


@bench_app.command()
@with_cameras
def run(
    scenes: Annotated[list[Path] | None, cli.SCENES] = None,
    method: cli.Methods = None,
    size: Annotated[cli.Texts, Option(help="Image size in pixels, N or WxH, repeatable; 512.")] = None,
    cull: Annotated[cli.Texts, Option(help="none or back, repeatable; as the scene says by default.")] = None,
    repeat: Annotated[int | None, Option(min=3, help="Turns of every method; 15.")] = None,
    quick: Quick = False,
    output: Folder = None,
    as_json: cli.Json = False,
    quiet: cli.Quiet = False,
    *,
    cameras: Cameras,
) -> None:
    """Judge and time methods on scenes or meshes: speed against error.

    Without scenes three built-in ones are measured; without -a the method each family is called after, and
    every peer; '-a all' adds all variants. Those that test each face at each sample sit out scenes that would
    keep them busy for long, unless they are named. A method that is missing or fails keeps a row that says
    why.

    For example:

        hsr bench teapot bunny.obj --size 1024 -o out
        hsr bench solids -a zbuffer -a opengl --quick
    """
    from hsr.lab.speed import PATIENCE

    sizes = [cli.parse_size(text) for text in size or (["128"] if quick else ["512"])]
    cases = _cases(scenes or list(map(Path, SCENES)), cameras, sizes, cull or ["scene"])
    patience = math.inf if cli.named(method) else PATIENCE
    _measure(cases, method, repeat or (5 if quick else 15), output, as_json, quiet, patience=patience)


@bench_app.command()
def scaling(
    method: cli.Methods = None,
    repeat: Annotated[int, Option(min=3, help="Turns of every method.")] = 5,
    quick: Quick = False,
    output: Folder = None,
    as_json: cli.Json = False,
    quiet: cli.Quiet = False,
) -> None:
    """Measure how times grow with triangles, pixels, layers behind each other, and copies.

    For example:

        hsr bench scaling --quick
    """
    from hsr.lab.scaling import measured_cases
    from hsr.lab.speed import PATIENCE

    _measure(measured_cases(quick), method, repeat, output, as_json, quiet, patience=PATIENCE, explain=False)


def _cases(paths: list[Path], cameras: Cameras, sizes: list[tuple[int, int]], culls: list[str]) -> list[Case]:
    from hsr.lab.speed import make_case

    for way in culls:
        if way not in ("scene", "none", "back"):
            raise HsrError(f"--cull {way!r}: choose none or back")
    stems = [path.stem for path in paths]
    twice = ", ".join(sorted({stem for stem in stems if stems.count(stem) > 1}))
    if twice:
        raise HsrError(f"bench: more than one file is called {twice}; rows would be confused")
    loaded = [pair for path in paths for pair in cameras.scenes(path.stem, hsr.load(path))]
    return [make_case(*named, size, way) for named, size, way in product(loaded, sizes, culls)]


def _measure(
    cases: list[Case], method: cli.Texts, turns: int, output: Path | None, json: bool, quiet: bool, **how: Any
) -> None:
    """Measure, publish what was found if a folder is named, and print it."""
    from hsr.algorithms.registry import method_named
    from hsr.lab.publish import conditions, make_folder, publish, tables
    from hsr.lab.regression import NOTABLE_LOAD
    from hsr.lab.scaling import growth, sentences
    from hsr.lab.speed import measure

    names = cli.names(method)
    for name in names:
        method_named(name)
    if output is not None:
        make_folder(output)
    with cli.progress(quiet, len(cases) * (turns + 1)) as step:
        found = measure(cases, names, turns, progress=step, **how)
    notes = [] if output is None else [f"wrote {path}" for path in publish(found, output)]
    if json:
        print(found.to_json(), end="")
    else:
        for table in tables(found):
            cli.print_table(*table, below=["why"], least=LEAST)
            cli.out.print()
        cli.say(*sentences(growth(found)))
        notes.append(conditions(found))
        if (found.foreign_load or 0.0) > NOTABLE_LOAD:
            notes.append(BUSY)
    if not quiet:
        cli.say(*notes, to=cli.err)


# ---------------------------------------------------------------- compare


@bench_app.command()
def compare(
    before: Annotated[Path, Argument(metavar="A.json", help="Results of the earlier run.")],
    after: Annotated[Path, Argument(metavar="B.json", help="Results of the later run.")],
    fail: Annotated[
        cli.Text, Option(metavar="median:N%", help="Exit 1 if a row is slower by more, beyond the noise.")
    ] = None,
    output: Annotated[Path | None, cli.output("Write the changes, .csv or .md.", ".csv", ".md")] = None,
    as_json: cli.Json = False,
    quiet: cli.Quiet = False,
) -> None:
    """Compare two runs row by row, with the noise band of every ratio.

    More wrong samples always exit with 1, and so do rows without figures any more.

    For example:

        hsr bench compare a.json b.json --fail median:10%
    """
    from dataclasses import asdict

    from hsr.lab import regression
    from hsr.lab.results import load_results

    limit = regression.LIMIT if fail is None else regression.limit_of(fail)
    a, b = load_results(before), load_results(after)
    found = regression.changes(a, b, limit)
    table = regression.table(found, f"{after} against {before}")
    if output is not None:
        text = table.csv() if output.suffix == ".csv" else table.markdown() + "\n"
        write_whole(output, text, "the changes")
    if as_json:
        cli.print_json("bench-compare", {"limit": limit, "changes": [asdict(one) for one in found]})
    else:
        cli.print_table(*table, least=("noise band", "before [ms]", "after [ms]"))
        cli.out.print()
    if not quiet:
        cli.say(*regression.warnings(a, b), to=cli.err)
    failing = regression.FAILURES if fail is None else (*regression.FAILURES, regression.SLOWER)
    if any(change.verdict in failing for change in found):
        raise Exit(cli.DIFFERS)
