"""Results made up by hand, so that statistics and charts need no clock."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hsr.lab.results import DepthOff, Machine, Results, Row, Verdict
from hsr.lab.statistics import timing

MACHINE = Machine(
    name="slide-rule-2",
    cpu="Slide Rule",
    processors=2,
    threads=2,
    system="wood",
    versions={"hsr-lab": "1.0"},
    environment={"OMP_WAIT_POLICY": "passive"},
)


def noisy(median: float, seed: int, turns: int = 21, noise: float = 0.03) -> list[float]:
    """Seconds about a median, as timings are: a floor, and now and then an outlier."""
    rng = np.random.default_rng(seed)
    samples = median * (1.0 + noise * rng.standard_normal(turns))
    samples[rng.integers(turns)] *= 3.0
    return samples.tolist()  # type: ignore[no-any-return]


def row(method: str, seconds: Sequence[float] = (0.001, 0.001, 0.001), wrong: int = 0, **others: Any) -> Row:
    """Make a row of the case ``box/64x64/scene`` whose one stage is ``render``."""
    scene = others.pop("scene", "box")
    head: dict[str, Any] = {
        "id": f"{scene}/64x64/scene/{method}",
        "scene": scene,
        "width": 64,
        "height": 64,
        "cull": "scene",
        "method": method,
        "faces": 6,
        "triangles": 12,
        "hashes": {"scene": "5ce0e"},
    }
    if "absent" in others:
        return Row(**head | others)
    causes = {"vertex snapping": wrong} if wrong else {}
    depth = DepthOff(samples=4, max=0.5, median=0.25, max_ulp=8.0, median_ulp=2.0)
    facts: dict[str, Any] = {
        "threads": 2,
        "warm_up": 3.0,
        "times": {"render": timing(seconds), "total": timing(seconds)},
        "verdict": Verdict(
            wrong=wrong, ties=1, clusters=1, largest_cluster=wrong, causes=causes, depth=depth
        ),
        "work": {"spans": 7},
        "buffer_bytes": 64 * 64 * 12,
        "foreign_load": 0.0,
        "yardstick": 0.3,
    }
    return Row(**head | facts | others)


def results(*rows: Row, **others: Any) -> Results:
    """Put rows into a run."""
    told: dict[str, Any] = {"date": "2026-01-02T03:04:05+00:00", "commit": "abc1234", "machine": MACHINE}
    return Results(hsr=1, kind="bench", repeat=3, rows=rows, **told | others)
