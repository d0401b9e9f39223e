"""Upright slats before level slats, ever more of them."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import panel, parallel, powers_of_two, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.scene.model import Scene


def scene(count: float, side: int) -> Scene:
    """Hang as many upright slats before as many level ones; slats and gaps are equally wide."""
    k, pitch, end = int(count), side / count, 0.5 * side
    start = -end + (np.arange(k) + np.random.default_rng(k).uniform(0.3, 0.8, k)) * pitch
    upright = [panel((a, a + 0.5 * pitch), (-end, end), 1.0) for a in start.tolist()]
    level = [panel((-end, end), (a, a + 0.5 * pitch), 1.5) for a in start.tolist()]
    return scene_of(parallel(side), *upright, *level)


def first_wrong(bits: int) -> float:
    """Return the slats at which snapping is expected to cost the first column of samples.

    Where it does is chance, hence the larger factor of the verdicts.

    There are 4 k edges, each moved by ``2^-(b+2)`` pixels on average: that is the probability that it passes
    over a column or line of samples.
    """
    return 2.0**bits


FAMILY = Family(
    name="slats",
    group="order",
    story=(
        "k upright slats hang before k level ones, so that k + k (k + 1) pieces are seen: as many as the "
        "square of the number of faces, the most there can be. The more edges there are, the more of them "
        "pass so close to a line of samples that snapping carries them over it."
    ),
    expected="An upright slat, else a level one, else the background.",
    source="M. McKenna, Worst-Case Optimal Hidden-Surface Removal (ACM Transactions on Graphics 6, 1987)",
    parameter="number of slats each way",
    sweep=powers_of_two(1, 9),
    continuous=False,
    scene=scene,
    variants=(
        Variant("scanline-snap-4", first_wrong(4), "2^b slats", 4.0),
        Variant("scanline-snap-8", first_wrong(8), "2^b slats", 4.0),
        Variant("opengl", first_wrong(8), "2^b slats", 4.0),
    ),
)
