"""What all pages share: one frame of HTML, whose policy allows its own styles and scripts and nothing else.

A page is a template ``NAME.html`` that fills the frame, a sheet ``NAME.css``, and one call of :func:`page`.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Callable, Mapping, Sequence
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup


def page(
    name: str,
    title: str,
    sheet: Markup,
    scripts: Sequence[str] = (),
    images: str = "data:",
    filters: Mapping[str, Callable[..., Any]] | None = None,
    **shown: Any,
) -> str:
    """Return a page as HTML that needs no network.

    Parameters
    ----------
    name : str
        Of its template, without the ending.
    title : str
    sheet : Markup
        Its styles; see :func:`style`.
    scripts : sequence of str
        Files of this package that stand at the page's end, in this order.
    images : str
        Where its images may come from, as a policy says it.
    filters : mapping of str to callable, optional
        What its template writes numbers and the like by.
    **shown
        What is put into the template; it is escaped.
    """
    environment = templates()
    environment.filters |= filters or {}
    texts = [part(script) for script in scripts]
    return environment.get_template(f"{name}.html").render(
        title=title, style=sheet, scripts=texts, policy=_policy(sheet, texts, images), **shown
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


def _policy(sheet: str, scripts: Sequence[str], images: str) -> str:
    """Return a Content Security Policy that allows exactly these inline texts, and images from one place."""
    allowed = " ".join(map(_hash, scripts)) or "'none'"
    return f"default-src 'none'; img-src {images}; style-src {_hash(sheet)}; script-src {allowed}"


def _hash(text: str) -> str:
    """Return the name by which a policy allows exactly this inline text."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode('utf-8')).digest()).decode('ascii')}'"
