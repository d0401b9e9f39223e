"""Charts: speed against error, and how times grow.

They are SVG: to print, and to explore in a browser, where every point says what it is. The same panels give
the same bytes. Colours are those of M. Okabe and K. Ito, *Color Universal Design* (2008), which readers with
any colour vision can tell apart; every family has a shape of its own besides.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import cycle, pairwise
from textwrap import shorten
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hsr.base.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Text

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
SHAPES = "osD^vPX"
"""A colour and a shape each, for as many families or rows; further ones begin again."""

INK, GREY, PALE = "#222222", "#8a8a8a", "#eef2f5"

PANEL = (380.0, 400.0)
"""Width and height of the axes of a panel, in points."""

COLUMNS = 3
"""Panels in a row, of the chart of speeds; of the four that show how times grow there are two."""

LINE = 10.5
"""Height of a label, in points."""

STEP = 1.5
"""How finely labels are moved to find room, in points."""

Styles = dict[str, tuple[str, str]]
"""The colour and the shape of every family."""

Box = tuple[float, float, float, float]
"""Left, bottom, right and top, in points from the lower left of a panel."""

FONT = 8.5
LETTER = 0.56 * FONT
"""Mean width of a letter of DejaVu Sans, generously, in points."""

GAP = 7.0
"""Between a mark and its label, in points."""

NOTE = 100
"""Letters of a note that fit below a panel."""

DECADES = tuple(10.0**k for k in range(-4, 10))

KEY = "Dashed: the frontier; nobody beats the methods on it (bold). Whiskers: interval of the median."
GROWTH_KEY = "Dashed: what theory says, its constants fitted. Bands: interval of the median."


# ---------------------------------------------------------------- figures


def svg(figure: Figure, titles: Mapping[str, str] | None = None) -> str:
    """Write a figure as SVG, the same each time: without date, with fixed ids.

    Parameters
    ----------
    figure : Figure
    titles : mapping of str to str, optional
        What browsers show to who points at an artist, by its ``gid``.
    """
    import matplotlib

    text = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": "hsr"}):
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    drawn = text.getvalue()
    for gid, title in (titles or {}).items():
        drawn = drawn.replace(f'<g id="{gid}">', f'<g id="{gid}">\n<title>{escape(title)}</title>', 1)
    return drawn


def _figure(panels: int, columns: int, notes: int) -> tuple[Figure, list[Axes]]:
    """Return a figure with a grid of axes of exactly the size of a panel, with room for notes below each."""
    from matplotlib.figure import Figure

    columns = min(panels, columns)
    rows = -(-panels // columns)
    margin, across, below = 52.0, 34.0, 44.0 + LINE * notes
    width = margin + columns * (PANEL[0] + across)
    height = rows * (PANEL[1] + 26.0 + below)
    figure = Figure(figsize=(width / 72.0, height / 72.0), facecolor="white")
    axes = []
    for k in range(panels):
        row, column = divmod(k, columns)
        left = margin + column * (PANEL[0] + across)
        bottom = height - (row + 1) * (PANEL[1] + 26.0) - row * below
        axes.append(figure.add_axes((left / width, bottom / height, PANEL[0] / width, PANEL[1] / height)))
    return figure, axes


def _name_axes(area: Axes, title: str, x_title: str, y_title: str) -> None:
    area.set_title(title, loc="left", fontsize=10, color=INK)
    area.set_xlabel(x_title, color=INK)
    area.set_ylabel(y_title, color=INK)
    area.tick_params(labelsize=FONT, color=GREY, labelcolor=INK)
    area.spines[["top", "right"]].set_visible(False)
    area.spines[["left", "bottom"]].set_color(GREY)


def _styles(families: Iterable[str]) -> Styles:
    """Give each family a colour and a shape, by its place among all."""
    return dict(zip(dict.fromkeys(families), cycle(zip(COLOURS, SHAPES, strict=True)), strict=False))


def _write_notes(area: Axes, notes: Sequence[str]) -> None:
    for k, note in enumerate(notes):
        told, below = shorten(note, NOTE, placeholder=" ..."), (0.0, -38.0 - LINE * k)
        area.annotate(told, (0, 0), below, "axes fraction", "offset points", size=7.5, color=GREY, va="top")


# ---------------------------------------------------------------- labels


def place_labels(marks: Floats, labels: Sequence[str], lines: Sequence[Box] = ()) -> Floats:
    """Find places for labels beside their marks, clear of each other, of all marks and of lines.

    From the lowest mark up, a label takes the first free line at the right of its mark, at its height or
    above; so labels stand in the order of their marks, and none of the threads to the marks cross.

    Parameters
    ----------
    marks : (n, 2) float64
        Where the marks stand, in points from the lower left of the panel.
    labels : sequence of str
    lines : sequence of Box
        What labels must not cover besides.

    Returns
    -------
    (n, 2) float64
        The middle of the left end of every label.
    """
    taken: list[Box] = [*((x - 4.0, y - 4.0, x + 4.0, y + 4.0) for x, y in marks), *lines]
    places = np.empty_like(marks)
    rows = [*range(int(PANEL[1] / STEP)), *range(-1, -int(PANEL[1] / STEP), -1)]
    for k in np.argsort(marks[:, 1], kind="stable"):
        x, y = marks[k] + (GAP, 0.0)
        width = LETTER * len(labels[k])
        boxes = [(x, y + n * STEP - LINE / 2, x + width, y + n * STEP + LINE / 2) for n in rows]
        inside = [box for box in boxes if box[1] >= 0.0 and box[3] <= PANEL[1]]
        box = next((box for box in inside if not any(_overlap(box, other) for other in taken)), boxes[0])
        taken.append(box)
        places[k] = x, (box[1] + box[3]) / 2.0
    return places


def _overlap(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _write_labels(
    area: Axes, points: Sequence[tuple[float, float]], labels: Sequence[str], steps: Floats | None = None
) -> list[Text]:
    """Write a label beside each point, and a thread to it; clear of the level parts of steps (n, 2), too."""
    to_panel = area.transData - area.transAxes
    corners = (to_panel.transform(steps) * PANEL).tolist() if steps is not None else []
    level = [(x, y - 1.0, end, y + 1.0) for (x, y), (end, _) in pairwise(corners)]
    places = place_labels(to_panel.transform(points) * PANEL, labels, level)
    written = []
    found = to_panel.inverted().transform(places / PANEL)
    for label, (x, y), (left, middle) in zip(labels, points, found, strict=True):
        area.plot([x, left], [y, middle], color="#bbbbbb", lw=0.6, zorder=1)
        written.append(area.text(left, middle, label, fontsize=FONT, color=INK, va="center"))
    return written


# ---------------------------------------------------------------- speed against error


class Mark(NamedTuple):
    """One method in a panel.

    Attributes
    ----------
    label, family : str
        What stands beside the mark, and what gives it colour and shape.
    x, y, low, high : float
        Error, time, and the interval of the time. x may be 0; the others are positive.
    frontier : bool
        Whether no other mark of the panel is better.
    about : str
        What a browser shows to who points at it.
    """

    label: str
    family: str
    x: float
    y: float
    low: float
    high: float
    frontier: bool
    about: str = ""


class Panel(NamedTuple):
    """The marks of one case, and notes on the methods that have none."""

    title: str
    marks: Sequence[Mark]
    notes: Sequence[str] = ()


@dataclass(frozen=True)
class Span:
    """What all panels show: times from bottom to top, by their logarithm, and errors by ``asinh(x)``.

    ``asinh(x)`` is nearly linear below 1, logarithmic far above it, and 0 has a place.
    """

    right: float
    bottom: float
    top: float

    LEFT = -0.45
    """Left of 0, so that marks at 0 stand free of the axis."""

    @classmethod
    def of(cls, panels: Sequence[Panel]) -> Span:
        """Return the span that holds all marks and leaves room for labels at the right."""
        marks = [mark for panel in panels for mark in panel.marks]
        most = max((mark.x for mark in marks), default=0.0)
        bottom = min((mark.low for mark in marks), default=1.0)
        top = max((mark.high for mark in marks), default=10.0)
        return cls(math.sinh(1.35 * math.asinh(max(most, 20.0))), bottom / 1.5, top * 1.5)

    def error_ticks(self) -> list[float]:
        """Return 0 and the powers of ten that the axis of errors shows."""
        return [0.0, *(x for x in DECADES if 1.0 <= x <= self.right)]

    def time_ticks(self) -> list[float]:
        """Return the powers of ten that the axis of times shows, of a short one 2 and 5 times them, too."""
        steps = (1.0, 2.0, 5.0) if self.top / self.bottom < 1000.0 else (1.0,)
        return [step * ten for ten in DECADES for step in steps if self.bottom <= step * ten <= self.top]


def speed_svg(panels: Sequence[Panel], x_title: str, y_title: str) -> str:
    """Draw time against error as SVG, one panel beside the other.

    Parameters
    ----------
    panels : sequence of Panel
    x_title, y_title : str
        Of the axes, with units.

    Returns
    -------
    str
        The same for the same panels.
    """
    span = Span.of(panels)
    titles: dict[str, str] = {}
    styles = _styles(mark.family for panel in panels for mark in panel.marks)
    figure, axes = _figure(len(panels), COLUMNS, 1 + max(len(panel.notes) for panel in panels))
    for k, (panel, area) in enumerate(zip(panels, axes, strict=True)):
        _name_axes(area, panel.title, x_title, "" if k % COLUMNS else y_title)
        _scale(area, span)
        _draw_marks(area, panel, span, styles, titles)
        _write_notes(area, panel.notes if k else (KEY, *panel.notes))
    return svg(figure, titles)


def _scale(area: Axes, span: Span) -> None:
    area.set_yscale("log")
    area.set_xscale("asinh", linear_width=1.0)
    area.set_xlim(span.LEFT, span.right)
    area.set_ylim(span.bottom, span.top)
    for axis, ticks in ((area.xaxis, span.error_ticks()), (area.yaxis, span.time_ticks())):
        axis.set_ticks(ticks, [f"{tick:,.0f}" if tick >= 1.0 else f"{tick:g}" for tick in ticks])
    area.minorticks_off()
    area.axvspan(span.LEFT, -span.LEFT, color=PALE, lw=0)
    area.grid(axis="y", color="#dddddd", lw=0.6)


def _draw_marks(area: Axes, panel: Panel, span: Span, styles: Styles, titles: dict[str, str]) -> None:
    """Draw the marks of a panel and its frontier; add what each mark tells, by its id in the picture."""
    if not panel.marks:
        return
    # To the right of each corner its time is the best so far.
    best = sorted({(mark.x, mark.y) for mark in panel.marks if mark.frontier})
    corners = np.array([*best, (span.right, best[-1][1])])
    area.step(*corners.T, where="post", color=GREY, lw=1.0, ls=(0, (4, 2)), zorder=1)
    labels = [mark.label for mark in panel.marks]
    texts = _write_labels(area, [(mark.x, mark.y) for mark in panel.marks], labels, corners)
    for mark, text in zip(panel.marks, texts, strict=True):
        colour, shape = styles[mark.family]
        area.plot([mark.x] * 2, [mark.low, mark.high], color=colour, lw=1.2, zorder=2)
        gid = f"mark-{len(titles)}"
        area.plot(mark.x, mark.y, shape, color=colour, ms=6, mec="white", mew=0.6, zorder=3, gid=gid)
        text.set_fontweight("bold" if mark.frontier else "normal")
        titles[gid] = mark.about


# ---------------------------------------------------------------- growth


class Curve(NamedTuple):
    """Times of one method over a size, and what theory says of it.

    Attributes
    ----------
    label, family : str
    x, y, low, high : sequence of float
        Size, time and its interval; all positive.
    theory : sequence of float
        The times by the law fitted to the curve; empty without a law.
    """

    label: str
    family: str
    x: Sequence[float]
    y: Sequence[float]
    low: Sequence[float]
    high: Sequence[float]
    theory: Sequence[float] = ()


class Growth(NamedTuple):
    """The curves of one series."""

    title: str
    x_title: str
    curves: Sequence[Curve]


def growth_svg(series: Sequence[Growth], y_title: str) -> str:
    """Draw how times grow, by logarithms both ways, as SVG; what theory says of each curve is dashed.

    Parameters
    ----------
    series : sequence of Growth
        One a panel.
    y_title : str
        Of the axis of times, with its unit.

    Returns
    -------
    str
        The same for the same curves.
    """
    styles = _styles(curve.family for one in series for curve in one.curves)
    figure, axes = _figure(len(series), 2, 1)
    for k, (one, area) in enumerate(zip(series, axes, strict=True)):
        _name_axes(area, one.title, one.x_title, "" if k % 2 else y_title)
        _draw_curves(area, one.curves, styles)
    _write_notes(axes[-1], (GROWTH_KEY,))
    return svg(figure)


def _draw_curves(area: Axes, curves: Sequence[Curve], styles: Styles) -> None:
    area.loglog()
    area.grid(color="#e4e4e4", lw=0.6)
    for curve in curves:
        colour, shape = styles[curve.family]
        area.fill_between(curve.x, curve.low, curve.high, color=colour, alpha=0.25, lw=0)
        area.plot(curve.x, curve.y, shape, color=colour, ms=4.5, ls="-", lw=1.1, mec="white", mew=0.4)
        if curve.theory:
            area.plot(curve.x, curve.theory, color=colour, lw=0.9, ls=(0, (3, 2)))
    sizes = [x for curve in curves for x in curve.x]
    times = [y for curve in curves for y in (*curve.low, *curve.high)]
    area.set_xlim(min(sizes) / 1.3, max(sizes) * (max(sizes) / min(sizes)) ** 0.42)
    area.set_ylim(min(times) / 1.5, max(times) * 1.5)
    _write_labels(area, [(curve.x[-1], curve.y[-1]) for curve in curves], [curve.label for curve in curves])
