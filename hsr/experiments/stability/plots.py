"""One chart a family: what theory expects beside what was measured.

Wrong samples go up, the parameter goes to the right from easy to hard; a dotted line stands where theory
expects a variant to break. The same result gives the same bytes. Colours are those of M. Okabe and K. Ito,
*Color Universal Design* (2008).
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

from hsr.experiments.stability.family import CERTIFIED
from hsr.experiments.stability.judge import Result, Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = "osD^vPX"
LINES = ("-", "--", ":")
"""For the first seven rows, the second, and the third."""
QUIET = "#8a8a8a"

STYLE: dict[Any, Any] = {
    "svg.hashsalt": "hsr",
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
}
"""Text stays text, and ids depend on nothing but what is drawn."""


def chart(result: Result) -> str:
    """Draw a result.

    Parameters
    ----------
    result : Result

    Returns
    -------
    str
        An SVG document.
    """
    import matplotlib

    with matplotlib.rc_context(STYLE):
        figure = draw(result)
        written = io.StringIO()
        figure.savefig(written, format="svg", metadata={"Date": None, "Creator": None})
    return written.getvalue()


def draw(result: Result) -> Figure:
    """Draw a result as a matplotlib figure, in the style that is current."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.2, 3.9), layout="constrained")
    axes = figure.subplots()
    _scale(axes, result)
    styles = product(LINES, zip(COLOURS, MARKERS, strict=True))
    for row in result.rows:
        if row.variant in CERTIFIED:
            _draw_certified(axes, row)
        else:
            line, (colour, marker) = next(styles) if row.because else ("-", (QUIET, ""))
            _draw_row(axes, row, line, colour, marker)
    for name, value in result.family.crossings.items():
        axes.axvline(value, color=QUIET, linewidth=0.6)
        axes.annotate(name, (value, 0.02), xycoords=("data", "axes fraction"), rotation=90, fontsize=6.5)
    axes.set_xlabel(f"{result.family.parameter}  (harder to the right)")
    axes.set_ylabel(result.family.figure_name)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=8.0)
    return figure


def _scale(axes: Axes, result: Result) -> None:
    """Choose scales by what is to be shown; 0 has a place on both."""
    values = [abs(value) for value in result.family.sweep if value]
    if max(values) / min(values) > 16.0:
        least = min(values)
        if 0.0 in result.family.sweep:
            axes.set_xscale("symlog", base=2, linthresh=least, linscale=0.5)
        else:
            axes.set_xscale("log", base=2)
    if not result.family.ascending:
        axes.invert_xaxis()
    curves = [
        figure for row in result.rows for figure in (*row.curve, *(p.figure for p in row.points)) if figure
    ]
    if result.family.figure and curves:
        axes.set_yscale("symlog", base=10, linthresh=min(curves), linscale=0.3)
    else:
        axes.set_yscale("symlog", base=10, linthresh=1.0, linscale=0.3)
    axes.margins(x=0.03)


def _draw_certified(axes: Axes, row: Row) -> None:
    x, y = _points(row)
    thick = 5.0 if row.variant == CERTIFIED[0] else 2.0
    colour = "#c9e3d8" if row.variant == CERTIFIED[0] else "#222222"
    axes.plot(
        x, y, color=colour, linewidth=thick, label=f"{row.variant} (certified)", zorder=1, clip_on=False
    )


def _draw_row(axes: Axes, row: Row, line: str, colour: str, marker: str) -> None:
    x, y = _points(row)
    label = f"{row.variant}: {row.verdict}"
    measured = axes.plot(
        x, y, color=colour, marker=marker, markersize=4.0, linewidth=1.0, linestyle=line, label=label
    )
    if row.curve:
        measured[0].set_linestyle("none")
        axes.plot([point.value for point in row.points], row.curve, color=colour, linestyle=line, alpha=0.7)
    elif row.predicted is not None:
        axes.axvline(row.predicted, color=colour, linestyle=":", linewidth=1.2)


def _points(row: Row) -> tuple[Sequence[float], Sequence[float]]:
    """Return what was measured; a method that refused has no point."""
    shown = [(point.value, point.figure) for point in row.points if not point.refused]
    return [value for value, _ in shown], [figure for _, figure in shown]
