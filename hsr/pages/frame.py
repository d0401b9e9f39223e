"""What all pages share: one frame of HTML, whose policy allows its own styles and scripts and nothing else.

A page is a template ``NAME.html`` that fills the frame, a sheet ``NAME.css``, and one call of :func:`page`.
"""

from __future__ import annotations

import base64
import hashlib
import os
from collections.abc import Callable, Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

PAGES = {
    "Report": "lab.html",
    "Sample report": "sample.html",
    "Scenes": "gallery/index.html",
    "Lessons": "lessons/index.html",
    "Stability": "stability/index.html",
    "API": "api/index.html",
}
"""The project's pages, by where they lie in a folder of reports."""


def page(
    name: str,
    path: str | Path | None,
    title: str,
    sheet: Markup,
    scripts: Sequence[str] = (),
    images: str = "data:",
    drawings: bool = False,
    filters: Mapping[str, Callable[..., Any]] | None = None,
    beside: Mapping[str, str] | None = None,
    **shown: Any,
) -> str:
    """Return a page as HTML that needs no network.

    Parameters
    ----------
    name : str
        Of its template, without the ending.
    path : str, Path or None
        Where it will lie: it leads to the other pages of the project that lie about it.
    sheet : Markup
        Its styles; see :func:`style`.
    scripts : sequence of str
        Files of this package that stand at the page's end, in this order.
    images : str
        Where its images may come from, as a policy says it.
    drawings : bool
        Whether it holds SVG, whose parts carry styles of their own.
    filters : mapping of str to callable, optional
        What its template writes numbers and the like by.
    beside : mapping of str to str, optional
        What else it leads to, and where that lies.
    **shown
        What is put into the template; it is escaped.
    """
    loader, texts = PackageLoader("hsr.pages"), [_part(script) for script in scripts]
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= filters or {}
    styles = "'unsafe-inline'" if drawings else _hash(sheet)
    code = " ".join(map(_hash, texts)) or "'none'"
    policy = f"default-src 'none'; img-src {images}; style-src {styles}; script-src {code}"
    template = environment.get_template(f"{name}.html")
    led = (siblings(Path(path).absolute()) if path else {}) | dict(beside or {})
    around = {"siblings": led, "here": path and Path(path).name}
    return template.render(title=title, style=sheet, scripts=texts, policy=policy, **around, **shown)


def siblings(path: Path) -> dict[str, str]:
    """Find the project's pages among which a page lies, itself too, and where they lie from it."""
    for root in (path.parent, path.parent.parent):
        found = {name: root / place for name, place in PAGES.items()}
        found = {name: file for name, file in found.items() if file == path or file.is_file()}
        if {*found.values()} - {path}:
            return {name: Path(os.path.relpath(file, path.parent)).as_posix() for name, file in found.items()}
    return {}


def style(*own: str) -> Markup:
    """Return the styles of a page: what every page shares, then its own sheets."""
    return Markup("").join(_part(f"templates/{sheet}") for sheet in ("shared.css", *own))


def _part(name: str) -> Markup:
    """Return a style or script of this package, to stand in a page as it is."""
    return Markup(files("hsr.pages").joinpath(name).read_text(encoding="utf-8"))


def _hash(text: str) -> str:
    """Return the name by which a Content Security Policy allows exactly this inline text."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode('utf-8')).digest()).decode('ascii')}'"
