"""The command ``hsr compare``: scenes by many methods, each map beside the reference."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from signal import SIG_IGN, SIGINT, signal
from typing import TYPE_CHECKING, Annotated

from typer import BadParameter, Exit, Option

import hsr
from hsr.base.errors import HsrError, UnavailableError
from hsr.cli import common as cli
from hsr.cli.cameras import Cameras, with_cameras
from hsr.cli.images import Images, with_images

if TYPE_CHECKING:
    from hsr.base.store import Store
    from hsr.difference.cause import Causes
    from hsr.difference.study import Progress, Study

Explain = Callable[["Study"], dict[str, "Causes"]]

MANY = 3
"""So many new scenes are worth the seconds that other processes take to start."""

ENDED = "a process that finds causes was ended, perhaps for want of memory: try again, with fewer scenes"


@with_cameras
@with_images
def compare(
    scenes: cli.SceneFiles,
    method: cli.Methods = None,
    ref: Annotated[str, Option(help="Reference method.")] = "exact",
    map: cli.NamedMaps = None,
    size: cli.MapSize = None,
    output: Annotated[Path | None, cli.output("Write the report, .html.", ".html")] = None,
    histories: Annotated[cli.Text, Option(help="Samples a scene that the report explains, or all.")] = None,
    fail_on: Annotated[cli.Text, Option(help="Classes of difference, comma separated: then exit 1.")] = None,
    fresh: Annotated[bool, Option("--fresh", help="Compute all anew; take nothing from the store.")] = False,
    as_json: cli.Json = False,
    quiet: cli.Quiet = False,
    verbose: cli.Verbose = False,
    *,
    cameras: Cameras,
    images: Images,
) -> None:
    """Render scenes by many methods and compare every visibility map with the reference.

    Without -a the method each family is called after takes part, and every peer; '-a all' adds all
    variants. Those that test each face at each sample sit out scenes that would keep them busy for minutes,
    unless they are named.

    For example:

        hsr compare teapot -o report.html
        hsr compare bunny.obj --ref opengl -a zbuffer -a raycast
        hsr compare solids --orbit 8 --fail-on missing,extra
        hsr compare teapot --map mine=ids.png --map theirs=ids.npy -o report.html
    """
    from hsr.algorithms.ahead import Ahead
    from hsr.base.store import Store
    from hsr.difference.study import study

    forbidden, told = _classes(fail_on or ""), _histories(histories)
    loaded = [pair for path in scenes for pair in cameras.scenes(path.stem, hsr.load(path))]
    if map and len(loaded) > 1:
        raise HsrError(f"--map: a map shows one view, not {len(loaded)}; name one scene and one camera")
    sides = images.size(size, map or ())
    given = [images.read(file, sides, hsr.view(loaded[0][1], sides)) for file in map or ()]
    asked, names = cli.named(method), cli.names(method)
    store, studies = Store(fresh=fresh), []
    with cli.progress(quiet, len(loaded) * (len({*names, ref}) + 1)) as step:
        with Ahead(scenes[0], [*names, ref]) as ahead:
            for name, scene in loaded:
                how = partial(study, name=name, patient=bool(asked), progress=step, store=store, ahead=ahead)
                studies.append(how(scene, names, ref, sides, given=given))
        for found in studies:
            # What is missing here and was asked for by name is no mere skipped column.
            for name in found.missing.intersection([*asked, ref]):
                raise UnavailableError(found.skipped[name])
        explain = partial(_causes, store=store, page=output is not None, histories=told)
        studies = [*_explained(studies, explain, step)]
        if output is not None:
            from hsr.pages.report import write_report

            write_report(studies, output, histories=told, store=store)
    store.trim()
    if as_json:
        cli.print_json("compare", {"studies": [found.to_json() for found in studies]})
    else:
        _print(studies, verbose)
        if output is not None:
            cli.say(f"report: {output}")
    for found in studies if forbidden else ():
        # What was asked for by name and not compared must not pass.
        for name in sorted(found.skipped.keys() & {*asked, ref}):
            raise HsrError(f"--fail-on: {found.name}: {name} did not run: {found.skipped[name]}")
    differences = [difference for found in studies for difference in found.differences.values()]
    if any(difference.counts[name] for difference in differences for name in forbidden):
        raise Exit(cli.DIFFERS)


def _explained(studies: Sequence[Study], explain: Explain, step: Progress) -> Iterator[Study]:
    """Say why samples are wrong: of many scenes that are new by several processes."""
    from hsr.difference.study import RECALLED

    new = sum(any(RECALLED not in map.notes for map in found.maps.values()) for found in studies)
    with ExitStack() as end:
        answers = map(explain, studies)
        if new >= MANY:
            apart = ProcessPoolExecutor(mp_context=get_context("spawn"), initializer=_alone)
            end.callback(apart.shutdown, cancel_futures=True)
            # Ctrl-C goes to all processes; those that are started here leave it to this one.
            heard = signal(SIGINT, SIG_IGN)
            asked = [apart.submit(explain, found) for found in studies]
            signal(SIGINT, heard)
            answers = map(Future.result, asked)
        try:
            for found, causes in zip(studies, answers, strict=True):
                step(f"{found.name}: causes")
                yield replace(found, causes=causes)
        except BrokenProcessPool:
            raise HsrError(ENDED) from None


def _alone() -> None:
    """Have a process that is one of several use one thread."""
    import numba

    numba.set_num_threads(1)


def _causes(found: Study, store: Store, page: bool, histories: int | None) -> dict[str, Causes]:
    """Return why samples of a study are wrong; have the store keep what a page says of it."""
    from hsr.difference.study import explained
    from hsr.pages.report import gathered

    found = explained(found, store)
    if page:
        gathered(found, histories, store)
    return found.causes


def _histories(text: str | None) -> int | None:
    from hsr.pages.stories import HISTORIES

    try:
        return None if text == cli.ALL else int(text or HISTORIES)
    except ValueError:
        raise BadParameter(f"--histories {text!r}: write a number, or all") from None


def _classes(text: str) -> list[str]:
    from hsr.difference.classes import DIFFERENT

    names = [name.strip() for name in text.split(",") if name.strip()]
    for name in names:
        if name not in DIFFERENT:
            raise BadParameter(f"--fail-on: no class {name!r}; there are {', '.join(DIFFERENT)}")
    return names


# ---------------------------------------------------------------- tables

LEAST = ("largest cluster", "depth only", "tie", "extra", "missing", "wrong face", "render")
"""Columns of a scene that give way where there is no room, in that order."""


def _print(studies: Sequence[Study], verbose: bool) -> None:
    """Print one table a scene; of several scenes only their sum, unless more is wanted."""
    if len(studies) == 1 or verbose:
        for found in studies:
            _print_study(found, verbose)
    if len(studies) > 1:
        _print_sum(studies)
    if any(found.name.endswith(f", {found.camera}") for found in studies):
        _print_cameras(studies)


def _print_study(found: Study, verbose: bool) -> None:
    from hsr.difference.classes import DIFFERENT
    from hsr.difference.nothing import why_nothing

    title = f"{found.name}, {found.view.width}x{found.view.height}, against {found.reference or 'nothing'}"
    head = ("method", "differ", *DIFFERENT, "largest cluster", "render")
    rows = [_cells(found, name, DIFFERENT) for name in found.methods]
    cli.print_table(head, rows, title=title, least=LEAST)
    if found.maps and all((shown.face < 0).all() for shown in found.maps.values()):
        cli.say(f"nothing is seen: {why_nothing(found.view, next(iter(found.maps)))}")
    cli.say(*(f"{name}: {_counted(why.counts)}" for name, why in found.causes.items() if why.wrong))
    cli.say(*(f"{name}: {reason}" for name, reason in found.skipped.items()))
    if any(_star([found], name) for name in found.maps):
        cli.say("*: computed before, and measured then; --fresh measures now")
    if verbose:
        cli.say(*(difference.summary() for difference in found.differences.values()))
    cli.out.print()


def _cells(found: Study, name: str, kinds: Sequence[str]) -> tuple[str, ...]:
    if name in found.skipped:
        return (name, _absence(found, name))
    time = cli.milliseconds(found.maps[name].seconds) + _star([found], name)
    if name not in found.differences:
        return (name, "reference" if name == found.reference else "-", *[""] * (len(kinds) + 1), time)
    difference = found.differences[name]
    counts = (difference.different, *map(difference.counts.__getitem__, kinds), difference.largest)
    return (name, *(f"{count:,}" for count in counts), time)


def _star(studies: Sequence[Study], name: str) -> str:
    """Mark times that were not all measured now."""
    from hsr.difference.study import RECALLED

    return "*" if any(found.maps[name].notes.get(RECALLED) for found in studies) else ""


def _absence(found: Study, name: str) -> str:
    return "not available" if name in found.missing else "skipped"


def _print_sum(studies: Sequence[Study]) -> None:
    """Print one row a method over all scenes."""
    references = ", ".join(dict.fromkeys(found.reference or "nothing" for found in studies))
    title = f"{len(studies)} scenes, samples that show another face than {references}"
    names = dict.fromkeys(name for found in studies for name in found.methods)
    rows = [_sum_cells([found for found in studies if name in found.methods], name) for name in names]
    head = ("method", "scenes", "differ", "share", "most of them in", "causes", "render")
    right = [name for name in head[1:] if name != "causes"]
    least = ("share", "scenes", "most of them in", "render")
    cli.print_table(head, rows, right, title, below=["causes"], least=least)
    if any(found.reference in found.tessellating for found in studies):
        cli.out.print("Methods that keep curved shapes exact rightly differ along the outlines of polygons.")


def _sum_cells(studies: Sequence[Study], name: str) -> tuple[str, ...]:
    from hsr.difference.study import causes_of

    ran = [found for found in studies if name in found.maps]
    if not ran:
        return (name, "0", _absence(studies[0], name))
    total = f"{1e3 * sum(found.maps[name].seconds.get('render', 0.0) for found in ran):,.0f} ms"
    total += _star(ran, name)
    judged = [found for found in ran if name in found.differences]
    if not judged:
        return (name, str(len(ran)), "reference", "", "", "", total)
    differ = sum(found.differences[name].different for found in judged)
    samples = sum(found.differences[name].total for found in judged)
    worst = max(judged, key=lambda found: found.differences[name].different)
    most = f"{worst.name} {worst.differences[name].different:,}" if differ else ""
    causes = _counted(causes_of(judged, name))
    return (name, str(len(ran)), f"{differ:,}", f"{differ / samples:.3%}", most, causes, total)


def _print_cameras(studies: Sequence[Study]) -> None:
    """Print one row a scene and camera: the wrong samples of every method that is wrong anywhere."""
    judged = dict.fromkeys(name for found in studies for name in found.differences)
    found_by = {name: [found.differences.get(name) for found in studies] for name in judged}
    names = [name for name in judged if any(found and not found.same for found in found_by[name])]
    wrong = [[f"{found.different:,}" if found else "-" for found in found_by[name]] for name in names]
    rows = list(zip([found.name for found in studies], *wrong, strict=True))
    cli.out.print()
    cli.print_table(("scene, camera", *names), rows, title="Samples that show another face, by camera")
    if always := [name for name in judged if name not in names]:
        cli.say(f"nowhere: {', '.join(always)}")


def _counted(counts: Mapping[str, int]) -> str:
    """Write counts, the greatest first: ``vertex snapping 192, tessellation 30``."""
    return ", ".join(f"{name} {count:,}" for name, count in Counter(counts).most_common())
