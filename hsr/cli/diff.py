"""The command ``hsr diff``: two maps compared."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import hsr
from hsr.cli import common as cli


def diff(
    a: Annotated[Path, typer.Argument(help="Map, .npz.")],
    b: Annotated[Path, typer.Argument(help="Map to judge it against, .npz.")],
    as_json: cli.Json = False,
    verbose: cli.Verbose = False,
) -> None:
    """Compare two visibility maps; exit 1 if any sample shows another face."""
    difference = hsr.compare(hsr.load_map(a), hsr.load_map(b))
    told = {"hsr": 1, "files": [str(a), str(b)], **difference.to_json()}
    cli.tell(as_json, told, [difference.summary(clusters=None if verbose else 5)])
    if not difference.same:
        raise typer.Exit(cli.DIFFERS)
