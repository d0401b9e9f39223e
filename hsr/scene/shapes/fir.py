"""A fir tree: a trunk and jagged cones."""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Floats, Ints
from hsr.scene.shapes.lattice import halves, wrapped
from hsr.scene.shapes.polygons import Polygons

# Lengths for a tree of height 1.
TRUNK_SIDES = 8
TRUNK_RADIUS = 0.03
LOWEST_BOUGH = 0.12
WIDEST_BOUGH = 0.3


def polygons(tiers: int, sides: int) -> Polygons:
    """Grow a fir of height 1 on the origin: a trunk, and above it overlapping jagged cones.

    A cone is as high as two steps from one cone to the next, and as wide as a straight line from
    the lowest bough to the top of the tree allows.

    Parameters
    ----------
    tiers : int
        Number of cones.
    sides : int
        Number of tips around the rim of a cone.

    Returns
    -------
    Polygons
        ``8 tiers sides + 28`` triangles; the trunk and every cone are closed by themselves.
    """
    step = (1.0 - LOWEST_BOUGH) / (tiers + 1)
    rims = [(LOWEST_BOUGH + k * step, WIDEST_BOUGH * (1.0 - k / (tiers + 1))) for k in range(tiers)]
    parts = [_trunk(LOWEST_BOUGH + step), *(_cone(rim, reach, step, sides) for rim, reach in rims)]
    first = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    triangles = [own + offset for (_, own), offset in zip(parts, first[:-1], strict=True)]
    vertices = np.concatenate([vertices for vertices, _ in parts])
    return Polygons.of_rows(vertices, np.concatenate(triangles))


def _trunk(top: float) -> tuple[Floats, Ints]:
    """Vertices and triangles of a prism on the ground, its base and cap fans about a corner."""
    index = np.arange(2 * TRUNK_SIDES, dtype=np.int32).reshape(2, TRUNK_SIDES)
    vertices = np.concatenate([_ring(TRUNK_SIDES, TRUNK_RADIUS, y) for y in (0.0, top)])
    base, cap = index[0, ::-1], index[1]
    fans = [np.stack([0 * ring[2:] + ring[0], ring[1:-1], ring[2:]], axis=1) for ring in (base, cap)]
    return vertices, np.concatenate([halves(wrapped(index)), *fans])


def _cone(rim: float, reach: float, step: float, sides: int) -> tuple[Floats, Ints]:
    """Vertices and triangles of a cone whose rim at height ``rim`` alternates tips and notches."""
    tip = np.arange(2 * sides) % 2 == 0
    jagged = _ring(2 * sides, np.where(tip, reach, 0.7 * reach), np.where(tip, rim, rim + 0.2 * step))
    waist = _ring(2 * sides, 0.4 * reach, rim + 0.8 * step)
    poles = np.array([[0.0, rim + 2.0 * step, 0.0], [0.0, rim + 0.3 * step, 0.0]])
    index = np.arange(4 * sides, dtype=np.int32).reshape(2, 2 * sides)
    top, below = 4 * sides, 4 * sides + 1
    triangles = [halves(wrapped(index)), _fan(top, index[1]), _fan(below, index[0, ::-1])]
    return np.concatenate([jagged, waist, poles]), np.concatenate(triangles)


def _ring(count: int, radius: float | Floats, height: float | Floats) -> Floats:
    """Points (count, 3) about the y axis, counter-clockwise seen from above."""
    angle = 2.0 * np.pi * np.arange(count) / count
    return np.stack([radius * np.sin(angle), height + 0.0 * angle, radius * np.cos(angle)], axis=1)


def _fan(pole: int, ring: Ints) -> Ints:
    """Join every side of a closed ring (n,) with one vertex: triangles (n, 3)."""
    return np.stack([ring, np.roll(ring, -1), 0 * ring + pole], axis=1)
