"""The command ``hsr compare``: scenes by many methods, each map beside the reference."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import hsr
from hsr.base.errors import HsrError, UnavailableError
from hsr.cli import options as opt
from hsr.cli.console import milliseconds, new_table, out, print_json, progress, say

if TYPE_CHECKING:
    from hsr.difference.study import Study


def compare(
    scenes: Annotated[list[Path], typer.Argument(help="Scenes or mesh files.")],
    method: opt.Methods = None,
    ref: Annotated[str, typer.Option("--ref", help="Reference method.")] = "exact",
    size: opt.Size = "512x512",
    camera: opt.CameraName = None,
    output: Annotated[Path | None, opt.output("Write the report, .html.")] = None,
    fail_on: Annotated[
        str | None, typer.Option("--fail-on", help="Classes of difference, comma separated: then exit 1.")
    ] = None,
    as_json: opt.Json = False,
    quiet: opt.Quiet = False,
    verbose: opt.Verbose = False,
) -> None:
    """Render scenes by many methods and compare every visibility map with the reference.

    Without -a the method each family is called after takes part, and every peer; '-a all' adds all
    variants. Those that test each face at each sample sit out scenes that would keep them busy for minutes,
    unless they are named.
    """
    from hsr.algorithms.registry import default_methods
    from hsr.difference.study import study

    opt.check_folder(output)
    forbidden = _classes(fail_on)
    loaded = [(path, hsr.load(path)) for path in scenes]
    asked = [] if method in (None, [opt.ALL]) else list(method or ())
    names = list(hsr.methods()) if method == [opt.ALL] else asked or default_methods()
    studies = []
    with progress(quiet, len(loaded) * (len({*names, ref}) + (output is not None))) as step:
        for path, scene in loaded:
            how = partial(study, name=path.stem, patient=bool(asked), progress=step)
            studies.append(how(scene, names, ref, opt.parse_size(size), camera))
        _require(studies, {*asked, ref})
        if output is not None:
            from hsr.pages.report import write_report

            write_report(studies, output, progress=step)
    if as_json:
        print_json({"hsr": 1, "studies": [found.to_json() for found in studies]})
    else:
        _print(studies, verbose)
        if output is not None:
            say(f"report: {output}")
    if forbidden:
        _require_judged(studies, {*asked, ref})
    differences = [difference for found in studies for difference in found.differences.values()]
    if any(difference.counts[name] for difference in differences for name in forbidden):
        raise typer.Exit(opt.DIFFERS)


def _classes(text: str | None) -> list[str]:
    from hsr.difference.classes import DIFFERENT

    names = [name.strip() for name in (text or "").split(",") if name.strip()]
    for name in names:
        if name not in DIFFERENT:
            raise typer.BadParameter(f"--fail-on: no class {name!r}; there are {', '.join(DIFFERENT)}")
    return names


def _require(studies: Sequence[Study], asked: set[str]) -> None:
    """Raise if a method asked for by name is missing here: that is no mere skipped column."""
    for found in studies:
        for name in asked & found.missing:
            raise UnavailableError(found.skipped[name])


def _require_judged(studies: Sequence[Study], asked: set[str]) -> None:
    """Raise if a method asked for by name was skipped: what was not compared must not pass."""
    for found in studies:
        for name in sorted(asked & found.skipped.keys()):
            raise HsrError(f"--fail-on: {found.name}: {name} did not run: {found.skipped[name]}")


# ---------------------------------------------------------------- tables


def _print(studies: Sequence[Study], verbose: bool) -> None:
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
        if name in found.differences:
            difference = found.differences[name]
            counts = (difference.different, *map(difference.counts.get, DIFFERENT), difference.largest)
            cells = [f"{count:,}" for count in counts]
        else:
            cells = ["reference" if name == found.reference else "-", *[""] * (len(DIFFERENT) + 1)]
        table.add_row(name, *cells, milliseconds(found.maps[name].seconds))
    out.print(table)
    say(*(f"{name}: {_counted(why.counts)}" for name, why in found.causes.items() if why.wrong))
    say(*(f"{name}: {reason}" for name, reason in found.skipped.items()))
    if verbose:
        say(*(difference.summary() for difference in found.differences.values()))
    out.print()


def _absence(found: Study, name: str) -> str:
    return "not available" if name in found.missing else "skipped"


def _print_sum(studies: Sequence[Study]) -> None:
    """Print one row a method over all scenes."""
    references = ", ".join(dict.fromkeys(found.reference or "nothing" for found in studies))
    title = f"{len(studies)} scenes, samples that show another face than {references}"
    head = ("method", "scenes", "differ", "share", "most of them in", "causes", "render")
    table = new_table(*head, title=title)
    for name in dict.fromkeys(name for found in studies for name in found.methods):
        table.add_row(name, *_sum_cells([found for found in studies if name in found.methods], name))
    out.print(table)
    if any(found.reference in found.tessellating for found in studies):
        out.print("Methods that keep curved shapes exact rightly differ along the outlines of polygons.")


def _sum_cells(studies: Sequence[Study], name: str) -> tuple[str, ...]:
    ran = [found for found in studies if name in found.maps]
    if not ran:
        return ("0", _absence(studies[0], name))
    total = f"{1e3 * sum(found.maps[name].seconds.get('render', 0.0) for found in ran):,.0f} ms"
    judged = [found for found in ran if name in found.differences]
    if not judged:
        return (str(len(ran)), "reference", "", "", "", total)
    differ = sum(found.differences[name].different for found in judged)
    samples = sum(found.view.width * found.view.height for found in judged)
    worst = max(judged, key=lambda found: found.differences[name].different)
    most = f"{worst.name} {worst.differences[name].different:,}" if differ else ""
    causes = sum((Counter(found.causes[name].counts) for found in judged if name in found.causes), Counter())
    return (str(len(ran)), f"{differ:,}", f"{differ / samples:.3%}", most, _counted(causes), total)


def _counted(counts: Mapping[str, int]) -> str:
    """Write counts, the greatest first: ``vertex snapping 192, tessellation 30``."""
    return ", ".join(f"{name} {count:,}" for name, count in Counter(counts).most_common())
