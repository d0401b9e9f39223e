"""The commands ``hsr accept`` and ``hsr report``: the page of a test run, and what a person decided in it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from hsr.cli import common as cli

RESULTS = Path(".hsr-results/results.json")


def accept(
    decisions: Annotated[Path, Argument(help="File that the page of a test run wrote, .json.")],
    results: Annotated[Path, Option(help="Folder of the run's results.")] = RESULTS.parent,
) -> None:
    """Replace baselines of tests as decided in the page of a test run; run it in the project's root.

    For example:

        hsr accept decisions.json
    """
    from hsr.testing import results as run

    cli.say(*run.accept(decisions, results, Path()))


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
