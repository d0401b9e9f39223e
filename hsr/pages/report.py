"""The report: one HTML file that shows what every method makes of every scene."""

from __future__ import annotations

import math
import os
import platform
from collections import Counter
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from itertools import accumulate
from pathlib import Path
from typing import Any, NamedTuple

from markupsafe import Markup

from hsr.algorithms.registry import methods
from hsr.base.errors import HsrError
from hsr.base.files import write_whole
from hsr.base.store import Store
from hsr.difference.classes import DIFFERENT, SampleClass
from hsr.difference.study import Study, causes_of
from hsr.models.foreign import MODEL
from hsr.models.stages import Cause
from hsr.pages.frame import page, style
from hsr.pages.inspector import fragment, inspected, inspection
from hsr.pages.shading import shade
from hsr.pages.stories import HISTORIES, LISTED
from hsr.pictures.palette import CAUSE_COLOURS, CLASS_COLOURS
from hsr.pictures.png import data_uri
from hsr.problem.map import READ

TITLE = "Which surface does the eye see?"

PACKAGES = ("hsr-lab", "numpy", "numba", "scipy", "moderngl")
"""Whose versions a report names, besides Python's."""


def write_report(
    studies: Sequence[Study],
    path: str | Path,
    title: str = TITLE,
    pending: Sequence[str] = (),
    histories: int | None = HISTORIES,
    store: Store | None = None,
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
    write_whole(path, report_page(studies, title, pending, histories, path, store), "the report")


def report_page(
    studies: Sequence[Study],
    title: str = TITLE,
    pending: Sequence[str] = (),
    histories: int | None = HISTORIES,
    path: str | Path | None = None,
    store: Store | None = None,
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
    pending : sequence of str
        What is still to come, as the page says it: names of methods or scenes. A study's method that is named
        here is marked so in the tables.
    histories : int or None
        How many samples of each scene have their history in the page, None for all that differ or lie beside
        one that does; those that the page links to have theirs in any case.
    path : str or Path, optional
        Where the page will lie, for links to the project's other pages.
    store : Store, optional
        Where what the inspector shows is looked up, and kept.

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
    data = [gathered(found, histories, store) for found in studies]
    return _page(studies, path, title, data, pending)


class Gathered(NamedTuple):
    """What a page shows of a study besides its figures.

    Attributes
    ----------
    inspection : dict
        By :func:`hsr.pages.inspector.inspection`.
    picture : str
        What the first map shows, shaded, as a data URI.
    differing : dict of str to str
        Where each method differs that does, as data URIs.
    """

    inspection: dict[str, Any]
    picture: str
    differing: dict[str, str]


def gathered(found: Study, histories: int | None, store: Store | None) -> Gathered:
    """Look up what a page shows of a study, or gather it."""
    if store is None:
        return _gather(found, histories)
    told = ("driver", MODEL, READ)
    maps = [(name, map.digest, *[map.notes.get(note) for note in told]) for name, map in found.maps.items()]
    scene = (found.scene.model_dump_json(), found.scene.file, found.scene.cameras_of_file, found.view.hashes)
    parts = ("page", found.name, found.camera, found.reference, bool(found.causes), histories, maps, scene)
    data: Gathered | None = store.get(*parts)
    if data is None:
        data = _gather(found, histories)
        store.put(data, *parts)
    return data


def _gather(found: Study, histories: int | None) -> Gathered:
    picture = shade(found.maps[found.reference or next(iter(found.maps))], found.view)
    differing = {name: data_uri(why.picture()) for name, why in found.differences.items() if not why.same}
    return Gathered(inspection(found, histories), data_uri(picture), differing)


def _page(
    studies: Sequence[Study],
    path: str | Path | None,
    title: str,
    data: Sequence[Gathered],
    pending: Sequence[str],
) -> str:
    known = dict.fromkeys(name for found in studies for name in found.causes)
    causes = {name: causes_of(studies, name) for name in known}
    kinds = [(f"class-{kind:d}", CLASS_COLOURS[kind.label]) for kind in ABOUT]
    kinds += [(f"cause-{kind:d}", CAUSE_COLOURS[kind.label]) for kind in Cause if kind]
    colours = (f".{name} {{ background: rgb{colour}; }}\n" for name, colour in kinds)
    return page(
        "report",
        path,
        title,
        style("inspector.css", "report.css") + Markup("".join(colours)),
        [*(["viewer.js"] if data else []), *(["reload.js"] if pending else [])],
        filters={"figures": _figures, "milliseconds": _milliseconds, "note": _note},
        studies=studies,
        pending=pending,
        methods=list(dict.fromkeys(name for found in studies for name in found.methods)),
        classes=ABOUT.items(),
        different=DIFFERENT,
        causes=causes,
        unexplained=Cause.UNEXPLAINED.label,
        stages=[cause.label for cause in Cause if any(why[cause.label] for why in causes.values())],
        numbers={cause.label: int(cause) for cause in Cause},
        causes_in=_causes_in,
        bad=_bad,
        told=_told,
        sentence=_sentence,
        extent=_extent,
        expected=_expected,
        flat=any(_expected(found, name) for found in studies for name in found.differences),
        fragment=fragment,
        listed=LISTED,
        shown=data,
        date=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        environment=_environment(studies),
        **inspected([one.inspection for one in data]),
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


def _bad(study: Study, name: str) -> bool:
    """Whether a method shows other faces, and mostly for another reason than that it was asked to."""
    why = study.causes.get(name)
    if why is None or not why.wrong:
        return not (study.differences[name].same or _expected(study, name))
    return 2 * why.counts.get(Cause.TESSELLATION.label, 0) < why.wrong


class Share(NamedTuple):
    """The part that a cause has in the wrong samples of a method."""

    cause: str
    samples: int
    start: float
    share: float
    colour: str


def _causes_in(study: Study, name: str) -> list[Share]:
    """Return what makes a method wrong, the commonest first."""
    why = study.causes.get(name)
    counts = Counter(why.counts).most_common() if why else []
    starts = accumulate((count for _, count in counts), initial=0)
    total = max(why.wrong, 1) if why else 1
    return [
        Share(cause, count, start / total, count / total, "#{:02x}{:02x}{:02x}".format(*CAUSE_COLOURS[cause]))
        for (cause, count), start in zip(counts, starts, strict=False)
    ]


def _told(study: Study, name: str) -> str:
    """Say how often a method is wrong, and why: ``61 of 262,144 wrong, all by vertex snapping``."""
    found, parts = study.differences[name], _causes_in(study, name)
    if not parts:
        return f"{found.different:,} of {found.total:,} differ"
    most = "" if parts[0].cause in UNCAUSED else "by "
    how = "all" if len(parts) == 1 else "mostly" if parts[0].share > 0.5 else "most of them"
    because = f"{most}{UNCAUSED.get(parts[0].cause, parts[0].cause)}"
    return f"{sum(part.samples for part in parts):,} of {found.total:,} wrong, {how} {because}"


def _sentence(study: Study) -> str:
    """Say what matters most of a scene: of the drivers that draw pictures elsewhere, else of the worst."""

    def weight(name: str) -> tuple[bool, bool, int]:
        method = methods().get(name)
        return _bad(study, name), method is not None and bool(method.needs), study.differences[name].different

    wrong = [name for name, found in study.differences.items() if not found.same]
    if not study.differences:
        return "There is no reference to judge by."
    worst = max(wrong, key=weight, default="")
    return (
        f"{worst}: {_told(study, worst)}." if worst else "Every method shows the right face at every sample."
    )


UNCAUSED = {
    Cause.NO_DEPTH_TEST.label: "for want of a depth test",
    Cause.UNEXPLAINED.label: "unexplained",
}
"""How causes are told that nothing is done *by*."""


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
