"""The sphere of radius 1 about the origin: x^2 + y^2 + z^2 = 1."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hsr.base.arrays import Floats
from hsr.scene.shapes.lattice import halves, proper, wrapped
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
    around = np.repeat(np.sin(latitude), segments)[:, None] * np.tile(circle(segments), (rings - 1, 1))
    body = np.column_stack([around, np.repeat(np.cos(latitude), segments)])
    vertices = np.concatenate([[[0.0, 0.0, 1.0]], body, [[0.0, 0.0, -1.0]]])

    # A meridian is a row of the lattice, from pole to pole.
    south = len(vertices) - 1
    meridians = wrapped(np.arange(1, south).reshape(rings - 1, segments)).T
    triangles = proper(halves(np.pad(meridians, ((0, 0), (1, 1)), constant_values=(0, south))))
    return replace(Polygons.of_rows(vertices, triangles), face=np.zeros(len(triangles), np.int32))
