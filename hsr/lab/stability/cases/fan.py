"""A fan about one corner, of ever more spokes."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import mesh, parallel, powers_of_two, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.scene.model import Scene


def scene(spokes: float, side: int) -> Scene:
    """Fill a disc, of which the middle lies near that of the picture, by a closed fan."""
    k, random = np.arange(int(spokes)), np.random.default_rng(int(spokes))
    angle = (k + random.uniform(0.2, 0.8, len(k))) * (2.0 * np.pi / len(k))
    rim = 0.49 * side * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    triangles = np.stack([0 * k, k + 1, (k + 1) % len(k) + 1], axis=1)
    vertices = np.insert(np.concatenate([[[0.1, 0.2]], rim]), 2, -1.0, axis=1)
    return scene_of(parallel(side), mesh(vertices, triangles))


def first_wrong(bits: int, side: int) -> float:
    """Return the spokes at which snapping is expected to cost the first sample.

    Where it does is chance, hence the larger factor of the verdicts.

    Both ends of a spoke move by ``2^-(b+2)`` pixels on average across it, which sweeps over a triangle each:
    a spoke of W / 2 pixels sweeps over ``2^-(b+3) W`` samples.
    """
    return 2.0 ** (bits + 3) / side


FAMILY = Family(
    name="fan",
    group="coverage",
    story=(
        "A disc is a fan of triangles about one corner. Every sample in it has exactly one owner, however "
        "thin the triangles are. Snapping moves each spoke by a fraction of a pixel: no sample is lost, but "
        "the more spokes there are, the more samples lie between a spoke and where it was moved to."
    ),
    expected="Within the disc the triangle whose angle holds the sample, the background outside.",
    source="The OpenGL Graphics System, 3.6.1: polygons that share an edge produce each fragment once",
    parameter="number of spokes",
    sweep=powers_of_two(2, 13),
    continuous=False,
    scene=scene,
    variants=(
        Variant(
            "scanline-snap-4",
            lambda side: max(4.0, first_wrong(4, side)),
            "2^(b+3) / W spokes, but no fewer than the sweep has",
        ),
        Variant("scanline-snap-8", lambda side: first_wrong(8, side), "2^(b+3) / W spokes", 4.0),
        Variant("opengl", lambda side: first_wrong(8, side), "2^(b+3) / W spokes", 4.0),
        Variant("scanline-direct", lambda side: first_wrong(50, side), "2^(b+3) / W, with b = 50"),
    ),
)
