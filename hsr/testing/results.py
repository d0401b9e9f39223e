"""The results of a run: JSON, a page, and a summary, from what its tests recorded; what a person accepts."""

from __future__ import annotations

import hashlib
import json
from bisect import bisect
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import accumulate
from pathlib import Path, PurePosixPath
from typing import Any, Literal

from hsr.base.errors import CheckError, HsrError
from hsr.base.files import write_whole
from hsr.lab.machine import machine
from hsr.pages.checks import write_page
from hsr.problem.map import VisibilityMap, load_map
from hsr.testing.baselines import FOLDER, SUFFIXES, check_place, next_variant, read_json, write
from hsr.testing.recording import ITEMS, PAGE, Check, Record

RESULTS = "results.json"
SUMMARY = "summary.md"

NO_RESULTS = "holds no results of this version"

MAX_SUMMARY = 900_000
"""Bytes of a summary: GitHub refuses step summaries of more than 1 MiB."""


Choice = Literal["accept", "variant", "reject"]
"""Replace the baseline, keep one more valid one, or leave all as it is."""


@dataclass
class Run:
    """What a run's ``results.json`` holds."""

    hsr: Literal[1]
    run: str
    environment: dict[str, Any]
    unused: list[str]
    tests: list[Record]

    @property
    def checks(self) -> list[tuple[str, Check]]:
        """All checks, each with its test."""
        return [(record.test, check) for record in self.tests for check in record.checks]


@dataclass
class Decisions:
    """What a person decided: a choice by the key of the check."""

    hsr: Literal[1]
    run: str
    decisions: dict[str, Choice]


def gather(
    folder: Path, root: Path, whole: Sequence[Path], unused: str = "warn", selfcheck: bool = False
) -> tuple[list[str], bool]:
    """Write ``results.json``, ``report.html`` and ``summary.md`` from what the tests of a run recorded.

    Parameters
    ----------
    folder : Path
        The results of the run.
    root : Path
        The project's root.
    whole : sequence of Path
        Test modules that used all the baselines they need: what they did not use is unused.
    unused : {"warn", "fail", "ignore"}
        What to make of baselines that no test used.
    selfcheck : bool
        Whether checks were to be tried on planted mistakes.

    Returns
    -------
    list of str
        Lines for the terminal.
    bool
        Whether the run fails for what no test could notice: a check let a planted mistake pass, none could
        be tried on any, or unused baselines are to fail.

    Raises
    ------
    HsrError
        If a record cannot be read.
    """
    records = [read_json(Record, file, NO_RESULTS) for file in folder.glob(f"{ITEMS}/*/checks.json")]
    records.sort(key=lambda record: record.test)
    left = [file.relative_to(root).as_posix() for file in _unused(records, whole, root) if unused != "ignore"]
    tests = [asdict(record) for record in records]
    run = hashlib.sha256(json.dumps(tests, sort_keys=True).encode()).hexdigest()[:16]
    told = Run(1, run, _environment(records), left, records)
    fails = (selfcheck and _overlooked(told.checks)) or (unused == "fail" and bool(left))
    lines = list(_lines(told.checks, left, folder, selfcheck))
    try:
        text = json.dumps(asdict(told), indent=1, ensure_ascii=False)
        write_whole(folder / RESULTS, text + "\n", "the results", CheckError)
        report(folder / RESULTS)
    except HsrError as error:  # The tests are judged all the same.
        lines.insert(0, f"the results are not whole: {error}")
    return lines, fails


def _overlooked(checks: Sequence[tuple[str, Check]]) -> bool:
    """Tell whether a check lets a planted mistake pass, or none was tried on any."""
    lets_pass = [check.lets_pass for _, check in checks if check.lets_pass is not None]
    return not lets_pass or any(lets_pass)


def report(results: Path) -> list[tuple[str, Check]]:
    """Write page and summary of a run beside its ``results.json``; return its checks, each with its test.

    Raises
    ------
    HsrError
        If a file cannot be read or written.
    """
    folder, told = results.parent, read_json(Run, results, NO_RESULTS)
    checks = sorted(told.checks, key=lambda entry: entry[1].passed)  # failed first, else in order of tests
    write_whole(folder / SUMMARY, _summary(checks, told.unused), "the summary", CheckError)
    write_page([(test, vars(check)) for test, check in checks], told.run, told.unused, folder / PAGE)
    return checks


def _environment(records: Sequence[Record]) -> dict[str, Any]:
    """Return the machine, versions, and who rendered what was checked."""
    contents = (check.contents for record in records for check in record.checks)
    renderers = sorted({held["renderer"] for held in contents if "renderer" in held})
    return {**machine().model_dump(mode="json"), "renderers": renderers}


def _unused(records: Sequence[Record], whole: Sequence[Path], root: Path) -> list[Path]:
    """Find baselines that no test of a whole module used, and those of modules that are no more."""
    used = {root / record.baselines / name for record in records for name in record.used}
    kept = {module.parent / FOLDER / module.stem for module in whole}
    for folder in {module.parent / FOLDER for module in whole}:
        kept |= {orphan for orphan in folder.glob("*/") if not (folder.parent / f"{orphan.name}.py").exists()}
    files = (file for folder in kept for ending in ("npz", "json") for file in folder.glob(f"*.{ending}"))
    return sorted(set(files) - used)


def _lines(
    checks: Sequence[tuple[str, Check]], unused: Sequence[str], folder: Path, selfcheck: bool
) -> Iterator[str]:
    failed = sum(not check.passed for _, check in checks)
    yield f"{len(checks)} checks, {failed} failed: {(folder / PAGE).as_uri()}"
    yield from (f"unused baseline: {file}" for file in unused)
    tried = [(test, check) for test, check in checks if check.lets_pass is not None]
    for test, check in tried:
        for mistake, wrong in (check.lets_pass or {}).items():
            yield f"{test}: {check.name} would pass with the mistake {mistake!r}; wrong samples: {wrong}"
    weak = sum(check.weaker for _, check in checks)
    if weak:
        yield f"{weak} of the checks compare pictures: weaker, as a wrong face may be painted alike"
    if selfcheck:
        others = "the others failed, or name no scene" if tried else "tell them what they show, by scene="
        yield f"{len(tried)} of {len(checks)} checks were tried on planted mistakes; {others}"


def _summary(checks: Sequence[tuple[str, Check]], unused: Sequence[str]) -> str:
    """Write Markdown for a step summary: failed checks in full, as far as there is room."""
    parts = [f"\n### {test}\n\n```\n{check.text}\n```\n" for test, check in checks if not check.passed]
    room = bisect(list(accumulate(len(part.encode()) for part in parts)), MAX_SUMMARY)
    told = [f"## Visibility: {len(checks)} checks, {len(parts)} failed\n", *parts[:room]]
    if room < len(parts):
        told.append(f"\nand {len(parts) - room} more, for which there is no room here\n")
    if unused:
        told.append("\n### Unused baselines\n\n" + "".join(f"- `{file}`\n" for file in unused))
    return "".join(told)


# ---------------------------------------------------------------- what a person decided


def accept(decisions: Path, results: Path, root: Path) -> list[str]:
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
    made = read_json(Decisions, decisions, "holds no decisions of this version")
    told = read_json(Run, results / RESULTS, NO_RESULTS)
    if made.run != told.run:
        raise CheckError(f"{decisions}: made of another run than {results}; name its results with --results")
    checks = {check.key: check for _, check in told.checks}
    planned = []
    for key, choice in made.decisions.items():
        if key not in checks:
            raise CheckError(f"{decisions}: {key}: the run has no such check")
        file = _baseline(f"{decisions}: {key}", checks[key].baseline, root)
        map = None if choice == "reject" else load_map(results / checks[key].shown)
        planned.append((checks[key], choice, file, map))
    return [_done(root, *plan) for plan in planned]


def keep(map: VisibilityMap, baseline: str, root: Path) -> str:
    """Make a map a baseline, and return a line that says so.

    Parameters
    ----------
    map : VisibilityMap
        Of whatever program.
    baseline : str
        Its file as seen from ``root``: ``tests/__visibility__/pictures/teapot.npz``.
    root : Path
        The project's root.

    Raises
    ------
    HsrError
        If it is no place for baselines in this project, or cannot be written.
    """
    file = _baseline(baseline, baseline, root)
    write(file, map, map.tells_depth)
    return f"wrote {file.relative_to(root).as_posix()}"


def _done(root: Path, check: Check, choice: Choice, file: Path, map: VisibilityMap | None) -> str:
    if map is None:
        return f"rejected: {check.baseline} stays"
    if choice == "variant" and file.exists():
        file = next_variant(file.parent, file.stem.partition("~")[0], file.suffix)
    write(file, map, check.depths)
    return f"wrote {file.relative_to(root).as_posix()}"


def _baseline(which: str, baseline: str, root: Path) -> Path:
    """Return the file of a baseline: two below a folder of baselines, in this project."""
    place = PurePosixPath(baseline)
    below = place.parts[-3:-2] == (FOLDER,) and place.suffix in SUFFIXES.values()
    if not below or place.is_absolute() or ".." in place.parts:
        raise CheckError(f"{which}: has no baseline in this project")
    beside = root.joinpath(*place.parts[:-3])
    if not beside.is_dir():
        raise CheckError(f"{which}: there is no folder {beside} here; run this in the project's root")
    if not beside.resolve().is_relative_to(root.resolve()):
        raise CheckError(f"{which}: {beside} leads out of the project")
    check_place(root / place)
    return root / place
