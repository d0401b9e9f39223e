"""Pages from templates."""

from __future__ import annotations

from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup


def asset(path: str) -> Markup:
    """Return a style sheet or script of this package, to stand in a page as it is."""
    return Markup(files("hsr.report").joinpath(path).read_text(encoding="utf-8"))


def filled(template: str, **values: Any) -> str:
    """Return a page: a template of this package with values in it."""
    environment = Environment(
        loader=PackageLoader("hsr.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(values)
