"""Lattices of vertices, and the triangles into which their cells are cut."""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array


def wrapped(index: Array) -> Array:
    """Repeat the first column of a lattice of vertex indices after its last: close every row."""
    return np.pad(index, ((0, 0), (0, 1)), mode="wrap")


def proper(triangles: Array) -> Array:
    """Leave out triangles (n, 3) that name a vertex twice."""
    a, b, c = triangles.T
    return np.asarray(triangles[(a != b) & (b != c) & (c != a)])


def halves(index: Array) -> Array:
    """Cut the cells of lattices (..., rows, columns) of vertex indices into two triangles each.

    Seen with the columns running to the right and the rows up, the triangles (n, 3) are
    counter-clockwise.
    """
    a, b = index[..., :-1, :-1], index[..., :-1, 1:]
    d, c = index[..., 1:, :-1], index[..., 1:, 1:]
    return np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
