"""Baselines replaced by what a person accepted in the page of results."""

from __future__ import annotations

import json
from pathlib import Path, PurePosixPath
from typing import Any

from hsr.base.errors import CheckError
from hsr.problem.map import load_map
from hsr.testing.baselines import FOLDER, next_variant, write

CHOICES = ("accept", "variant", "reject")
"""Replace the baseline, keep one more valid one, or leave all as it is."""


def apply(decisions: Path, results: Path, root: Path) -> list[str]:
    """Do what a person decided.

    Everything is read and checked before anything is written.

    Parameters
    ----------
    decisions : Path
        The file that the page of results wrote.
    results : Path
        Folder of the results it was made of.
    root : Path
        The project's root, from which the names of baselines are seen.

    Returns
    -------
    list of str
        A line for each decision.

    Raises
    ------
    HsrError
        If a file cannot be read or written, or the decisions are of another run.
    """
    made, told = _json(decisions), _json(results / "results.json")
    if made.get("run") != told.get("run"):
        raise CheckError(f"{decisions}: made of another run than {results}; name its results with --results")
    checks = {check["key"]: check for record in told["tests"] for check in record["checks"]}
    planned = []
    for key, choice in made["decisions"].items():
        check = _decided(decisions, key, choice, checks, root)
        planned.append((check, choice, None if choice == "reject" else load_map(results / check["shown"])))
    lines = []
    for check, choice, map in planned:
        file = root / check["baseline"]
        if map is None:
            lines.append(f"rejected: {check['baseline']} stays")
            continue
        if choice == "variant" and file.exists():
            stem = file.stem.partition("~")[0]
            file = next_variant(file.parent, stem, file.suffix)
        write(file, map, check["depths"])
        lines.append(f"wrote {file.relative_to(root).as_posix()}")
    return lines


def _decided(
    decisions: Path, key: str, choice: str, checks: dict[str, dict[str, Any]], root: Path
) -> dict[str, Any]:
    """Return the check that a decision is about."""
    check = checks.get(key)
    if check is None or choice not in CHOICES:
        raise CheckError(f"{decisions}: {key}: no such check or choice; the choices are {', '.join(CHOICES)}")
    place = PurePosixPath(check["baseline"])
    if place.is_absolute() or ".." in place.parts or FOLDER not in place.parts:
        raise CheckError(f"{decisions}: {key}: has no baseline in this project")
    beside = root.joinpath(*place.parts[: place.parts.index(FOLDER)])
    if not beside.is_dir():
        raise CheckError(f"{decisions}: there is no folder {beside} here; run this in the project's root")
    return check


def _json(file: Path) -> dict[str, Any]:
    try:
        told = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise CheckError(f"{file}: cannot be read ({error})") from error
    if not isinstance(told, dict) or told.get("hsr") != 1 or "run" not in told:
        raise CheckError(f"{file}: holds no decisions or results of this version")
    return told
