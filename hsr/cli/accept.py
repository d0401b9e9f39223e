"""The commands ``hsr accept`` and ``hsr report``: the page of a test run, and what a person decided in it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, BadParameter, Option

from hsr.cli import common as cli
from hsr.cli.images import Images, option, with_images

RESULTS = Path(".hsr-results/results.json")


@with_images
def accept(
    decisions: Annotated[Path | None, Argument(help="File that the page of a test run wrote, .json.")] = None,
    results: Annotated[Path, Option(help="Folder of the run's results.")] = RESULTS.parent,
    map: Annotated[
        list[str] | None, option("--map", metavar="BASELINE=FILE", help="Make a map a baseline; repeatable.")
    ] = None,
    size: cli.MapSize = None,
    *,
    images: Images,
) -> None:
    """Replace baselines of tests as decided in the page of a test run; run it in the project's root.

    For example:

        hsr accept decisions.json
        hsr accept --map tests/__visibility__/pictures/teapot.npz=ids.png
    """
    from hsr.testing import results as run

    pairs = [given.partition("=")[::2] for given in map or ()]
    if not all(file for _, file in pairs):
        raise BadParameter("--map: write BASELINE=FILE, such as tests/__visibility__/pictures/a.npz=ids.png")
    if decisions is None and not pairs:
        raise BadParameter("name a file of decisions, or --map BASELINE=FILE")
    shown = [(images.read(file, images.size(size, [file])), baseline) for baseline, file in pairs]
    if decisions is not None:
        cli.say(*run.accept(decisions, results, Path()))
    cli.say(*(run.keep(map, baseline, Path()) for map, baseline in shown))


def report(
    results: Annotated[Path, Argument(help="results.json of a test run, in its folder.")] = RESULTS,
) -> None:
    """Write the page and the summary of a test run again, from its results.

    For example:

        hsr report .hsr-results/results.json
    """
    from hsr.testing import recording
    from hsr.testing import results as run

    cli.say(f"{len(run.report(results))} checks: {results.with_name(recording.PAGE)}")
