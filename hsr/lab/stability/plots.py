"""One chart a family: what theory expects beside what was measured.

What is measured goes up, the parameter goes to the right from easy to hard. A dotted line stands where theory
expects a variant to break; in a family with a figure of its own, a line without marks is the figure that
theory expects. Variants of which there is no theory are grey. The same result gives the same bytes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import cycle
from string import ascii_lowercase
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hsr.algorithms.registry import certified_methods
from hsr.lab.stability.judge import Result, Row
from hsr.pictures.charts import COLOURS, SHAPES, svg

QUIET = "#767676"
LINES = ("-", "--", "-.", ":")
"""For rows without a theory."""

TICKS = 8
"""At most so many up the side, besides 0."""

SPINES = dict.fromkeys(("axes.spines.top", "axes.spines.right"), False)
STYLE: dict[Any, Any] = {"svg.fonttype": "none", "font.family": "sans-serif", "font.size": 9.0, **SPINES}
"""Text stays text."""


def chart(result: Result) -> str:
    """Draw a result as an SVG document."""
    with matplotlib.rc_context(STYLE):
        return svg(draw(result))


def draw(result: Result) -> Figure:
    """Draw a result as a matplotlib figure, in the style that is current."""
    panels = _panels([row for row in result.rows if row.variant not in certified_methods()])
    figure = Figure(figsize=(8.2, 3.4 * len(panels) + 0.3), layout="constrained")
    every = figure.subplots(len(panels), sharex=True, sharey=True, squeeze=False)[:, 0]
    _scale(every[0], result)
    for axes, rows in zip(every, panels, strict=True):
        _draw_panel(axes, result, rows)
        axes.set_ylabel(result.family.figure_name)
    _name_what_is_marked(every[0], result)
    for axes in every:
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize=8.0)
    every[-1].set_xlabel(f"{result.family.parameter}  (harder to the right)")
    return figure


def _panels(rows: Sequence[Row]) -> list[list[Row]]:
    """Split rows such that each panel has a colour for every row with a theory; the others close the last."""
    known, others = [row for row in rows if row.because], [row for row in rows if not row.because]
    count = max(1, math.ceil(len(known) / len(COLOURS)))
    size = math.ceil(len(known) / count)
    panels = [known[k * size : (k + 1) * size] for k in range(count)]
    panels[-1] += others
    return panels


def _draw_panel(axes: Axes, result: Result, rows: Sequence[Row]) -> None:
    for row in result.rows:
        if row.variant in certified_methods():
            _draw_certified(axes, row)
    # Marks become smaller, so that those of equal rows show as rings about each other.
    styles, lines = zip(COLOURS, SHAPES, np.linspace(8.0, 3.0, len(COLOURS)), strict=True), cycle(LINES)
    for row in rows:
        if row.because:
            _draw_row(axes, row, *next(styles))
        else:
            axes.plot(*_points(row), color=QUIET, linestyle=next(lines), linewidth=1.0, label=row.variant)
    for value in result.family.marked.values():
        axes.axvline(value, color=QUIET, linewidth=0.6, zorder=0)


def _name_what_is_marked(axes: Axes, result: Result) -> None:
    """Put a letter over each marked value, and what it is into the legend."""
    for letter, (name, value) in zip(ascii_lowercase, result.family.marked.items(), strict=False):
        axes.annotate(letter, (value, 1.0), xycoords=("data", "axes fraction"), ha="center", va="bottom")
        axes.plot([], [], linestyle="none", marker=f"${letter}$", color="black", label=name)


def _scale(axes: Axes, result: Result) -> None:
    """Choose scales by what is to be shown; 0 has a place on both."""
    values = [abs(value) for value in result.family.sweep if value]
    if max(values) / min(values) > 16.0:
        if 0.0 in result.family.sweep:
            room = 0.08 * math.log2(max(values) / min(values))  # for 0, in octaves
            axes.set_xscale("symlog", base=2, linthresh=min(values), linscale=max(0.5, room))
        else:
            axes.set_xscale("log", base=2)
    if not result.family.ascending:
        axes.invert_xaxis()
    figures = [figure for row in result.rows for figure in (*row.curve, *_points(row)[1]) if figure]
    low, high = (math.floor(math.log10(extreme(figures, default=1.0))) for extreme in (min, max))
    axes.set_yscale("symlog", base=10, linthresh=10.0**low, linscale=0.3)
    decades = range(low, high + 1, math.ceil((high + 1 - low) / TICKS))
    axes.set_yticks([0.0, *(10.0**k for k in decades)], minor=False)
    axes.margins(x=0.03)


def _draw_certified(axes: Axes, row: Row) -> None:
    first = row.variant == certified_methods()[0]
    colour, thick = ("#c9e3d8", 5.0) if first else ("#222222", 2.0)
    label = f"{row.variant} (certified)"
    axes.plot(*_points(row), color=colour, linewidth=thick, label=label, zorder=1, clip_on=False)


def _draw_row(axes: Axes, row: Row, colour: str, marker: str, size: float) -> None:
    line, values = "none" if row.curve else "-", [point.value for point in row.points]
    mark: dict[str, Any] = {"marker": marker, "markersize": size, "linestyle": line, "label": row.variant}
    axes.plot(*_points(row), color=colour, linewidth=1.0, **mark)
    if row.curve:
        axes.plot(values, row.curve, color=colour, linewidth=1.0, alpha=0.7)
    elif row.predicted is not None:
        axes.axvline(row.predicted, color=colour, linestyle=":", linewidth=1.2)


def _points(row: Row) -> tuple[Sequence[float], Sequence[float]]:
    """Return what was measured; a method that refused has no point."""
    shown = [(point.value, point.figure) for point in row.points if not point.refused]
    return [value for value, _ in shown], [figure for _, figure in shown]
