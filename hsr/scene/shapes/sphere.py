"""The sphere of radius 1 about the origin: x^2 + y^2 + z^2 = 1."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from hsr.base.arrays import Floats
from hsr.scene.shapes.polygons import Polygons
from hsr.scene.shapes.shape import Kind, Quadric, Shape, arcs, circle

FORM = np.diag(np.array([1, 1, 1, -1], object))
ENDS = np.empty((0, 4), object)


def shape() -> Shape:
    """Make the sphere; it is one face."""
    quadric = Quadric(FORM, ENDS, reach, horizon, polygons)
    return Shape(Kind.SPHERE, "sphere", None, ("sphere",), quadric=quadric)


def reach(row: Floats) -> tuple[float, float]:
    """See :class:`Quadric`."""
    radius = math.hypot(*row[:3])
    return float(row[3] - radius), float(row[3] + radius)


def horizon(eye: Floats) -> Iterator[tuple[set[int], Floats]]:
    """Yield the circle in which lines of sight touch the sphere: p . (x, y, z) = w and |p| = 1.

    None from inside.
    """
    e, w = eye[:3], eye[3]
    distance = np.linalg.norm(e)
    if abs(w) < distance:
        axis, height = e / distance, w / distance
        u = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
        u *= np.sqrt(1.0 - height**2) / np.linalg.norm(u)
        yield {0}, arcs(height * axis, u, np.cross(axis, u))


def polygons(segments: int) -> Polygons:
    """Cut the sphere into meridians and half as many circles of latitude."""
    rings = max(segments // 2, 2)
    latitude = np.pi * np.arange(1, rings) / rings
    ring = np.sin(latitude)[:, None, None] * circle(segments)
    height = np.broadcast_to(np.cos(latitude)[:, None, None], (rings - 1, segments, 1))
    body = np.concatenate([ring, height], axis=2).reshape(-1, 3)
    vertices = np.concatenate([[[0.0, 0.0, 1.0]], body, [[0.0, 0.0, -1.0]]])
    south = len(vertices) - 1

    loops: list[tuple[int, int, int]] = []
    for j in range(segments):
        k = (j + 1) % segments
        loops.append((0, 1 + j, 1 + k))
        for i in range(rings - 2):
            upper, lower = 1 + i * segments, 1 + (i + 1) * segments
            loops += [(upper + j, lower + j, lower + k), (upper + j, lower + k, upper + k)]
        last = 1 + (rings - 2) * segments
        loops.append((last + j, south, last + k))
    return Polygons.of(vertices, loops, [0] * len(loops))
