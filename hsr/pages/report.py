"""The report: one HTML file that shows what every method makes of every scene."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from markupsafe import Markup

from hsr.base.errors import HsrError
from hsr.base.files import write_whole
from hsr.difference.classes import DIFFERENT, SampleClass
from hsr.difference.study import Progress, Study, causes_of
from hsr.models.stages import Cause
from hsr.pages.frame import page, style
from hsr.pages.inspector import fragment, inspected, inspection
from hsr.pages.shading import shade
from hsr.pages.stories import DIGITS
from hsr.pictures.palette import CLASS_COLOURS
from hsr.pictures.png import data_uri

TITLE = "Which surface does the eye see?"

ALL_DIGITS = 12_000_000
"""How many digits the histories of all scenes of a page may have, shared out evenly: 5 MB."""

PACKAGES = ("hsr-lab", "numpy", "numba", "scipy", "moderngl")
"""Whose versions a report names, besides Python's."""


def write_report(
    studies: Sequence[Study],
    path: str | Path,
    title: str = TITLE,
    progress: Progress | None = None,
    pending: Sequence[str] = (),
) -> None:
    """Write :func:`report_page` as a file.

    A report can be written in stages: ``write_report([], path, pending=["exact", "zbuffer"])`` before there
    is anything, ``write_report([found], path, pending=["zbuffer"])`` once a first study is there, and at the
    end without ``pending``. Until then a browser that shows it loads it again every second, and stays where
    it is.

    It is written beside its place and then renamed, so a report that was there stays whole if anything
    fails.

    Raises
    ------
    HsrError
        If there is nothing to report, or the file cannot be written.
    """
    write_whole(path, report_page(studies, title, progress, pending), "the report")


def report_page(
    studies: Sequence[Study],
    title: str = TITLE,
    progress: Progress | None = None,
    pending: Sequence[str] = (),
) -> str:
    """Return a report on several studies as one HTML page that needs no network.

    :func:`hsr.pages.inspector.fragment` names a sample in it: with that at the end of its address the
    inspector opens there.

    Parameters
    ----------
    studies : sequence of Study
        One a scene, each with one map at least.
    title : str
        What the page is headed by.
    progress : callable, optional
        Called with a study's name before the histories of its samples are told, which takes seconds.
    pending : sequence of str
        What is still to come, as the page says it: names of methods or scenes. A study's method that is named
        here is marked so in the tables.

    Raises
    ------
    HsrError
        If there is nothing to report.
    """
    for found in studies:
        if not found.maps:
            raise HsrError(f"nothing to report on {found.name}: every method was skipped")
    if not (studies or pending):
        raise HsrError("nothing to report: no scenes")
    data = []
    for found in studies:
        if progress is not None:
            progress(f"histories of {found.name}")
        data.append(inspection(found, min(DIGITS, ALL_DIGITS // len(studies))))
    return _page(studies, title, data, pending)


def _page(
    studies: Sequence[Study], title: str, data: Sequence[dict[str, Any]], pending: Sequence[str]
) -> str:
    known = dict.fromkeys(name for found in studies for name in found.causes)
    causes = {name: causes_of(studies, name) for name in known}
    colours = (f".class-{kind:d} {{ background: rgb{CLASS_COLOURS[kind.label]}; }}\n" for kind in ABOUT)
    return page(
        "report",
        title,
        style("inspector.css", "report.css") + Markup("".join(colours)),
        [*(["viewer.js"] if data else []), *(["reload.js"] if pending else [])],
        filters={"figures": _figures, "milliseconds": _milliseconds, "note": _note, "uri": data_uri},
        studies=studies,
        pending=pending,
        methods=list(dict.fromkeys(name for found in studies for name in found.methods)),
        classes=ABOUT.items(),
        different=DIFFERENT,
        causes=causes,
        unexplained=Cause.UNEXPLAINED.label,
        stages=[cause.label for cause in Cause if any(why[cause.label] for why in causes.values())],
        extent=_extent,
        expected=_expected,
        flat=any(_expected(found, name) for found in studies for name in found.differences),
        fragment=fragment,
        shade=shade,
        date=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        environment=_environment(studies),
        **inspected(data),
    )


ABOUT = {
    SampleClass.MISSING: "The reference shows a face where the method shows the background.",
    SampleClass.EXTRA: "The method shows a face where the reference shows the background.",
    SampleClass.WRONG_FACE: "Both show a face, and not the same one.",
    SampleClass.DEPTH_ONLY: "Both show the same face, at depths further apart than rounding explains. "
    "Not counted as a difference.",
    SampleClass.TIE: "Another face than the reference's, but either may own the sample: it lies on an edge, "
    "or surfaces coincide. Not counted as a difference.",
}
"""What the classes of samples mean, for people."""


def _expected(study: Study, name: str) -> bool:
    """Whether exactly one of a method and the reference puts polygons in place of curved shapes."""
    return (name in study.tessellating) != (study.reference in study.tessellating)


def _environment(studies: Sequence[Study]) -> dict[str, str]:
    """Name what the figures were made with."""
    versions = {"Python": platform.python_version()} | {name: version(name) for name in PACKAGES}
    system = f"{platform.system()} {platform.machine()}, {os.cpu_count()} processors"
    maps = [named for found in studies for named in found.maps.items()]
    drivers = {name: str(map.notes["driver"]) for name, map in maps if "driver" in map.notes}
    return {**versions, "system": system, **drivers}


# ---------------------------------------------------------------- numbers as people read them


def _extent(start: int, stop: int) -> str:
    """Name the rows or columns from ``start`` to before ``stop``."""
    return str(start) if stop == start + 1 else f"{start}–{stop - 1}"


def _figures(value: float) -> str:
    """Three significant figures; 0 stays 0."""
    return "0" if value == 0.0 else f"{value:.3g}" if math.isfinite(value) else "∞"


def _milliseconds(seconds: float) -> str:
    """One decimal, so that points stand below each other."""
    return f"{1e3 * seconds:,.1f}"


def _note(note: Any) -> str:
    """Return what a method noted about itself, a stored depth's format among it."""
    if isinstance(note, bool):
        return "yes" if note else "no"
    if isinstance(note, dict):
        return ", ".join(f"{name} {_note(value)}" for name, value in note.items() if value is not None)
    if isinstance(note, float):
        return _figures(note)
    return f"{note:,}" if isinstance(note, int) else str(note)
