"""How far stepped depths drift along a span: measured, beside the bound that theory gives.

    python benchmarks/drift.py

One triangle fills one scan line of L samples; its depths run within [1/2, 1), where float32 and 24-bit
integers are equally dense. Errors are in steps of a 24-bit depth buffer, about ``2**-24``:

* stepped in float32, each of the L sums is off by up to half a spacing, always the same way, since what is
  added is always the same: ``L / 2``, and 3 for the slope and the start;
* evaluated directly in float32, an error of the slope of ``4 * 2**-24`` relative, over a depth of less than
  1/2, and the roundings of one product and one sum: 3 at any length;
* stepped in integers with g guard bits, ``-A/C`` is off by up to ``2**-g / 2``, and so are the first depth of
  the edge and that of the span: ``2**-g (L + 1) / 2``, and 1 for the bits that are cut off in the end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import hsr
from hsr.problem.view import View

STEP = 1.0 / (2**24 - 1)
"""Of a 24-bit depth buffer, in window depth."""

LENGTHS = (64, 256, 1024, 4096, 16384)
SPANS = 16
"""Spans of each length that are tried; the worst counts."""


@dataclass(frozen=True)
class Stepping:
    """A way to step depth.

    Attributes
    ----------
    name : str
    method : str
        A variant of scan conversion.
    options : dict of str to Any
        In place of the variant's own.
    bound : callable
        From the length of the span to the greatest error in steps.
    """

    name: str
    method: str
    options: dict[str, Any]
    bound: Callable[[int], float]


def guarded(bits: int) -> Stepping:
    """Return stepping in integers with so many guard bits."""
    return Stepping(
        f"24 bits + {bits} guard",
        "scanline-fixed",
        {"guard_bits": bits},
        lambda length: 2.0**-bits * (length + 1) / 2 + 1,
    )


STEPPINGS = (
    Stepping("float32, incremental", "scanline-float32", {}, lambda length: length / 2 + 3),
    Stepping("float32, direct", "scanline-float32-direct", {}, lambda _: 3.0),
    guarded(0),
    guarded(6),
    guarded(12),
)


def span(length: int, start: float, end: float) -> View:
    """Return a view of ``length`` x 1 samples, filled by one triangle from depth ``start`` to ``end``."""
    corners = [[-length / 2, 0.5, -start], [-length / 2, -0.5, -start], [length / 2, 0.0, -end]]
    thing = {"name": "span", "shape": "mesh", "vertices": corners, "faces": [[0, 1, 2]]}
    camera = {"type": "orthographic", "eye": [0, 0, 0], "target": [0, 0, -1], "height": 1.0}
    scene = hsr.Scene.model_validate({"camera": [camera | {"near": 0.0, "far": 1.0}], "object": [thing]})
    return hsr.view(scene, (length, 1))


def error(stepping: Stepping, length: int, start: float, end: float) -> float:
    """Return the greatest error of depth along a span, in steps of a 24-bit buffer.

    Near is 0 and far is 1 in a parallel view, so that depth is window depth.
    """
    found = hsr.render(span(length, start, end), stepping.method, **stepping.options)
    exact = start + (end - start) * (np.arange(length) + 0.5) / length
    return float(np.abs(found.depth[0] - exact).max() / STEP)


def worst(stepping: Stepping, length: int) -> float:
    """Return the greatest error over some spans whose ends float32 can hold."""
    random = np.random.default_rng(length)
    ends = np.stack([random.uniform(0.5, 0.55, SPANS), random.uniform(0.9, 0.99, SPANS)], axis=1)
    return max(error(stepping, length, *pair) for pair in ends.astype(np.float32).astype(float).tolist())


def main() -> None:
    """Print measured errors beside their bounds."""
    table = Table(title="Error of depth along a span, in 24-bit steps: measured (bound)", box=None)
    table.add_column("samples")
    for length in LENGTHS:
        table.add_column(f"{length:,}", justify="right")
    for stepping in STEPPINGS:
        cells = [f"{worst(stepping, length):,.1f} ({stepping.bound(length):,.1f})" for length in LENGTHS]
        table.add_row(stepping.name, *cells)
    Console(highlight=False).print(table)


if __name__ == "__main__":
    main()
