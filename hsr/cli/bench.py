"""The command ``hsr bench``: speed against error, scaling, and runs compared."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hsr.base.errors import HsrError
from hsr.base.files import write_whole
from hsr.cli.console import new_table, out, print_json, progress, say
from hsr.cli.options import ALL, DIFFERS, Json, Methods, Quiet, RunByDefault, check_folder, parse_size

if TYPE_CHECKING:
    from hsr.lab.results import Results
    from hsr.lab.speed import Case

SCENES = ("teapot", "menger", "solids")
"""The built-in scenes that are measured if none is named: a mesh, a deep one, one with curved shapes."""


bench_app = typer.Typer(
    cls=RunByDefault,
    help="Measure how fast methods are, and how wrong. 'hsr bench SCENE...' means 'hsr bench run SCENE...'.",
)

Folder = Annotated[
    Path | None,
    typer.Option("--output", "-o", metavar="DIR", help="Write results, tables and charts into this folder."),
]
Quick = Annotated[bool, typer.Option("--quick", help="Small pictures and few turns.")]


# ---------------------------------------------------------------- run


@bench_app.command()
def run(
    scenes: Annotated[list[Path] | None, typer.Argument(help="Scenes or mesh files.")] = None,
    method: Methods = None,
    size: Annotated[
        list[str] | None, typer.Option("--size", help="Image size in pixels, N or WxH, repeatable; 512.")
    ] = None,
    cull: Annotated[
        list[str] | None,
        typer.Option("--cull", help="none or back, repeatable; as the scene says by default."),
    ] = None,
    repeat: Annotated[int | None, typer.Option("--repeat", min=3, help="Turns of every method; 15.")] = None,
    quick: Quick = False,
    output: Folder = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Judge and time methods on scenes or meshes: speed against error.

    Without scenes three built-in ones are measured; without -a the method each family is called after, and
    every peer; '-a all' adds all variants. Those that test each face at each sample sit out scenes that would
    keep them busy for long, unless they are named. A method that is missing or fails keeps a row that says
    why.
    """
    from hsr.lab.publish import HEAD, RIGHT, table
    from hsr.lab.results import case_title
    from hsr.lab.speed import PATIENCE

    sizes = [parse_size(text) for text in size or (["128"] if quick else ["512"])]
    cases = _cases(scenes or _built_in(), sizes, cull or ["scene"])
    turns = repeat or (5 if quick else 15)
    patience = PATIENCE if method in (None, [ALL]) else math.inf
    found = _measured(cases, method, turns, output, quiet, patience=patience)
    if as_json:
        print(found.to_json(), end="")
        return
    for rows in found.cases.values():
        _print_table(HEAD, table(rows), RIGHT, case_title(rows))
    _print_conditions(found, quiet)


def _built_in() -> list[Path]:
    from hsr.lab.machine import ROOT

    folder = ROOT / "scenes"
    if not folder.is_dir():
        raise HsrError("bench: no scenes are installed with the package; name scene or mesh files")
    return [folder / f"{name}.toml" for name in SCENES]


def _cases(paths: list[Path], sizes: list[tuple[int, int]], culls: list[str]) -> list[Case]:
    import hsr
    from hsr.lab.speed import make_case

    for way in culls:
        if way not in ("scene", "none", "back"):
            raise HsrError(f"--cull {way!r}: choose none or back")
    twice = {path.stem for k, path in enumerate(paths) if path.stem in {other.stem for other in paths[:k]}}
    if twice:
        raise HsrError(
            f"bench: more than one file is called {', '.join(sorted(twice))}; rows would be confused"
        )
    loaded = [(path.stem, hsr.load(path)) for path in paths]
    return [
        make_case(name, scene, size, way)  # type: ignore[arg-type]  # checked above
        for name, scene in loaded
        for size in sizes
        for way in culls
    ]


def _measured(
    cases: list[Case], methods: list[str] | None, repeat: int, output: Path | None, quiet: bool, **how: Any
) -> Results:
    """Measure, and publish what was found if a folder is named."""
    from hsr.algorithms import registry
    from hsr.lab.publish import make_folder, publish
    from hsr.lab.speed import measure

    if methods == [ALL]:
        methods = list(registry.methods())
    for name in methods or ():
        registry.method_named(name)
    if output is not None:
        make_folder(output)
    with progress(quiet, len(cases) * (repeat + 1)) as step:
        found = measure(cases, methods, repeat, progress=step, **how)
    if output is not None:
        for path in publish(found, output):
            if not quiet:
                _note(f"wrote {path}")
    return found


def _note(text: str) -> None:
    typer.echo(text, err=True)


def _print_table(
    head: tuple[str, ...], rows: list[tuple[str, ...]], right: tuple[str, ...], title: str
) -> None:
    from rich.markup import escape

    shown = new_table(*map(escape, head), title=escape(title), right=[escape(name) for name in right])
    for cells in rows:
        shown.add_row(*map(escape, cells), style=None if cells[0] else "dim")
    out.print(shown)
    out.print()


def _print_conditions(found: Results, quiet: bool) -> None:
    from hsr.lab.publish import conditions
    from hsr.lab.regression import NOTABLE_LOAD

    if quiet:
        return
    _note(conditions(found))
    loads = [row.foreign_load or 0.0 for row in found.rows]
    if max(loads) > NOTABLE_LOAD:
        _note("Other programs were busy: measure again on a quiet machine before you trust the times.")


# ---------------------------------------------------------------- scaling


@bench_app.command()
def scaling(
    method: Methods = None,
    repeat: Annotated[int, typer.Option("--repeat", min=3, help="Turns of every method.")] = 5,
    quick: Quick = False,
    output: Folder = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Measure how times grow with triangles, pixels, layers behind each other, and copies."""
    from hsr.lab.scaling import HEAD, growth, measured_cases, sentences, table
    from hsr.lab.speed import PATIENCE

    cases = measured_cases(quick)
    found = _measured(cases, method, repeat, output, quiet, explain=False, patience=PATIENCE)
    if as_json:
        print(found.to_json(), end="")
        return
    series = growth(found)
    _print_table(HEAD, table(series), HEAD[4:], "How times grow")
    for sentence in sentences(series):
        say(sentence)
    _print_conditions(found, quiet)


# ---------------------------------------------------------------- compare


@bench_app.command()
def compare(
    before: Annotated[Path, typer.Argument(metavar="A.json", help="Results of the earlier run.")],
    after: Annotated[Path, typer.Argument(metavar="B.json", help="Results of the later run.")],
    fail: Annotated[
        str | None,
        typer.Option(
            "--fail", metavar="median:N%", help="Exit 1 if a row is slower by more, beyond the noise."
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write the changes: .csv or .md, by the ending.")
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Compare two runs row by row, with the noise band of every ratio.

    More wrong samples always exit with 1, and so do rows without figures any more.
    """
    from dataclasses import asdict

    from hsr.lab import regression
    from hsr.lab.results import load_results

    limit = regression.LIMIT if fail is None else regression.limit_of(fail)
    if output is not None and output.suffix not in (".csv", ".md"):
        raise HsrError(f"{output}: changes are written as .csv or .md")
    check_folder(output)
    a, b = load_results(before), load_results(after)
    found, head = regression.changes(a, b, limit), regression.HEAD
    cells = [change.cells() for change in found]
    if output is not None:
        _write_changes(output, head, cells)
    if as_json:
        print_json({"hsr": 1, "limit": limit, "changes": [asdict(change) for change in found]})
    else:
        _print_table(head, cells, head[1:6], f"{after} against {before}")
    if not quiet:
        for warning in regression.warnings(a, b):
            _note(warning)
    failing = regression.FAILURES if fail is None else (*regression.FAILURES, regression.SLOWER)
    if any(change.verdict in failing for change in found):
        raise typer.Exit(DIFFERS)


def _write_changes(path: Path, head: tuple[str, ...], cells: list[tuple[str, ...]]) -> None:
    from hsr.lab.publish import as_csv, as_markdown

    text = as_csv(head, cells) if path.suffix == ".csv" else as_markdown(head, cells, head[1:6]) + "\n"
    write_whole(path, text, "the changes")
