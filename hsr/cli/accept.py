"""The command ``hsr accept``: what a person decided in the page of a test run, done."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from hsr.cli import common as cli


def accept(
    decisions: Annotated[Path, Argument(help="File that the page of a test run wrote, .json.")],
    results: Annotated[Path, Option(help="Folder of the run's results.")] = Path(".hsr-results"),
) -> None:
    """Replace baselines of tests as decided in the page of a test run; run it in the project's root."""
    from hsr.testing import results as run

    cli.say(*run.accept(decisions, results, Path()))
