"""The page of the stability lab: every family, its chart, and the matrix of verdicts."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from markupsafe import Markup, escape

from hsr.base.files import make_folder, write_whole
from hsr.lab.stability.family import GROUPS
from hsr.lab.stability.judge import FINE, Result
from hsr.lab.stability.plots import chart
from hsr.lab.stability.summary import headline, matrix, number
from hsr.pages.frame import page, style


def write_folder(results: Sequence[Result], folder: Path) -> list[Path]:
    """Write a page, a chart of every family, and all figures.

    Parameters
    ----------
    results : sequence of Result
    folder : Path
        Made if it is not there.

    Returns
    -------
    list of Path
        ``index.html``, ``results.json`` with every point, ``matrix.json`` without, and ``FAMILY.svg``
        of every family.

    Raises
    ------
    HsrError
        If the folder or a file cannot be written.
    """
    make_folder(folder)
    charts = {f"{result.family.name}.svg": chart(result) for result in results}
    whole = {"hsr": 1, "families": [result.to_json() for result in results]}
    tables = {"results.json": whole, "matrix.json": matrix(results)}
    written = {"index.html": _page(results, charts, folder / "index.html")}
    written |= {name: json.dumps(told, indent=1) + "\n" for name, told in tables.items()} | charts
    for name, text in written.items():
        write_whole(folder / name, text, "the stability report")
    return [folder / name for name in written]


def _page(results: Sequence[Result], charts: Mapping[str, str], path: Path) -> str:
    return page(
        "stability",
        path,
        "Where the methods break",
        style("stability.css"),
        drawings=True,
        filters={"number": number, "raised": raised},
        results=results,
        groups=GROUPS,
        headline=headline([result.to_json() for result in results]),
        fine=FINE,
        charts={name: Markup(svg[svg.index("<svg") :]) for name, svg in charts.items()},
    )


def raised(formula: str) -> Markup:
    """Write the powers of a formula, as in ``2^-24`` and ``2^(b+1)``, as HTML does."""
    return Markup(re.sub(r"\^(-?\w+(?:\.\d+)?|-?\([^)]*\))", r"<sup>\1</sup>", str(escape(formula))))
