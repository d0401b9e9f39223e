"""Whether the faces of a mesh bound a solid, decided exactly.

Removing the back faces of an object changes nothing that is seen from outside if its surface is
closed, outward, and does not touch itself: every line of sight then enters the solid through a front
face before it leaves through a back face.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from hsr.base.arrays import Array, Bools, Floats
from hsr.scene.shapes import Polygons

MAX_CHECKED = 25_000
"""Meshes of more triangles are not searched for places where they touch or cross themselves."""

NEXT = np.array([1, 2, 0])
"""The corner after each corner of a triangle: edge k runs from corner k to corner NEXT[k]."""

CHUNK = 1 << 21
"""Pairs of triangles looked at together, to bound the memory."""


def surface_problem(polygons: Polygons) -> str:
    """Say why the faces of a mesh do not bound a solid.

    Vertices at equal positions count as one; triangles without area count as nothing where the
    surface is searched for self-contact.

    Parameters
    ----------
    polygons : Polygons
        In object space, counter-clockwise as seen from outside.

    Returns
    -------
    str
        ``not closed: ...``, ``inside out: ...``, ``touches or crosses itself: ...``,
        ``not checked: ...``, or nothing if they do.
    """
    points, triangles, face = _welded(polygons)
    if not len(triangles):
        return "not closed: it has no area"
    run = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    _, edge, times = np.unique(np.sort(run, axis=1), axis=0, return_inverse=True, return_counts=True)
    edge, exact = edge.reshape(-1), _integers(points)
    return (
        _boundary(edge, times, np.where(run[:, 0] < run[:, 1], 1, -1))
        or _inward(exact[triangles], edge)
        or _self_contact(points, exact, triangles, face)
    )


def winding_number(point: Floats, triangles: Floats) -> float:
    """Return how often triangles (n, 3, 3) wind around a point (3,): 1 inside a closed surface, 0 outside.

    The sum of their solid angles over 4 pi. Source: Van Oosterom, Strackee, The Solid Angle of a Plane
    Triangle, IEEE Transactions on Biomedical Engineering 30 (1983).
    """
    a, b, c = np.moveaxis(triangles - point, 1, 0)
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    volume = (a * np.cross(b, c)).sum(axis=1)
    ab, bc, ca = ((p * q).sum(axis=1) for p, q in ((a, b), (b, c), (c, a)))
    angle = 2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)
    return float(angle.sum() / (4.0 * np.pi))


def _welded(polygons: Polygons) -> tuple[Floats, Array, Array]:
    """Return the different points, the triangles (n, 3) between them and the face (n,) of each."""
    points, index = np.unique(polygons.vertices, axis=0, return_inverse=True)
    triangles = index.reshape(-1)[polygons.triangle_vertex].astype(np.int64)
    a, b, c = triangles.T
    proper = (a != b) & (b != c) & (c != a)
    return points, triangles[proper], polygons.triangle_face[proper]


# ---------------------------------------------------------------- closed


def _boundary(edge: Array, times: Array, direction: Array) -> str:
    """Ask that every edge be run through as often one way as the other.

    ``edge`` and ``direction`` (3 n,) are the number of the edge that each side of a triangle runs
    along, and +1 or -1 for the way; ``times`` is how many sides run along each edge.
    """
    surplus = np.bincount(edge, weights=direction) != 0.0
    lone = int((times[surplus] == 1).sum())
    if lone:
        return f"not closed: {lone} edges belong to one face only"
    count = int(surplus.sum())
    return f"not closed: {count} edges are not run through equally often both ways" if count else ""


# ---------------------------------------------------------------- outward


def _integers(points: Floats) -> Array:
    """Return the coordinates, all scaled by one power of two, as Python integers."""
    mantissa, exponent = np.frexp(points)
    exponent = exponent - exponent.min()
    whole = np.ldexp(mantissa, 53).astype(np.int64).astype(object)
    return np.asarray(whole * (np.full(points.shape, 2, dtype=object) ** exponent))


def _determinant(a: Array, b: Array, c: Array, minus: int = -1) -> Array:
    """Return det(a, b, c) of vectors (n, 3), in whatever arithmetic their entries have.

    With ``minus=1`` it is the permanent: the same products, all added.
    """
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = a.T, b.T, c.T
    x, y, z = by * cz + minus * bz * cy, bz * cx + minus * bx * cz, bx * cy + minus * by * cx
    return np.asarray(ax * x + ay * y + az * z)


def _inward(corners: Array, edge: Array) -> str:
    """Ask that every part of the surface that hangs together by edges enclose a positive volume."""
    count = len(corners)
    links = (np.ones(len(edge), np.int8), (np.repeat(np.arange(count), 3), count + edge))
    size = count + len(edge)
    parts = connected_components(coo_array(links, shape=(size, size)), directed=False)[1][:count]
    volumes = np.zeros(parts.max() + 1, dtype=object)
    np.add.at(volumes, parts, _determinant(*corners.swapaxes(0, 1)))
    wrong = int((volumes <= 0).sum())
    return f"inside out: {wrong} of its {len(volumes)} parts enclose no positive volume" if wrong else ""


# ---------------------------------------------------------------- self-contact


def _self_contact(points: Floats, exact: Array, triangles: Array, face: Array) -> str:
    """Ask that triangles meet only in the corners and edges they share."""
    if len(triangles) > MAX_CHECKED:
        return f"not checked: more than {MAX_CHECKED} triangles to search for self-contact"
    space = _Space(points / 2.0 ** np.frexp(np.abs(points).max())[1], exact)
    kept = (space.normal(triangles) != 0).any(axis=1)
    triangles, face = triangles[kept], face[kept]
    for first, second in _overlapping_pairs(space.points[triangles]):
        meets = _meet(space, triangles[first], triangles[second])
        if meets.any():
            k = int(np.argmax(meets))
            one, other = sorted((int(face[first[k]]), int(face[second[k]])))
            return f"touches or crosses itself: faces {one} and {other}"
    return ""


def _overlapping_pairs(corners: Floats) -> Iterator[tuple[Array, Array]]:
    """Yield pairs of triangles whose extents overlap, by a sweep along the longest axis."""
    low, high = corners.min(axis=1), corners.max(axis=1)
    axis = int(np.argmax(high.max(axis=0) - low.min(axis=0)))
    order = np.argsort(low[:, axis], kind="stable")
    low, high = low[order], high[order]
    count = np.searchsorted(low[:, axis], high[:, axis], side="right") - np.arange(len(low)) - 1
    total = np.cumsum(count)
    for chunk in np.split(np.arange(len(low)), np.searchsorted(total, np.arange(CHUNK, total[-1], CHUNK))):
        first = np.repeat(chunk, count[chunk])
        place = np.arange(len(first)) - np.repeat(np.cumsum(count[chunk]) - count[chunk], count[chunk])
        second = first + 1 + place
        overlap = ((low[first] <= high[second]) & (low[second] <= high[first])).all(axis=1)
        yield order[first[overlap]], order[second[overlap]]


# Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates,
# Discrete & Computational Geometry 18 (1997), bound A of orient3d, in units of 2^-53.
ERROR = (7.0 + 56.0 * 2.0**-53) * 2.0**-53
# More than the products of numbers up to 2 can lose by underflow.
UNDERFLOW = 2.0**-1000


class _Space(NamedTuple):
    """Points with exact orientation tests.

    Attributes
    ----------
    points : (V, 3) float64
        Of absolute value at most 1.
    exact : (V, 3) object
        The same, times a power of two, as integers.
    """

    points: Floats
    exact: Array

    def side(self, a: Array, b: Array, c: Array, d: Array) -> Array:
        """Sign (n,) of det(a - d, b - d, c - d), of points given by index."""
        p, q, r = (self.points[k] - self.points[d] for k in (a, b, c))
        determinant = _determinant(p, q, r)
        permanent = _determinant(np.abs(p), np.abs(q), np.abs(r), minus=1)
        sign = np.sign(determinant).astype(np.int8)
        doubtful = np.abs(determinant) <= ERROR * permanent + UNDERFLOW
        doubtful &= (a != d) & (b != d) & (c != d)
        a, b, c, d = (k[doubtful] for k in (a, b, c, d))
        origin = self.exact[d]
        exactly = _determinant(self.exact[a] - origin, self.exact[b] - origin, self.exact[c] - origin)
        sign[doubtful] = np.sign(exactly).astype(np.int8)
        return sign

    def normal(self, triangles: Array) -> Array:
        """Exact normals (n, 3) of triangles, of any length."""
        a, b, c = self.exact[triangles.T]
        return np.asarray(np.cross(b - a, c - a))


def _meet(space: _Space, one: Array, other: Array) -> Bools:
    """Whether triangles (n, 3) meet outside their common corners and edges."""
    shared = one[:, :, None] == other[:, None, :]
    in_other, in_one = shared.any(axis=2), shared.any(axis=1)
    one_side, other_side = _sides(space, other, one), _sides(space, one, other)

    # With all corners that are not shared strictly on one side, they meet in shared ones at most.
    apart = _one_sided(one_side, in_other) | _one_sided(other_side, in_one)
    flat = (one_side == 0).all(axis=1)
    meets = np.zeros(len(one), dtype=np.bool_)
    rest = np.flatnonzero(~apart & ~flat)
    meets[rest] = _cross_in_space(space, one[rest], other[rest], in_other[rest], one_side[rest])
    meets[rest] |= _cross_in_space(space, other[rest], one[rest], in_one[rest], other_side[rest])
    meets[flat] = _overlap_in_plane(space, one[flat], other[flat], in_other[flat], in_one[flat])
    return meets


def _sides(space: _Space, plane: Array, triangles: Array) -> Array:
    """Side (n, 3) of the plane of one triangle on which the corners of another lie."""
    a, b, c = plane.T
    return np.stack([space.side(a, b, c, triangles[:, k]) for k in range(3)], axis=1)


def _one_sided(side: Array, shared: Bools) -> Bools:
    above, below = (side > 0) | shared, (side < 0) | shared
    return np.asarray((above.all(axis=1) | below.all(axis=1)) & ~shared.all(axis=1))


def _cross_in_space(space: _Space, one: Array, other: Array, shared: Bools, side: Array) -> Bools:
    """Whether an edge of ``one`` without shared corners passes through ``other`` (its boundary included).

    Edges in the plane of ``other`` need no look: where they meet it, another edge of the two does.
    """
    to = side[:, NEXT]
    crossing = (side * to <= 0) & ((side != 0) | (to != 0)) & ~shared & ~shared[:, NEXT]
    pair, k = np.nonzero(crossing)
    p, q, triangle = one[pair, k], one[pair, NEXT[k]], other[pair]
    around = np.stack([space.side(p, q, triangle[:, n], triangle[:, NEXT[n]]) for n in range(3)], axis=1)
    meets = np.zeros(len(one), dtype=np.bool_)
    meets[pair[(around >= 0).all(axis=1) | (around <= 0).all(axis=1)]] = True
    return meets


def _overlap_in_plane(space: _Space, one: Array, other: Array, in_other: Bools, in_one: Bools) -> Bools:
    """Whether triangles of one plane meet outside what they share; all of it in integers."""
    # Drop the coordinate along which the plane is seen largest.
    dropped = np.argmax(np.abs(space.normal(one)), axis=1)
    axes = (dropped[:, None, None] + [1, 2]) % 3
    flat_one, flat_other = (np.take_along_axis(space.exact[each], axes, axis=2) for each in (one, other))
    from_one, from_other = _turns(flat_one, flat_other), _turns(flat_other, flat_one)

    count = in_other.sum(axis=1)
    meets = count == 3
    meets |= _edge_meets(from_one, from_other, in_other) | _edge_meets(from_other, from_one, in_one)
    # Two triangles on one edge overlap if their third corners are on the same side of it.
    third = np.argmin(in_one, axis=1)[:, None, None]
    same_side = np.take_along_axis(from_one, third, axis=2)[:, :, 0] > 0
    on_edge = (count == 2)[:, None] & in_other & in_other[:, NEXT]
    return np.asarray(meets | (on_edge & same_side).any(axis=1))


def _turns(triangle: Array, points: Array) -> Array:
    """Tell on which side of each edge of plane triangles (n, 3, 2) the points (n, 3, 2) lie.

    The result (n, 3, 3), edge by point, is +1 on the side of the triangle, -1 beyond, 0 on the line.
    """
    x, y = np.moveaxis(triangle[:, NEXT] - triangle, 2, 0)[..., None]
    seen = np.concatenate([triangle[:, 2:], points], axis=1)
    u, v = np.moveaxis(seen[:, None] - triangle[:, :, None], 3, 0)
    turns = np.sign(x * v - y * u).astype(np.int8)
    return np.asarray(turns[:, :, 1:] * turns[:, :1, :1])


def _edge_meets(own: Array, others: Array, shared: Bools) -> Bools:
    """Whether an edge without shared corners meets the other triangle of its plane.

    ``own`` tells where the corners of the other lie, seen from the edges; ``others`` where the ends of
    the edges lie, seen from the edges of the other. A segment and a triangle are apart if and only if
    the line through one of their edges separates them.
    """
    apart = (own > 0).all(axis=2) | (own < 0).all(axis=2)
    apart |= ((others < 0) & (others[:, :, NEXT] < 0)).any(axis=1)
    return np.asarray((~apart & ~shared & ~shared[:, NEXT]).any(axis=1))
