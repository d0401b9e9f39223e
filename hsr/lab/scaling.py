"""How times grow: with the triangles, the pixels, the layers one behind the other, and the copies.

Every series changes one of them and keeps the others. Beside the times stands what theory says of the
method (Foley, van Dam et al., *Computer Graphics: Principles and Practice*, chapter 15):

* a ray tested against every face costs ``n p``, with n faces and p pixels;
* a depth buffer sets up every face and visits every fragment: ``a + b n``, linear in each of n, the pixels
  and the layers, as fragments are pixels times layers;
* a hierarchy is entered by every pixel and is about ``log n`` deep: ``p (a + b log n)``.

The constants are fitted; how well the law holds is seen in the chart.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import permutations
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import nnls
from scipy.stats import linregress, t

from hsr.algorithms.registry import methods
from hsr.base.arrays import Floats
from hsr.lab.metrics import SPEED, written
from hsr.lab.results import Results, Row
from hsr.lab.speed import Case, make_case
from hsr.lab.stability.building import placed
from hsr.lab.statistics import CONFIDENCE
from hsr.lab.tables import Table
from hsr.pictures.charts import Curve, Growth
from hsr.scene.model import Scene

SIDE, QUICK_SIDE = 512, 128
"""Pixels a side, where they stay the same."""

KNOT = 20_000
"""Triangles of the knot that is seen by more and more pixels."""

SEED = 1

Law = Callable[[Floats], Floats]
"""From the sizes (n,) to the terms (n, k) whose sum, each with a positive constant, is the time."""

LAWS: dict[str, Law] = {
    "c x": lambda x: x[:, None],
    "a + b x": lambda x: np.stack([np.ones_like(x), x], axis=1),
    "a + b log x": lambda x: np.stack([np.ones_like(x), np.log(x)], axis=1),
}

CONSTANTS = 2
"""That a law has at most: through no more points than these it would run whatever they are."""


class Series(NamedTuple):
    """One thing that grows.

    Attributes
    ----------
    name : str
        Of the series, and what is counted.
    about : str
        What is seen.
    sizes, quick : tuple of int
        How much of it, in a full and in a quick run.
    scene : callable
        The scene with so much of it; of pixels, with so many triangles.
    """

    name: str
    about: str
    sizes: tuple[int, ...]
    quick: tuple[int, ...]
    scene: Callable[[int], Scene]


def size_of(row: Row) -> int:
    """Return how much of its series' thing a row has: the number at the end of its scene's name.

    Of triangles the knot has only about as many as its name says, so they are counted.
    """
    return row.triangles if row.series == "triangles" else int(row.scene.rpartition("-")[2])


def measured_cases(quick: bool) -> list[Case]:
    """Return the cases of all series, of each the smallest first."""
    return [_case(one, size, quick) for one in SERIES for size in (one.quick if quick else one.sizes)]


def _case(series: Series, size: int, quick: bool) -> Case:
    name, side = f"{series.name}-{size}", QUICK_SIDE if quick else SIDE
    if series.name == "pixels":
        size, side = KNOT, math.isqrt(size)
    return replace(make_case(name, series.scene(size), (side, side)), series=series.name)


# ---------------------------------------------------------------- the scenes


def _seen_from(distance: float, *things: dict[str, Any]) -> Scene:
    camera = {"type": "perspective", "eye": [0.0, 0.3 * distance, distance]}
    return Scene.model_validate({"camera": [camera], "object": list(things)})


def _knot(triangles: int) -> Scene:
    """Make a torus knot of about so many triangles, sixteen times as many segments as sides."""
    sides = max(3, round(math.sqrt(triangles / 32.0)))
    segments = max(8, round(triangles / (2.0 * sides)))
    return _seen_from(9.0, {"name": "knot", "shape": "torus-knot", "segments": segments, "sides": sides})


def _layers(layers: int) -> Scene:
    """Put so many squares behind each other, all larger than the image, in no order."""
    depth = np.random.default_rng(SEED).permutation(layers) / layers
    squares = [placed("square", 20.0, [0.0, 0.0, -z]) for z in depth.tolist()]
    return _seen_from(9.0, *({"name": f"layer {k}", **square} for k, square in enumerate(squares)))


def _copies(copies: int) -> Scene:
    """Strew so many copies of one fir on the same ground."""
    scatter = {"count": copies, "x": [-3.0, 3.0], "z": [-6.0, 3.0], "seed": SEED}
    return _seen_from(7.0, {"name": "fir", "shape": "fir", "tiers": 2, "sides": 16, "scatter": scatter})


def _geo(first: int, last: int, count: int) -> tuple[int, ...]:
    """Return so many sizes in geometric progression."""
    return tuple(np.rint(np.geomspace(first, last, count)).astype(int).tolist())


SERIES = (
    Series("triangles", "a torus knot", _geo(100, 10**6, 9), _geo(100, 10**4, 3), _knot),
    Series("pixels", f"a torus knot of {KNOT:,} triangles", _geo(4**6, 4**12, 7), _geo(4**5, 4**7, 3), _knot),
    Series("layers", "squares behind each other", _geo(1, 2**8, 9), _geo(1, 4**2, 3), _layers),
    Series("copies", "copies of a fir", _geo(1, 4**5, 6), _geo(1, 4**2, 3), _copies),
)


# ---------------------------------------------------------------- laws


def exponent(x: Sequence[float], y: Sequence[float]) -> tuple[float, float, float] | None:
    """Fit ``y = c x**k`` by least squares of the logarithms.

    Parameters
    ----------
    x, y : sequence of float
        Positive.

    Returns
    -------
    k, low, high : float, or None
        The slope with its interval by Student's t; None of fewer than three points.
    """
    if len(x) < 3:
        return None
    line = linregress(np.log(x), np.log(y))
    reach = float(t.ppf(0.5 + CONFIDENCE / 2.0, len(x) - 2)) * line.stderr
    return float(line.slope), float(line.slope - reach), float(line.slope + reach)


def law_of(method: str, series: str) -> str | None:
    """Name the law that theory gives a method for a series; None for methods of which it says nothing."""
    known = methods().get(method)
    if known is None:
        return None
    if known.exhaustive:
        return "c x"
    if known.growth == "hierarchy" and series != "pixels":
        return "a + b log x"
    return "a + b x" if known.growth else None


def fitted(law: str, x: Sequence[float], y: Sequence[float]) -> list[float]:
    """Fit the constants of a law, none negative, to the times, and return the times by the law.

    The squares of the *relative* errors are least, so that small times count as much as large ones.

    Parameters
    ----------
    law : str
        One of :data:`LAWS`.
    x, y : sequence of float
        Positive.
    """
    times = np.asarray(y, dtype=np.float64)
    terms = LAWS[law](np.asarray(x, dtype=np.float64))
    constants, _ = nnls(terms / times[:, None], np.ones_like(times))
    return [float(time) for time in terms @ constants]


def growth(results: Results) -> list[Growth]:
    """Return the curves of every series that was measured, with the law fitted to each."""
    found = []
    for series in SERIES:
        rows = [row for row in results.rows if row.series == series.name and not row.absent]
        names = dict.fromkeys(row.method for row in rows)
        curves = [_curve([row for row in rows if row.method == name], series.name) for name in names]
        if curves:
            found.append(Growth(f"{series.about}: more {series.name}", series.name, curves))
    return found


def _curve(rows: Sequence[Row], series: str) -> Curve:
    first, times = rows[0], [row.times[SPEED.name] for row in rows]
    x, y = [float(size_of(row)) for row in rows], [time.median for time in times]
    low, high = [time.low for time in times], [time.high for time in times]
    law = law_of(first.method, series)
    theory = fitted(law, x, y) if law is not None and len(x) > CONSTANTS else ()
    return Curve(first.method, first.family, x, y, low, high, theory)


# ---------------------------------------------------------------- crossovers


class Crossover(NamedTuple):
    """From a size on one method is faster than another, which had been faster before.

    Attributes
    ----------
    winner, loser : str
    at : float
        Where the times are equal, interpolated by logarithms.
    below, above : float
        The measured sizes on both sides of it.
    """

    winner: str
    loser: str
    at: float
    below: float
    above: float

    def sentence(self, thing: str) -> str:
        """Say so, ``thing`` being what is counted."""
        about = int(float(f"{self.at:.1e}"))  # two significant digits: interpolation is no better
        return (
            f"From about {about:,} {thing} on, {self.winner} is faster than {self.loser} "
            f"(measured at {self.below:,.0f} and {self.above:,.0f})."
        )


def crossovers(curves: Sequence[Curve]) -> list[Crossover]:
    """Find where methods of different families change places.

    Only what noise cannot explain: the intervals of the two are apart at the first and at the last size
    that both have, in opposite order.

    Parameters
    ----------
    curves : sequence of Curve

    Returns
    -------
    list of Crossover
        The smallest size first.
    """
    pairs = [(a, b) for a, b in permutations(curves, 2) if a.family != b.family]
    found = [crossing for a, b in pairs if (crossing := _crossing(a, b)) is not None]
    return sorted(found, key=lambda crossing: crossing.at)


def _crossing(winner: Curve, loser: Curve) -> Crossover | None:
    shared = [(winner.x.index(x), loser.x.index(x)) for x in winner.x if x in loser.x]
    if not shared:
        return None
    (w0, l0), (w1, l1) = shared[0], shared[-1]
    if not (winner.low[w0] > loser.high[l0] and winner.high[w1] < loser.low[l1]):
        return None
    x = np.log([winner.x[w] for w, _ in shared])
    lag = np.array([math.log(winner.y[w] / loser.y[k]) for w, k in shared])
    last = int(np.flatnonzero(lag > 0.0)[-1])
    at = np.interp(0.0, -lag[last : last + 2], x[last : last + 2])
    return Crossover(winner.label, loser.label, *(math.exp(size) for size in (at, x[last], x[last + 1])))


# ---------------------------------------------------------------- in words

HEAD = ("series", "method", "grows as", "law", "off by up to", "at the smallest [ms]", "at the largest [ms]")


def table(series: Sequence[Growth]) -> Table:
    """Return a line a curve."""
    rows = [_line(one, curve) for one in series for curve in one.curves]
    return Table(HEAD, rows, HEAD[4:], "How times grow")


def _line(one: Growth, curve: Curve) -> tuple[str, ...]:
    slope = exponent(curve.x, curve.y)
    grows = "" if slope is None else "x^{:.2f} ({:.2f} to {:.2f})".format(*slope)
    off = [abs(law / time - 1.0) for law, time in zip(curve.theory, curve.y, strict=False)]
    law = law_of(curve.label, one.x_title) if off else None
    ends = (written(curve.y[0]), written(curve.y[-1]))
    return (one.x_title, curve.label, grows, law or "", f"{max(off):.0%}" if off else "", *ends)


def sentences(series: Sequence[Growth]) -> list[str]:
    """Say who is fastest at the largest size of every series, and where methods change places."""
    told = []
    for one in series:
        largest = max(x for curve in one.curves for x in curve.x)
        last = [curve for curve in one.curves if curve.x[-1] == largest]
        last.sort(key=lambda curve: curve.y[-1])
        order = ", ".join(f"{curve.label} {written(curve.y[-1])} ms" for curve in last[:3])
        told.append(f"At {largest:,.0f} {one.x_title} the fastest are {order}.")
        told += [crossing.sentence(one.x_title) for crossing in crossovers(one.curves)]
    return told
