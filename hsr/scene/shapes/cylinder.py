"""The cylinder about the z axis, 0 <= z <= 1, of radius 1 at its base and ``top`` at its cap.

Its side is x^2 + y^2 = (1 + (top - 1) z)^2 (F. S. Hill, S. M. Kelley, *Computer Graphics Using OpenGL*, 3rd
edition, chapter 12, the tapered cylinder). That is a cylinder, or a cone of two nappes, of which the planes
leave one: there the radius is not negative. With ``top`` 0 the cone ends in its apex, which is no face.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from hsr.base.arrays import Floats
from hsr.scene.shapes.polygons import Polygons
from hsr.scene.shapes.shape import Kind, Quadric, Shape, arcs, circle

AXES = np.array([1, 1, 0, 0], object)
ENDS = np.array([[0, 0, 1, 0], [0, 0, -1, 1]], object)
"""Base and cap: z >= 0, and 1 - z >= 0."""


def shape(top: float = 1.0) -> Shape:
    """Make the cylinder; its faces are side, base and, unless ``top`` is 0, cap."""
    above, below = top.as_integer_ratio()
    # The radius at height z, times what makes it whole.
    radius = np.array([0, 0, above - below, below], object)
    form = below**2 * np.diag(AXES) - np.outer(radius, radius)
    names = ("side", "base", "cap") if top else ("side", "base")
    quadric = Quadric(form, ENDS, partial(reach, top), partial(outline, top), partial(polygons, top))
    return Shape(Kind.CYLINDER if top == 1.0 else Kind.QUADRIC, "cylinder", None, names, quadric=quadric)


def reach(top: float, row: Floats) -> tuple[float, float]:
    """See :class:`Quadric`: the solid is the hull of its rims."""
    radius, base, cap = math.hypot(*row[:2]), float(row[3]), float(row[3] + row[2])
    return min(base - radius, cap - top * radius), max(base + radius, cap + top * radius)


def outline(top: float, eye: Floats) -> Iterator[tuple[set[int], Floats]]:
    """Yield the two lines in which lines of sight touch the side, and the rims.

    A line of sight touches the generator of an angle where x cos + y sin = w + (top - 1) z. None does from
    within the endless solid, or along its axis.
    """
    x, y, z, w = eye
    distance, level, across = np.hypot(x, y), w + (top - 1.0) * z, np.eye(3)
    if abs(level) < distance:
        for angle in np.arctan2(y, x) + np.arccos(level / distance) * np.array([1.0, -1.0]):
            foot = np.array([np.cos(angle), np.sin(angle), 0.0])
            yield {0}, np.array([[foot, top * foot + across[2]]])
    yield {0, 1}, arcs(np.zeros(3), across[0], across[1])
    if top:
        yield {0, 2}, arcs(across[2], top * across[0], top * across[1])


def polygons(top: float, segments: int) -> Polygons:
    """Cut the side along generators; at an apex they meet in one corner."""
    rim, around = circle(segments), range(segments)
    base, cap = (np.column_stack([r * rim, np.full(segments, z)]) for r, z in ((1.0, 0.0), (top, 1.0)))
    below = tuple(reversed(around))
    if not top:
        flanks = [(j, (j + 1) % segments, segments) for j in around]
        return Polygons.of(np.concatenate([base, cap[:1]]), [*flanks, below], [0] * segments + [1])
    side = [(j, (j + 1) % segments, segments + (j + 1) % segments, segments + j) for j in around]
    above = tuple(range(segments, 2 * segments))
    return Polygons.of(np.concatenate([base, cap]), [*side, below, above], [0] * segments + [1, 2])
