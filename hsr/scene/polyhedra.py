"""Whether corners and faces make a convex polyhedron.

Corners such as (1 + sqrt 5) / 2 are rounded, so the corners of a face are only nearly in one plane.
What is asked is whether true corners within the rounding of the given ones would make a convex
polyhedron; the bounds below are of first order in that rounding.

Let every coordinate be off by at most ``ROUNDINGS u M``, with u = 2^-53 and M the largest absolute
coordinate; then every corner is off by at most ``delta = sqrt(3) ROUNDINGS u M``. For a face with the
corners p_i, the perimeter P and the area A, Newell's normal ``N = sum of p_i x p_(i+1)`` has the
length 2 A and is off by at most ``sum of delta |p_(i+1) - p_(i-1)| <= 2 delta P``: the plane leans by
at most ``delta P / A``. It goes through the mean of the corners, which is off by at most delta. A
corner at the distance D from that mean is therefore measured at most

    slack(D) = delta (2 + D P / A)

wrong in its distance from the plane. Source of the normal: Tampieri, Newell's Method for Computing
the Plane Equation of a Polygon, Graphics Gems III (1992).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from hsr.base.arrays import Floats

ROUNDINGS = 16
"""Roundings that a coordinate may have gone through before it was written down."""


def convexity_problems(vertices: Floats, faces: Sequence[Sequence[int]]) -> list[str]:
    """Say what keeps corners and faces from being a convex polyhedron.

    Parameters
    ----------
    vertices : (V, 3) float64
    faces : sequence of sequences of int
        Vertex indices of each face, which should be counter-clockwise as seen from outside.

    Returns
    -------
    list of str
        At most one line a face, ``faces[3]: ...``, then what concerns the whole; empty if all faces
        are planar, convex and outward, and the surface is closed. Neighbouring faces may be coplanar.
    """
    delta = np.sqrt(3.0) * ROUNDINGS * 2.0**-53 * float(np.abs(vertices).max())
    found = [(k, _face_problem(vertices, face, delta)) for k, face in enumerate(faces)]
    problems = [f"faces[{k}]: {problem}" for k, problem in found if problem]
    return problems or _edge_problems(faces) or _unused(len(vertices), faces)


def _face_problem(vertices: Floats, face: Sequence[int], delta: float) -> str:
    """Say what is wrong with one face, or nothing."""
    if len(set(face)) < len(face):
        return "it names a vertex twice"
    corners = vertices[list(face)]
    mean = corners.mean(axis=0)
    arms = corners - mean
    edges = np.roll(corners, -1, axis=0) - corners
    if not edges.any(axis=1).all():
        return "two neighbouring corners are in one place"
    newell = np.cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)
    perimeter, area = np.linalg.norm(edges, axis=1).sum(), np.linalg.norm(newell) / 2.0
    if area <= delta * perimeter:
        return "it has no area: its corners lie on one line, or it crosses itself"

    normal = newell / (2.0 * area)
    height = (vertices - mean) @ normal
    slack = delta * (2.0 + np.linalg.norm(vertices - mean, axis=1) * perimeter / area)
    own = np.abs(height[list(face)]) - slack[list(face)]
    if own.max() > 0.0:
        worst = face[int(np.argmax(own))]
        return f"its corners are not in one plane: vertex {worst} is off by {abs(height[worst]):.3g}"
    if not _is_convex(corners, edges, normal, delta):
        return "its corners do not run once around a convex polygon"
    if (height <= slack).all():
        return ""
    if (height >= -slack).all():
        return "its corners run clockwise as seen from outside; reverse them"
    return f"vertex {int(np.argmax(height - slack))} is in front of it: the solid is not convex"


def _is_convex(corners: Floats, edges: Floats, normal: Floats, delta: float) -> bool:
    """Whether every corner lies to the left of every edge, seen against the normal.

    The distance from an edge of length L to a corner at distance D from the edge's start is off by at
    most ``delta (2 + 2 D / L)``: both ends of the edge, its start and the corner may move by delta.
    """
    length = np.linalg.norm(edges, axis=1)[:, None]
    inward = np.cross(normal, edges / length)
    arms = corners - corners[:, None]
    slack = delta * (2.0 + 2.0 * np.linalg.norm(arms, axis=2) / length)
    return not (np.vecdot(arms, inward[:, None]) < -slack).any()


def _edge_problems(faces: Sequence[Sequence[int]]) -> list[str]:
    """Ask that every edge be run through exactly once in each direction: the surface is closed."""
    edges = Counter(edge for face in faces for edge in zip(face, [*face[1:], face[0]], strict=True))
    for (a, b), times in edges.items():
        if times > 1:
            return [f"faces: {times} faces run along the edge from vertex {a} to {b}; one may"]
        if (b, a) not in edges:
            return [f"faces: the solid is not closed: no face runs along the edge from vertex {b} to {a}"]
    return []


def _unused(count: int, faces: Sequence[Sequence[int]]) -> list[str]:
    unused = sorted(set(range(count)) - {index for face in faces for index in face})
    return [f"vertices: no face uses vertex {unused[0]}; leave it out"] if unused else []
