"""More and more edges, each moved by so little that only chance lets one of them pass over a sample.

Where the first one does is expected, not certain, hence the larger factor of most verdicts. Rounding both
ends of an edge to a grid of 2^-b pixels moves it by ``2^-(b+2)`` pixels on average.
"""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import closed_fan, flat, grid, mesh, panel, parallel, scene_of
from hsr.lab.stability.family import Variant, hard_case, octaves, variants
from hsr.scene.model import Scene


def spokes_of(bits: int, side: int) -> float:
    """Return the spokes at which snapping is expected to cost the first sample.

    Each end that moves sweeps over a triangle: a spoke of W / 2 pixels sweeps over ``2^-(b+3) W`` samples.
    """
    return 2.0 ** (bits + 3) / side


def fewest(side: int) -> float:
    """Return those of a grid of 4 bits, but no fewer than the sweep has."""
    return max(4.0, spokes_of(4, side))


@hard_case("coverage", "number of spokes", octaves(2, 13), continuous=False)
@variants(
    Variant("scanline-snap-4", fewest, "2^(b+3) / W spokes, but no fewer than the sweep has"),
    Variant("scanline-snap-8", lambda side: spokes_of(8, side), "2^(b+3) / W spokes", 4.0),
    Variant("opengl", lambda side: spokes_of(8, side), "2^(b+3) / W spokes", 4.0),
    Variant("scanline-direct", lambda side: spokes_of(50, side), "2^(b+3) / W, with b = 50"),
)
def fan(spokes: float, side: int) -> Scene:
    """Fill a disc, of which the middle lies near that of the picture, by a closed fan.

    A disc is a fan of triangles about one corner. Every sample in it has exactly one owner, however thin the
    triangles are. Snapping moves each spoke by a fraction of a pixel: no sample is lost, but the more spokes
    there are, the more samples lie between a spoke and where it was moved to.

    Truth: Within the disc the triangle whose angle holds the sample, the background outside.

    Source: The OpenGL Graphics System, 3.6.1: polygons that share an edge produce each fragment once
    """
    k, random = np.arange(int(spokes)), np.random.default_rng(int(spokes))
    angle = (k + random.uniform(0.2, 0.8, len(k))) * (2.0 * np.pi / len(k))
    rim = 0.49 * side * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return scene_of(parallel(side), mesh(flat([[0.1, 0.2], *rim]), closed_fan(len(k))))


@hard_case("order", "number of slats each way", octaves(1, 9), continuous=False)
# 4 k edges are moved by 2^-(b+2): each passes a column or line of samples with that probability.
@variants(
    Variant("scanline-snap-4", 2.0**4, "2^b slats", 4.0),
    Variant("scanline-snap-8", 2.0**8, "2^b slats", 4.0),
    Variant("opengl", 2.0**8, "2^b slats", 4.0),
)
def slats(count: float, side: int) -> Scene:
    """Hang as many upright slats before as many level ones; slats and gaps are equally wide.

    k upright slats hang before k level ones, so that k + k (k + 1) pieces are seen: as many as the square of
    the number of faces, the most there can be. The more edges there are, the more of them pass so close to a
    line of samples that snapping carries them over it.

    Truth: An upright slat, else a level one, else the background.

    Source: M. McKenna, Worst-Case Optimal Hidden-Surface Removal (ACM Transactions on Graphics 6, 1987)
    """
    k, pitch, end = int(count), side / count, 0.5 * side
    start = -end + (np.arange(k) + np.random.default_rng(k).uniform(0.3, 0.8, k)) * pitch
    upright = [panel((a, a + 0.5 * pitch), (-end, end), 1.0) for a in start.tolist()]
    level = [panel((-end, end), (a, a + 0.5 * pitch), 1.5) for a in start.tolist()]
    return scene_of(parallel(side), *upright, *level)


def pitch_of(bits: int, side: int) -> float:
    """Return the pitch at which snapping is expected to cost the first sample.

    There are ``2 + sqrt(2)`` pixels of edge to a square of a pixel over the pitch, over a quarter of the
    picture's ``W^2`` samples.
    """
    return side * side / 4.0 * 3.4 * 2.0 ** -(bits + 2)


@hard_case("coverage", "pitch of the mesh, in pixels", octaves(4, -2))
@variants(
    Variant("scanline-snap-4", 16.0, "0.85 W^2 2^-(b+2) px, beyond the start of the sweep"),
    Variant("scanline-snap-8", lambda side: pitch_of(8, side), "0.85 W^2 2^-(b+2) px", 4.0),
    Variant("opengl", lambda side: pitch_of(8, side), "0.85 W^2 2^-(b+2) px", 4.0),
    Variant("scanline-direct", None, "0.85 W^2 2^-(b+2) px with b = 45: beyond the end"),
)
def sub_pixel_mesh(pitch: float, side: int) -> Scene:
    """Cover half the picture's width by a wavy mesh, its corners moved at random by a quarter pitch.

    A wavy mesh is divided ever more finely, until there are many triangles to a sample. Every sample within
    its outline has exactly one owner. Snapping moves shared corners for all their triangles at once, so no
    hole opens; but the shorter the edges, the more of them there are to pass over a sample.

    Truth: One triangle of the mesh at every sample within its outline.

    Source: The OpenGL Graphics System, 3.6.1: polygons that share an edge produce each fragment once
    """
    count = max(3, round(0.5 * side / pitch) + 1)
    line = np.linspace(-0.25 * side, 0.25 * side, count)
    moved = np.random.default_rng(count).uniform(-0.25, 0.25, (2, count, count)) * (line[1] - line[0])
    x, y = np.stack(np.meshgrid(line, line)) + moved
    vertices = np.stack([x, y, -1.0 + 0.1 * np.sin(0.3 * x) * np.cos(0.2 * y)], axis=2).reshape(-1, 3)
    return scene_of(parallel(side), mesh(vertices, grid(count, count), cull="back"))
