"""The report: one HTML file that shows what every method makes of every scene."""

from __future__ import annotations

import base64
import hashlib
import math
import os
import platform
from collections import Counter
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from hsr.base.errors import HsrError
from hsr.base.files import write_whole
from hsr.difference.classes import DIFFERENT, SampleClass
from hsr.difference.study import Study
from hsr.models.stages import Cause
from hsr.pages.inspection import DIGITS, inspection, key
from hsr.pages.pictures import CLASS_COLOURS, class_picture, data_uri, opaque
from hsr.pages.shading import shade

ALL_DIGITS = 12_000_000
"""How many digits the histories of all scenes of a page may have, shared out evenly: 5 MB."""

PACKAGES = ("hsr-lab", "numpy", "numba", "scipy", "moderngl")
"""Whose versions a report names, besides Python's."""


HELP = (
    ("1 … 9", "method by its number, on the right"),
    ("Shift+1 … Shift+9", "reference by its number, on the left"),
    ("j k", "next and previous method"),
    ("J K", "next and previous reference"),
    ("t", "two pictures side by side, zoomed together"),
    ("b", "blink; Space flips by hand"),
    ("s o", "swipe, onion skin; , and . move the share of the method"),
    ("i p z", "faces, shaded picture, depth"),
    ("m c", "class map, cause map"),
    ("Ctrl+← Ctrl+→", "the picture before, the next: faces, shaded, depth, classes, causes"),
    ("n", "stretch the greys of depth over what is in view, and back"),
    ("v", "next overlay: facing, depth complexity, face size, wireframe"),
    ("← ↑ → ↓", "move by one sample, with Shift by ten"),
    ("[ ]", "previous and next cluster of the method"),
    ("g", "go to a sample: column, row"),
    ("+ - f 0", "zoom in, out, fit, one pixel a sample"),
    ("y", "count rows from the bottom, as OpenGL does, or from the top"),
    ("? Escape", "this help; close"),
)
"""Keys of the inspector and what they do."""


def write_report(
    studies: Sequence[Study],
    path: str | Path,
    title: str = "Which surface does the eye see?",
    progress: Callable[[str], None] | None = None,
) -> None:
    """Write a report on several studies as one HTML file that needs no network.

    :func:`fragment` names a sample in it: with that at the end of its address the inspector opens there.

    The file is written beside its place and then renamed, so a report that was there stays whole
    if anything fails.

    Parameters
    ----------
    studies : sequence of Study
        One a scene, each with one map at least.
    path : str or Path
    title : str
        What the page is headed by.
    progress : callable, optional
        Called with a study's name before the histories of its samples are told, which takes seconds.

    Raises
    ------
    HsrError
        If there is nothing to report, or the file cannot be written.
    """
    for found in studies:
        if not found.maps:
            raise HsrError(f"nothing to report on {found.name}: every method was skipped")
    if not studies:
        raise HsrError("nothing to report: no scenes")
    data = []
    for found in studies:
        if progress is not None:
            progress(f"histories of {found.name}")
        data.append(inspection(found, min(DIGITS, ALL_DIGITS // len(studies))))
    write_whole(path, _render(studies, title, data), "the report")


def fragment(scene: str, method: str, sample: tuple[int, int] | None = None) -> str:
    """Return the end of a report's address that opens the inspector at a sample.

    Parameters
    ----------
    scene : str
        The name of a study in the report.
    method : str
        What is shown beside the reference.
    sample : (row, column), optional
        Row 0 is the top row; without it the method's largest cluster is shown.

    Returns
    -------
    str
        ``#scene=teapot&method=opengl&x=311&y=204``: x is the column, y the row.
    """
    named = {"scene": scene, "method": method}
    if sample is not None:
        named |= {"x": str(sample[1]), "y": str(sample[0])}
    return f"#{urlencode(named, safe='/')}"


def _render(studies: Sequence[Study], title: str, data: Sequence[dict[str, Any]]) -> str:
    sheet, script = style("inspector.css", "report.css") + _colours(), part("viewer.js")
    environment = templates()
    environment.filters |= {"figures": _figures, "milliseconds": _milliseconds, "note": _note, "size": _size}
    return environment.get_template("report.html").render(
        title=title,
        studies=studies,
        methods=list(dict.fromkeys(name for found in studies for name in found.methods)),
        classes=[(kind, ABOUT[kind]) for kind in CLASS_COLOURS],
        different=DIFFERENT,
        causes=_causes(studies),
        stages=[cause.label for cause in Cause if any(why[cause.label] for why in _causes(studies).values())],
        unexplained=Cause.UNEXPLAINED.label,
        extent=_extent,
        expected=_expected,
        flat=any(_expected(found, name) for found in studies for name in found.differences),
        fragment=fragment,
        picture=_picture,
        small=lambda difference: data_uri(class_picture(difference)),
        date=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        environment=_environment(studies),
        help=HELP,
        key=key(),
        data=data,
        style=sheet,
        script=script,
        policy=policy(sheet, script),
    )


def templates() -> Environment:
    """Return the templates of pages; what is put into them is escaped."""
    return Environment(
        loader=PackageLoader("hsr.pages"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def style(*own: str) -> Markup:
    """Return the styles of a page: what every page shares, then its own sheets."""
    return Markup("").join(part(f"templates/{sheet}") for sheet in ("shared.css", *own))


def part(name: str) -> Markup:
    """Return a style or script of this package, to stand in a page as it is."""
    return Markup(files("hsr.pages").joinpath(name).read_text(encoding="utf-8"))


def _colours() -> Markup:
    """Return the styles that show the colours of the classes."""
    lines = (f".class-{kind:d} {{ background: rgb{colour}; }}\n" for kind, colour in CLASS_COLOURS.items())
    return Markup("".join(lines))


def policy(sheet: str, *scripts: str, images: str = "data:") -> str:
    """Return a Content Security Policy that allows exactly these inline texts, and images from one place."""
    allowed = " ".join(map(_hash, scripts)) or "'none'"
    return f"default-src 'none'; img-src {images}; style-src {_hash(sheet)}; script-src {allowed}"


def _hash(text: str) -> str:
    """Return the name by which a policy allows exactly this inline text."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode('utf-8')).digest()).decode('ascii')}'"


def _picture(study: Study) -> str:
    base = study.maps[study.reference or next(iter(study.maps))]
    return data_uri(opaque(shade(base, study.view)))


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


def _causes(studies: Sequence[Study]) -> dict[str, Counter[str]]:
    """Count the wrong samples of every method by cause, over all scenes."""
    total: dict[str, Counter[str]] = {}
    for found in studies:
        for name, why in found.causes.items():
            total.setdefault(name, Counter()).update(why.counts)
    return total


def _environment(studies: Sequence[Study]) -> dict[str, str]:
    """Name what the figures were made with."""
    made_with = {"Python": platform.python_version()} | {name: version(name) for name in PACKAGES}
    made_with["system"] = f"{platform.system()} {platform.machine()}, {os.cpu_count()} processors"
    for found in studies:
        for name, map in found.maps.items():
            if "driver" in map.notes:
                made_with[name] = str(map.notes["driver"])
    return made_with


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


def _size(study: Study) -> str:
    return f"{study.view.width} × {study.view.height}"
