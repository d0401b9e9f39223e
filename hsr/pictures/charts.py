"""Charts: speed against error, and how times grow.

They are drawn twice from the same panels: by matplotlib as SVG for print, by Altair as a page to explore.
The same panels give the same bytes. Colours are those of M. Okabe and K. Ito, *Color Universal Design*
(2008), which readers with any colour vision can tell apart; every family has a shape of its own besides.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from textwrap import shorten
from typing import TYPE_CHECKING, Any

import numpy as np

from hsr.base.arrays import Floats

if TYPE_CHECKING:
    import altair
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
SHAPES = (
    ("o", "circle"),
    ("s", "square"),
    ("^", "triangle-up"),
    ("D", "diamond"),
    ("v", "triangle-down"),
    ("P", "cross"),
    ("X", "stroke"),
)
"""A shape a family, as matplotlib and as Vega call it."""

INK, GREY, PALE = "#222222", "#8a8a8a", "#eef2f5"

PANEL = (380.0, 400.0)
"""Width and height of the axes of a panel, in points."""

LINE = 10.5
"""Height of a label, in points."""

STEP = 1.5
"""How finely labels are moved to find room, in points."""

Box = tuple[float, float, float, float]
"""Left, bottom, right and top, in points from the lower left of a panel."""

FONT = 8.5
LETTER = 0.56 * FONT
"""Mean width of a letter of DejaVu Sans, generously, in points."""

GAP = 7.0
"""Between a mark and its label, in points."""

DECADES = tuple(10.0**k for k in range(-4, 10))


@dataclass(frozen=True)
class Mark:
    """One method in a panel.

    Attributes
    ----------
    row : str
        Id of the row of the results that the mark shows.
    label, family : str
        What stands beside the mark, and what gives it colour and shape.
    x, y, low, high : float
        Error, time, and the interval of the time. x may be 0; the others are positive.
    frontier : bool
        Whether no other mark of the panel is better.
    details : mapping of str to str
        What the tooltip tells.
    """

    row: str
    label: str
    family: str
    x: float
    y: float
    low: float
    high: float
    frontier: bool
    details: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Panel:
    """The marks of one case, and notes on the methods that have none."""

    title: str
    marks: Sequence[Mark]
    notes: Sequence[str] = ()


@dataclass(frozen=True)
class Frame:
    """The area that panels share: time upwards by its logarithm, error to the right by ``log(1 + x)``.

    ``log(1 + x)`` is Vega's ``symlog``: nearly linear below 1, logarithmic far above it, and 0 has a place.
    """

    right: float
    bottom: float
    top: float

    LEFT = -0.45
    """Left of 0, so that marks at 0 stand free of the axis."""

    @classmethod
    def around(cls, panels: Sequence[Panel]) -> Frame:
        """Return the frame that holds all marks and leaves room for labels at the right."""
        marks = [mark for panel in panels for mark in panel.marks]
        most = max((mark.x for mark in marks), default=0.0)
        bottom = min((mark.low for mark in marks), default=1.0)
        top = max((mark.high for mark in marks), default=10.0)
        return cls(float(np.expm1(1.35 * np.log1p(max(most, 20.0)))), bottom / 1.5, top * 1.5)

    def places(self, figures: Sequence[tuple[float, float]]) -> Floats:
        """Where pairs of error and time stand in a panel: (n, 2) points from its lower left."""
        x, y = np.reshape(np.array(figures, dtype=np.float64), (-1, 2)).T
        left, right = symlog(self.LEFT), symlog(self.right)
        across = (symlog(x) - left) / (right - left)
        up = np.log(y / self.bottom) / np.log(self.top / self.bottom)
        return np.stack([across, up], axis=1) * PANEL

    def time_at(self, height: float) -> float:
        """Time at a height in points: the inverse of :meth:`places`."""
        return float(self.bottom * (self.top / self.bottom) ** (height / PANEL[1]))

    def error_at(self, distance: float) -> float:
        """Error at a distance from the left in points."""
        left, right = symlog(self.LEFT), symlog(self.right)
        return float(unsymlog(left + (right - left) * distance / PANEL[0]))


def symlog(x: Any) -> Floats:
    """Return ``sign(x) log(1 + |x|)``."""
    transformed: Floats = np.sign(x) * np.log1p(np.abs(x))
    return transformed


def unsymlog(u: Any) -> Floats:
    """Return the inverse of :func:`symlog`."""
    error: Floats = np.sign(u) * np.expm1(np.abs(u))
    return error


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
    taken: list[Box] = [(x - 4.0, y - 4.0, x + 4.0, y + 4.0) for x, y in marks]
    taken += lines
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


def families(panels: Iterable[Panel]) -> list[str]:
    """Return the families of all marks, in order of appearance: the order of colours and shapes."""
    return list(dict.fromkeys(mark.family for panel in panels for mark in panel.marks))


def _frontier(marks: Iterable[Mark], frame: Frame) -> list[tuple[float, float]]:
    """Corners of the frontier: to the right of each mark its time is the best so far."""
    best = sorted({(mark.x, mark.y) for mark in marks if mark.frontier})
    return [*best, (frame.right, best[-1][1])] if best else []


def _label_places(panel: Panel, frame: Frame) -> Floats:
    """Where the labels of a panel stand, in points: clear of the frontier, too."""
    corners = frame.places(_frontier(panel.marks, frame)).tolist()
    level = [(x, y - 1.0, end, y + 1.0) for (x, y), (end, _) in pairwise(corners)]
    marks = frame.places([(mark.x, mark.y) for mark in panel.marks])
    return place_labels(marks, [mark.label for mark in panel.marks], level)


# ---------------------------------------------------------------- print


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
        The same for the same panels: without date, with fixed ids.
    """
    frame, names = Frame.around(panels), families(panels)
    figure, axes = _figure(len(panels), COLUMNS, 1 + max(len(panel.notes) for panel in panels))
    for k, (panel, area) in enumerate(zip(panels, axes, strict=True)):
        _draw_area(area, frame, panel.title, x_title)
        if k % COLUMNS == 0:
            area.set_ylabel(y_title, color=INK)
        _draw_marks(area, frame, panel, names)
        _draw_notes(area, (KEY, *panel.notes) if k == 0 else panel.notes)
    return _svg(figure)


COLUMNS = 3
"""Panels in a row, of the chart of speeds; of the four that show how times grow there are two."""

GROWTH_KEY = "Dashed: what theory says, its constants fitted. Bands: interval of the median."

NOTE = 100
"""Letters of a note that fit below a panel."""

KEY = "Dashed: the frontier; nobody beats the methods on it (bold). Whiskers: interval of the median."


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


def _draw_area(area: Axes, frame: Frame, title: str, x_title: str) -> None:
    area.set_title(title, loc="left", fontsize=10, color=INK)
    area.set_xlabel(x_title, color=INK)
    area.set_yscale("log")
    area.set_xscale("function", functions=(symlog, unsymlog))
    area.set_xlim(frame.LEFT, frame.right)
    area.set_ylim(frame.bottom, frame.top)
    area.set_xticks(error_ticks(frame), [_tick(x) for x in error_ticks(frame)])
    area.set_yticks(time_ticks(frame), [_tick(y) for y in time_ticks(frame)])
    area.minorticks_off()
    area.axvspan(frame.LEFT, -frame.LEFT, color=PALE, lw=0)
    area.grid(axis="y", color="#dddddd", lw=0.6)
    area.tick_params(labelsize=FONT, color=GREY, labelcolor=INK)
    for side in ("top", "right"):
        area.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        area.spines[side].set_color(GREY)


def error_ticks(frame: Frame) -> list[float]:
    """Return 0 and the powers of ten that a frame's axis of errors shows."""
    return [0.0, *(x for x in DECADES if 1.0 <= x <= frame.right)]


def time_ticks(frame: Frame) -> list[float]:
    """Return the powers of ten that a frame's axis of times shows, of short axes 2 and 5 times them, too."""
    steps = (1.0, 2.0, 5.0) if frame.top / frame.bottom < 1000.0 else (1.0,)
    return [step * ten for ten in DECADES for step in steps if frame.bottom <= step * ten <= frame.top]


def _tick(value: float) -> str:
    return f"{value:,.0f}" if value >= 1.0 else f"{value:g}"


def _draw_marks(area: Axes, frame: Frame, panel: Panel, names: Sequence[str]) -> None:
    if not panel.marks:
        return
    corners = _frontier(panel.marks, frame)
    area.step(*zip(*corners, strict=True), where="post", color=GREY, lw=1.0, ls=(0, (4, 2)), zorder=1)
    places = _label_places(panel, frame)
    for mark, (left, middle) in zip(panel.marks, places, strict=True):
        k = names.index(mark.family)
        colour, shape = COLOURS[k % len(COLOURS)], SHAPES[k % len(SHAPES)][0]
        at = (frame.error_at(left), frame.time_at(middle))
        area.plot([mark.x, at[0]], [mark.y, at[1]], color="#bbbbbb", lw=0.6, zorder=1)
        area.plot([mark.x] * 2, [mark.low, mark.high], color=colour, lw=1.2, zorder=2)
        area.plot(mark.x, mark.y, shape, color=colour, ms=6, mec="white", mew=0.6, zorder=3)
        weight = "bold" if mark.frontier else "normal"
        area.text(*at, mark.label, fontsize=FONT, color=INK, va="center", weight=weight)


def _draw_notes(area: Axes, notes: Sequence[str]) -> None:
    for k, note in enumerate(notes):
        offset = (0.0, -38.0 - LINE * k)
        area.annotate(
            shorten(note, NOTE, placeholder=" ..."),
            (0.0, 0.0),
            offset,
            "axes fraction",
            "offset points",
            fontsize=7.5,
            color=GREY,
            va="top",
        )


def _svg(figure: Figure) -> str:
    import matplotlib

    text = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": "hsr", "svg.fonttype": "path"}):
        figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()


# ---------------------------------------------------------------- growth


@dataclass(frozen=True)
class Curve:
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


@dataclass(frozen=True)
class Growth:
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
    names = list(dict.fromkeys(curve.family for one in series for curve in one.curves))
    figure, axes = _figure(len(series), 2, 1)
    for k, (one, area) in enumerate(zip(series, axes, strict=True)):
        area.set_title(one.title, loc="left", fontsize=10, color=INK)
        area.set_xlabel(one.x_title, color=INK)
        if k % 2 == 0:
            area.set_ylabel(y_title, color=INK)
        _draw_curves(area, one.curves, names)
    _draw_notes(axes[-1], (GROWTH_KEY,))
    return _svg(figure)


def _draw_curves(area: Axes, curves: Sequence[Curve], names: Sequence[str]) -> None:
    area.loglog()
    area.grid(color="#e4e4e4", lw=0.6)
    area.tick_params(labelsize=FONT, color=GREY, labelcolor=INK)
    for curve in curves:
        k = names.index(curve.family)
        colour, shape = COLOURS[k % len(COLOURS)], SHAPES[k % len(SHAPES)][0]
        area.fill_between(curve.x, curve.low, curve.high, color=colour, alpha=0.25, lw=0)
        area.plot(curve.x, curve.y, shape, color=colour, ms=4.5, ls="-", lw=1.1, mec="white", mew=0.4)
        if curve.theory:
            area.plot(curve.x, curve.theory, color=colour, lw=0.9, ls=(0, (3, 2)))
    ends = [x for curve in curves for x in curve.x]
    times = [y for curve in curves for y in (*curve.low, *curve.high)]
    area.set_xlim(min(ends) / 1.3, max(ends) * (max(ends) / min(ends)) ** 0.42)
    area.set_ylim(min(times) / 1.5, max(times) * 1.5)
    _label_ends(area, curves)
    for side in ("top", "right"):
        area.spines[side].set_visible(False)


def _label_ends(area: Axes, curves: Sequence[Curve]) -> None:
    """Write the name of each curve at the right of its last point."""
    ends = [(curve.x[-1], curve.y[-1]) for curve in curves]
    marks = area.transAxes.inverted().transform(area.transData.transform(ends)) * PANEL
    places = place_labels(marks, [curve.label for curve in curves])
    at = area.transData.inverted().transform(area.transAxes.transform(places / PANEL))
    for curve, (end, time), (left, middle) in zip(curves, ends, at, strict=True):
        area.plot([end, left], [time, middle], color="#bbbbbb", lw=0.6, zorder=1)
        area.text(left, middle, curve.label, fontsize=FONT, color=INK, va="center")


# ---------------------------------------------------------------- page


def speed_chart(panels: Sequence[Panel], x_title: str, y_title: str) -> dict[str, Any]:
    """Describe the chart of time against error in the grammar of Vega-Lite, for a page.

    Every mark tells its row, and a family chosen in the legend stands out.

    Parameters
    ----------
    panels : sequence of Panel
    x_title, y_title : str

    Returns
    -------
    dict
        JSON values, all data among them.
    """
    import altair as alt

    frame, names = Frame.around(panels), families(panels)
    chosen = alt.selection_point(fields=["family"], bind="legend", name="family")
    charts = [_chart(panel, frame, names, chosen, x_title, y_title) for panel in panels]
    charts[0] = charts[0].add_params(chosen)  # once is enough: all panels share the legend
    whole = alt.concat(*charts, columns=COLUMNS)
    described: dict[str, Any] = (
        whole.configure_view(stroke=None).configure_axis(gridColor="#dddddd").to_dict()
    )
    return described


def _chart(
    panel: Panel, frame: Frame, names: Sequence[str], chosen: altair.Parameter, x_title: str, y_title: str
) -> altair.LayerChart | altair.FacetChart:
    import altair as alt

    places = _label_places(panel, frame)
    data = alt.InlineData(
        values=[_datum(mark, place, frame) for mark, place in zip(panel.marks, places, strict=True)]
    )
    corners = alt.InlineData(values=[{"x": x, "y": y} for x, y in _frontier(panel.marks, frame)])
    x = alt.X(
        "x:Q",
        title=x_title,
        scale=alt.Scale(type="symlog", constant=1, domain=[frame.LEFT, frame.right], nice=False),
        axis=alt.Axis(values=error_ticks(frame), grid=False, format=",d"),
    )
    y = alt.Y(
        "y:Q",
        title=y_title,
        scale=alt.Scale(type="log", domain=[frame.bottom, frame.top], nice=False),
        axis=alt.Axis(values=time_ticks(frame), format=",~g"),
    )
    colour = alt.Color(
        "family:N", scale=alt.Scale(domain=list(names), range=_cycled(COLOURS, names)), title="family"
    )
    shape = alt.Shape(
        "family:N", scale=alt.Scale(domain=list(names), range=_cycled([s for _, s in SHAPES], names))
    )
    faded = alt.condition(chosen, alt.value(1.0), alt.value(0.15))
    tooltip = [alt.Tooltip(f"{name}:N") for name in ("row", *panel.marks[0].details)] if panel.marks else []
    base = alt.Chart(data).encode(opacity=faded)
    layers = (
        alt.Chart(corners)
        .mark_line(interpolate="step-after", color=GREY, strokeDash=[4, 2])
        .encode(x=x, y=y),
        base.mark_rule(color="#bbbbbb").encode(x=x, y=y, x2="label_x", y2="label_y"),
        base.mark_rule(strokeWidth=1.5).encode(x=x, y=alt.Y("low:Q"), y2="high", color=colour),
        base.mark_point(filled=True, size=70, opacity=1).encode(
            x=x, y=y, color=colour, shape=shape, tooltip=tooltip
        ),
        base.mark_text(align="left", fontSize=FONT * 1.2, color=INK).encode(
            x=alt.X("label_x:Q"), y=alt.Y("label_y:Q"), text="label:N", tooltip=tooltip
        ),
    )
    return alt.layer(*layers).properties(title=panel.title, width=PANEL[0], height=PANEL[1])


def _datum(mark: Mark, label: Floats, frame: Frame) -> dict[str, Any]:
    place = {"label_x": frame.error_at(label[0]), "label_y": frame.time_at(label[1])}
    shown = {name: getattr(mark, name) for name in ("row", "label", "family", "x", "y", "low", "high")}
    return shown | place | dict(mark.details)


def _cycled(values: Sequence[str], names: Sequence[str]) -> list[str]:
    return [values[k % len(values)] for k in range(len(names))]
