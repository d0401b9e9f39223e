"""Whether the faces of a mesh bound a solid, decided exactly.

Removing the back faces of an object changes nothing that is seen from outside if its surface is
closed, outward, and does not touch itself: every line of sight then enters the solid through a front
face before it leaves through a back face.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from hsr.base.arrays import Array, Bools, Floats
from hsr.scene.shapes import Polygons

MAX_CHECKED = 25_000
"""Meshes of more triangles are not searched for places where they touch or cross themselves."""

Turn = Callable[[Array, Array, Array], Array]

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
    return _boundary(triangles) or _inward(points, triangles) or _self_contact(points, triangles, face)


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


def _edges(triangles: Array) -> tuple[Array, Array]:
    """Return the edges (3 n, 2), lower vertex first, and the direction (3 n,) +1 or -1 each is run in."""
    directed = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    return np.sort(directed, axis=1), np.where(directed[:, 0] < directed[:, 1], 1, -1)


def _boundary(triangles: Array) -> str:
    """Ask that every edge be run through as often one way as the other."""
    edges, direction = _edges(triangles)
    _, index, times = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    surplus = np.bincount(index.reshape(-1), weights=direction) != 0.0
    if not surplus.any():
        return ""
    lone = int((times[surplus] == 1).sum())
    if lone:
        return f"not closed: {lone} edges belong to one face only"
    return f"not closed: {int(surplus.sum())} edges are not run through equally often both ways"


# ---------------------------------------------------------------- outward


def _integers(points: Floats) -> Array:
    """Return the coordinates, all scaled by one power of two, as Python integers."""
    mantissa, exponent = np.frexp(points)
    exponent = exponent - exponent.min()
    whole = np.ldexp(mantissa, 53).astype(np.int64).astype(object)
    return np.asarray(whole * (np.full(points.shape, 2, dtype=object) ** exponent))


def _determinant(a: Array, b: Array, c: Array) -> Array:
    """Return det(a, b, c) of vectors (n, 3), in whatever arithmetic their entries have."""
    return np.asarray(
        a[:, 0] * (b[:, 1] * c[:, 2] - b[:, 2] * c[:, 1])
        + a[:, 1] * (b[:, 2] * c[:, 0] - b[:, 0] * c[:, 2])
        + a[:, 2] * (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0])
    )


def _inward(points: Floats, triangles: Array) -> str:
    """Ask that every part of the surface that hangs together by edges enclose a positive volume."""
    part = _parts(triangles)
    order = np.argsort(part, kind="stable")
    a, b, c = _integers(points)[triangles[order].T]
    starts = np.searchsorted(part[order], np.arange(part.max() + 1))
    volumes = np.add.reduceat(_determinant(a, b, c), starts)
    wrong = int((volumes <= 0).sum())
    return f"inside out: {wrong} of its {len(volumes)} parts enclose no positive volume" if wrong else ""


def _parts(triangles: Array) -> Array:
    """Return the number (n,) of the part each triangle belongs to."""
    edges, _ = _edges(triangles)
    _, index = np.unique(edges, axis=0, return_inverse=True)
    count = len(triangles)
    owner = np.repeat(np.arange(count), 3)
    size = count + len(edges)
    graph = coo_array((np.ones(len(owner), np.int8), (owner, count + index.reshape(-1))), shape=(size, size))
    labels = connected_components(graph, directed=False)[1][:count]
    return np.asarray(np.unique(labels, return_inverse=True)[1])


# ---------------------------------------------------------------- self-contact


def _self_contact(points: Floats, triangles: Array, face: Array) -> str:
    """Ask that triangles meet only in the corners and edges they share."""
    if len(triangles) > MAX_CHECKED:
        return f"not checked: more than {MAX_CHECKED} triangles to search for self-contact"
    points = points / 2.0 ** np.frexp(np.abs(points).max())[1]
    space = _Space(points, _integers(points))
    kept = space.has_area(triangles)
    triangles, face = triangles[kept], face[kept]
    for first, second in _near_pairs(points[triangles]):
        meets = _meet(space, triangles[first], triangles[second])
        if meets.any():
            k = int(np.argmax(meets))
            faces = sorted((int(face[first[k]]), int(face[second[k]])))
            return f"touches or crosses itself: faces {faces[0]} and {faces[1]}"
    return ""


def _near_pairs(corners: Floats) -> Iterator[tuple[Array, Array]]:
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


class _Space:
    """Points with exact orientation tests.

    Parameters
    ----------
    points : (V, 3) float64
        Of absolute value at most 1.
    exact : (V, 3) object
        The same, times a power of two, as integers.
    """

    # Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates,
    # Discrete & Computational Geometry 18 (1997), bound A of orient3d, in units of 2^-53.
    ERROR = (7.0 + 56.0 * 2.0**-53) * 2.0**-53
    # More than the products of numbers up to 2 can lose by underflow.
    UNDERFLOW = 2.0**-1000

    def __init__(self, points: Floats, exact: Array) -> None:
        self.points = points
        self.exact = exact

    def side(self, a: Array, b: Array, c: Array, d: Array) -> Array:
        """Sign (n,) of det(a - d, b - d, c - d), of points given by index."""
        p, q, r = (self.points[k] - self.points[d] for k in (a, b, c))
        determinant = _determinant(p, q, r)
        p, q, r = np.abs(p), np.abs(q), np.abs(r)
        permanent = (
            p[:, 0] * (q[:, 1] * r[:, 2] + q[:, 2] * r[:, 1])
            + p[:, 1] * (q[:, 2] * r[:, 0] + q[:, 0] * r[:, 2])
            + p[:, 2] * (q[:, 0] * r[:, 1] + q[:, 1] * r[:, 0])
        )
        sign = np.sign(determinant).astype(np.int8)
        doubtful = np.abs(determinant) <= self.ERROR * permanent + self.UNDERFLOW
        doubtful &= (a != d) & (b != d) & (c != d)
        a, b, c, d = (k[doubtful] for k in (a, b, c, d))
        origin = self.exact[d]
        exactly = _determinant(self.exact[a] - origin, self.exact[b] - origin, self.exact[c] - origin)
        sign[doubtful] = np.sign(exactly).astype(np.int8)
        return sign

    def normal(self, triangles: Array) -> Array:
        """Exact normals (n, 3) of triangles, of any length."""
        a, b, c = self.exact[triangles.T]
        p, q = b - a, c - a
        return np.stack([_cross(p, q, k) for k in range(3)], axis=1)

    def has_area(self, triangles: Array) -> Bools:
        """Whether the corners of each triangle are not on one line."""
        return np.asarray((self.normal(triangles) != 0).any(axis=1), dtype=np.bool_)


def _cross(p: Array, q: Array, axis: int | Array) -> Array:
    """Component ``axis`` of the cross products of vectors (n, 3)."""
    row, i, j = np.arange(len(p)), (np.asarray(axis) + 1) % 3, (np.asarray(axis) + 2) % 3
    return np.asarray(p[row, i] * q[row, j] - p[row, j] * q[row, i])


def _meet(space: _Space, one: Array, other: Array) -> Bools:
    """Whether triangles (n, 3) meet outside their common corners and edges."""
    shared = one[:, :, None] == other[:, None, :]
    in_other, in_one = shared.any(axis=2), shared.any(axis=1)
    one_side, other_side = _sides(space, other, one), _sides(space, one, other)

    # With all corners that are not shared strictly on one side, they meet in shared ones at most.
    apart = _one_sided(one_side, in_other) | _one_sided(other_side, in_one)
    flat = (one_side == 0).all(axis=1)
    meets = np.zeros(len(one), dtype=np.bool_)
    solid = np.flatnonzero(~apart & ~flat)
    meets[solid] = _cross_in_space(space, one[solid], other[solid], in_other[solid], one_side[solid])
    meets[solid] |= _cross_in_space(space, other[solid], one[solid], in_one[solid], other_side[solid])
    plane = np.flatnonzero(flat)
    meets[plane] = _overlap_in_plane(space, one[plane], other[plane], in_other[plane], in_one[plane])
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
    meets = np.zeros(len(one), dtype=np.bool_)
    for k in range(3):
        m = (k + 1) % 3
        opposite = side[:, k] * side[:, m] <= 0
        in_plane = (side[:, k] == 0) & (side[:, m] == 0)
        here = np.flatnonzero(opposite & ~in_plane & ~shared[:, k] & ~shared[:, m])
        p, q, triangle = one[here, k], one[here, m], other[here]
        turns = [space.side(p, q, triangle[:, n], triangle[:, (n + 1) % 3]) for n in range(3)]
        around = np.stack(turns, axis=1)
        meets[here] |= (around >= 0).all(axis=1) | (around <= 0).all(axis=1)
    return meets


def _overlap_in_plane(space: _Space, one: Array, other: Array, in_other: Bools, in_one: Bools) -> Bools:
    """Whether triangles of one plane meet outside what they share; all of it in integers."""
    normal = space.normal(one)
    axis = np.argmax(np.abs(normal), axis=1)
    flip = np.where(np.take_along_axis(normal, axis[:, None], axis=1)[:, 0] > 0, 1, -1)

    def turn(a: Array, b: Array, c: Array) -> Array:
        """Sign of the turn from a over b to c, counter-clockwise positive in the orientation of ``one``."""
        p, q, r = (space.exact[k] for k in (a, b, c))
        return np.sign(_cross(q - p, r - p, axis)).astype(np.int8) * flip

    same_turn = turn(other[:, 0], other[:, 1], other[:, 2])[:, None] > 0
    counter_clockwise = np.where(same_turn, other, other[:, ::-1])
    in_one = np.where(same_turn, in_one, in_one[:, ::-1])
    count = in_other.sum(axis=1)
    meets = _edge_meets(turn, one, in_other, counter_clockwise)
    meets |= _edge_meets(turn, counter_clockwise, in_one, one)
    meets |= count == 3

    # Two triangles on one edge overlap if their third corners are on the same side of it.
    third = counter_clockwise[np.arange(len(one)), np.argmin(in_one, axis=1)]
    for k in range(3):
        m = (k + 1) % 3
        on_edge = (count == 2) & in_other[:, k] & in_other[:, m]
        meets |= on_edge & (turn(one[:, k], one[:, m], third) > 0)
    return meets


def _edge_meets(turn: Turn, one: Array, shared: Bools, other: Array) -> Bools:
    """Whether an edge of ``one`` without shared corners meets ``other``, both in one plane.

    ``other`` runs counter-clockwise. A segment and a triangle are apart if and only if the line
    through one of their edges separates them.
    """
    meets = np.zeros(len(one), dtype=np.bool_)
    for k in range(3):
        p, q = one[:, k], one[:, (k + 1) % 3]
        corners = np.stack([turn(p, q, other[:, n]) for n in range(3)], axis=1)
        apart = (corners > 0).all(axis=1) | (corners < 0).all(axis=1)
        for n in range(3):
            start, end = other[:, n], other[:, (n + 1) % 3]
            apart |= (turn(start, end, p) < 0) & (turn(start, end, q) < 0)
        meets |= ~apart & ~shared[:, k] & ~shared[:, (k + 1) % 3]
    return meets
