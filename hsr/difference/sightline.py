"""Lines of sight, decided exactly: every face on them, and those that just miss them.

Only the faces near a sample are looked at, and they are set up in exact numbers once as the view
has them, which gives the owner, and once without culling and clipping, which gives all that lies
there at all. Samples of one view share all that is set up, and flat faces are met by all of them
together; so many cost little more each than what is told of them.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import chain, pairwise

import numpy as np

from hsr.base.arrays import Array, Bools, Ints, ranges
from hsr.difference.nearby import REACH, Nearby, check_sample, faces_nearby
from hsr.exact.decide import Form, Piece
from hsr.exact.depths import depth_quotient
from hsr.exact.infinitesimals import Polynomial, at, beside, coefficients
from hsr.exact.numbers import Frame, frame_of, integers
from hsr.exact.numbers import samples as coordinates
from hsr.exact.oracle import answers
from hsr.exact.planes import Triangles, cross, on_planes, triangles_of
from hsr.exact.quadrics import form, rounds_of
from hsr.problem.map import BACKGROUND
from hsr.problem.view import CULL, Placement, View

FRONT, BACK, EDGE_ON = "front", "back", "edge-on"

CULLED = {CULL["none"]: "", CULL["back"]: BACK, CULL["front"]: FRONT}
"""The side that an object culls."""


@dataclass(frozen=True)
class Layer:
    """One side of a face, where the line of sight meets it or just misses it.

    Attributes
    ----------
    face : int
    facing : {"front", "back", "edge-on"}
    edges : dict of str to float
        Distance in pixels from the sample to each edge on the image, positive inside: ``edge k``
        runs from corner k to the next. To first order for what bounds a curved face: ``outline``,
        ``base rim``, ``cap rim``.
    depth : Fraction or None
        In scene units along the view axis, exact on planes. None if the face does not cover the
        sample, in the limit from the right and below.
    removed : {"", "culled", "near", "far"}
        What keeps the face from being seen wherever it is: culled, or clipped in front of near or
        behind far.
    """

    face: int
    facing: str
    edges: Mapping[str, float]
    depth: Fraction | None
    removed: str

    @property
    def covered(self) -> bool:
        """Whether the line of sight meets the face, however culled or clipped."""
        return self.depth is not None

    @property
    def nearest_edge(self) -> tuple[str, float]:
        """The edge that the sample is most outside of, or nearest to, and its distance."""
        return min(self.edges.items(), key=lambda edge: edge[1])


@dataclass(frozen=True)
class Sightline:
    """What is on the line of sight of a sample.

    Attributes
    ----------
    owner : int
        Face id, -1 for the background.
    admissible : frozenset of int
        Every face that may own the sample; more than one is a tie.
    layers : tuple of Layer
        Those that cover the sample, nearest first; then those that miss it by less than a pixel, the
        closest first.
    """

    owner: int
    admissible: frozenset[int]
    layers: tuple[Layer, ...]

    def of(self, face: int) -> Layer | None:
        """Return the layer of a face that is seen first, None if the face is not near the sample."""
        return self._first.get(face)

    @cached_property
    def _first(self) -> dict[int, Layer]:
        first: dict[int, Layer] = {}
        for layer in sorted(self.layers, key=lambda layer: layer.removed != ""):
            first.setdefault(layer.face, layer)
        return first


def sightline(view: View, row: int, column: int) -> Sightline:
    """Look along the line of sight of a sample.

    Parameters
    ----------
    view : View
    row, column : int
        Row 0 is the top row.

    Returns
    -------
    Sightline

    Raises
    ------
    ViewError
        If there is no such sample, or the view has no exact answer.
    """
    check_sample(view, row, column)
    sample = row * view.width + column
    return sightlines(faces_nearby(view, np.array([sample])))[sample]


def sightlines(nearby: Nearby) -> dict[int, Sightline]:
    """Look along the lines of sight of all the samples that faces are near.

    Returns
    -------
    dict of int to Sightline
        By the number of the sample; faces are those of the whole view.

    Raises
    ------
    ViewError
        If the view has no exact answer.
    """
    lines, name = _Lines.of(nearby.view), [*nearby.origin.tolist(), BACKGROUND]
    found: dict[int, list[Layer]] = {sample: [] for sample in nearby.samples.tolist()}
    for sample, layer in chain(_flat_layers(nearby, lines), _curved_layers(nearby, lines)):
        found[sample].append(layer)
    told = {}
    for sample, (owner, admissible) in answers(nearby.view, nearby.samples).items():
        layers = tuple(sorted(found[sample], key=_order))
        told[sample] = Sightline(name[owner], frozenset(name[face] for face in admissible), layers)
    return told


def _order(layer: Layer) -> tuple[int, Fraction | float]:
    """Put what covers the sample first, by depth, then the rest by distance, then what is edge-on."""
    if layer.depth is not None:
        return 0, layer.depth
    return (1, -layer.nearest_edge[1]) if layer.edges else (2, 0.0)


# ---------------------------------------------------------------- layers


@dataclass(frozen=True, eq=False)
class _Lines:
    """The lines of sight of a view in exact numbers, from the eye to infinity.

    Attributes
    ----------
    opened : View
        All there is in front of the eye.
    frame : Frame
    limits : dict of str to (4,) object
        Forms that are negative in front of ``near`` and behind ``far``.
    i, j : (W,), (H,) object
        Coordinates of the columns and rows.
    """

    opened: View
    frame: Frame
    limits: Mapping[str, Array]
    i: Array
    j: Array

    @classmethod
    def of(cls, view: View) -> _Lines:
        opened = _opened(view)
        frame = frame_of(opened)
        limits = {}
        for name, sign, limit in (("near", 1, view.near), ("far", -1, view.far)):
            if limit < float("inf"):
                above, below = limit.as_integer_ratio()
                limits[name] = sign * (below * frame.depth - above * frame.unit)
        i, j = (axis.astype(object) for axis in coordinates(view))
        return cls(opened, frame, limits, i, j)

    def at(self, sample: Array) -> tuple[Array, Array]:
        """Return the coordinates of samples (n,)."""
        return self.i[sample % len(self.i)], self.j[sample // len(self.i)]


def _opened(view: View, cull: str = "none") -> View:
    """See all there is in front of the eye, or all of one side."""
    placements = tuple(replace(placement, cull=CULL[cull]) for placement in view.placements)
    near = 0.0 if view.perspective else -sys.float_info.max
    return replace(view, placements=placements, near=near, far=float("inf"))


def _triangles_of(triangles: Triangles, face: Ints) -> tuple[Array, Array]:
    """List the triangles of faces (n,): which of the faces each is of, and its number."""
    first, end = (np.searchsorted(triangles.face, face, side=side) for side in ("left", "right"))
    return ranges(first, end)


def _affine(forms: Array, i: Array, j: Array) -> Array:
    """Evaluate affine functions (n, k, 3) at samples (n,)."""
    return np.asarray(forms[..., 0] * i[:, None] + forms[..., 1] * j[:, None] + forms[..., 2])


def _conic(polynomial: Polynomial, i: Array, j: Array) -> Array:
    """Evaluate a polynomial of the second degree at samples (n,)."""
    a, b, c, d, e, f = coefficients(polynomial)
    return np.asarray((a * i + b * j + d) * i + (c * j + e) * j + f)


# ---------------------------------------------------------------- flat faces


@dataclass(frozen=True, eq=False)
class _Outlines:
    """The outlines of polygons on the image.

    Attributes
    ----------
    face : (P,) int64
        Ascending.
    facing, culls : sequence of str
        How each faces the eye, and which side of it is culled.
    edges : (E, 3) object
        Affine functions of the sample, positive within the polygon; none of those that are edge-on.
    start : (P + 1,) int64
    """

    face: Array
    facing: Sequence[str]
    culls: Sequence[str]
    edges: Array
    start: Array

    @classmethod
    def of(cls, view: View, frame: Frame) -> _Outlines:
        flat = [placement for placement in view.placements if not placement.shape.curved]
        face = [placement.first + np.arange(placement.shape.faces) for placement in flat]
        culls = [CULLED[placement.cull] for placement in flat for _ in range(placement.shape.faces)]
        facing: list[str] = []
        edges, sides = [np.zeros((0, 3), dtype=object)], [np.zeros(1, dtype=np.int64)]
        for placement in flat:
            inward, turn, size = _edges(placement, frame)
            ahead = FRONT, BACK
            facing += [EDGE_ON if side == 0 else ahead[(side < 0) != placement.mirrored] for side in turn]
            edges.append(inward)
            sides.append(size)
        return cls(
            np.concatenate([np.zeros(0, dtype=np.int64), *face]),
            facing,
            culls,
            np.concatenate(edges),
            np.cumsum(np.concatenate(sides)),
        )

    def distances(self, polygon: Array, sample: Array, lines: _Lines) -> Iterator[list[float]]:
        """Yield for polygons (n,) and samples (n,) how many pixels each sample is from each edge, inside."""
        which, edge = ranges(self.start[polygon], self.start[polygon + 1])
        form = self.edges[edge]
        value = _affine(form[:, None], *lines.at(sample[which]))[:, 0]
        square = (self.edges[:, :2] ** 2).sum(axis=1)[edge]
        pixel = np.frompyfunc(pixels_to_zero, 2, 1)(value, square).tolist()
        ends = np.searchsorted(which, np.arange(len(polygon) + 1)).tolist()
        return (pixel[first:end] for first, end in pairwise(ends))


def _edges(placement: Placement, frame: Frame) -> tuple[Array, Array, Array]:
    """Return the edges of an object's polygons, positive inside, their turns and numbers of edges.

    A polygon turns as its triangles do, which are a fan about its first corner.
    """
    polygons = placement.shape.polygons
    assert polygons is not None, "a curved shape has no edges"
    points = np.column_stack([polygons.vertices, np.ones(len(polygons.vertices))])
    corners = (integers(points) @ frame.placed(placement.world_from_object).T)[polygons.corner]
    first, sides = polygons.start[:-1], np.diff(polygons.start)
    after = np.arange(1, len(corners) + 1)
    after[polygons.start[1:] - 1] = first
    edges = cross(corners, corners[after])
    turn = np.add.reduceat((edges * np.repeat(corners[first, :3], sides, axis=0)).sum(axis=1), first)
    kept = np.repeat(turn != 0, sides)
    inward = edges * np.repeat(np.where(turn > 0, 1, -1), sides)[:, None]
    return inward[kept], turn, np.where(turn != 0, sides, 0)


def _flat_layers(nearby: Nearby, lines: _Lines) -> Iterator[tuple[int, Layer]]:
    """Yield the samples and the planar faces that cover them, or miss them by less than a pixel."""
    outlines = _Outlines.of(nearby.view, lines.frame)
    polygon = np.searchsorted(outlines.face, nearby.face)
    edges = outlines.distances(polygon, nearby.sample, lines)
    pairs = zip(nearby.sample.tolist(), nearby.face.tolist(), polygon.tolist(), edges, strict=True)
    met = _met(nearby, lines)
    for pair, (sample, face, k, distances) in enumerate(pairs):
        depth, clipped = met.get(pair, (None, ""))
        if depth is None and min(distances, default=0.0) <= -REACH:
            continue
        facing = outlines.facing[k]
        removed = "culled" if facing == outlines.culls[k] else clipped
        named = {f"edge {n}": distance for n, distance in enumerate(distances)}
        yield sample, Layer(int(nearby.origin[face]), facing, named, depth, removed)


def _met(nearby: Nearby, lines: _Lines) -> dict[int, tuple[Fraction, str]]:
    """Tell of the pairs whose face covers the sample how deep it lies, and what clips it."""
    triangles = triangles_of(lines.opened, lines.frame)
    pair, triangle = _triangles_of(triangles, nearby.face)
    half, at = triangles.half[triangle], lines.at(nearby.sample[pair])
    (inside,) = np.nonzero((_beside(half, _affine(half, *at)) >= 0).all(axis=1))
    pair, once = np.unique(pair[inside], return_index=True)
    zeta, det = triangles.zeta[triangle[inside[once]]], triangles.det[triangle[inside[once]]]
    at = lines.at(nearby.sample[pair])
    clipped = np.full(len(pair), "", dtype=object)
    for name, limit in reversed([*lines.limits.items()]):
        form = on_planes(limit, zeta, det)[:, None]
        clipped[_beside(form, _affine(form, *at))[:, 0] < 0] = name
    above, below = (
        _affine(form[None, None, :3], *at)[:, 0] * det + form[3] * _affine(zeta[:, None], *at)[:, 0]
        for form in (lines.frame.depth, lines.frame.unit)
    )
    depths = map(Fraction, above.tolist(), below.tolist())
    return dict(zip(pair.tolist(), zip(depths, clipped.tolist(), strict=True), strict=True))


def _beside(forms: Array, value: Array) -> Array:
    """Return the signs of affine functions just to the right of and below samples where they have a value.

    Moved by e to the right and by d down, a i + b j + c grows by a e - b d.
    See :mod:`hsr.exact.infinitesimals`.
    """
    right, below = forms[..., 0], -forms[..., 1]
    return np.asarray(np.sign(np.where(value != 0, value, np.where(right != 0, right, below))))


# ---------------------------------------------------------------- curved faces


def _curved_layers(nearby: Nearby, lines: _Lines) -> Iterator[tuple[int, Layer]]:
    """Yield the samples and the sides of curved faces that cover them, or miss them by less than a pixel."""
    i, j = lines.at(nearby.samples)
    for facing, other in ((FRONT, "back"), (BACK, "front")):
        for this in rounds_of(_opened(nearby.view, cull=other), lines.frame, 0):
            piece = this.piece
            placement = nearby.view.placements[int(nearby.view.object_of(np.array(piece.face)))]
            face = int(nearby.origin[piece.face])
            for k in np.flatnonzero(_reached(piece.extent[0], i, j)):
                layer = _layer(piece, face, facing, placement, lines, i[k], j[k])
                if layer is not None:
                    yield int(nearby.samples[k]), layer


def _reached(bound: Polynomial, i: Array, j: Array) -> Bools:
    """Tell where (n,) a polynomial is not negative, or vanishes less than REACH away, to first order."""
    value = _conic(bound, i, j)
    square = sum(_conic(bound.derivative(axis), i, j) ** 2 for axis in (0, 1))
    return np.asarray((value >= 0) | (value**2 < int(2 * REACH) ** 2 * square), dtype=np.bool_)


def _layer(
    piece: Piece, face: int, facing: str, placement: Placement, lines: _Lines, i: int, j: int
) -> Layer | None:
    """Say how one side of a curved face lies; None if it is too far away."""
    edges = _rims(piece, placement, i, j)
    culled = "culled" if facing == CULLED[placement.cull] else ""
    if piece.depth_at(beside(i, j)) is not None:
        depth = Fraction(*depth_quotient(lines.frame, piece, i, j))
        return Layer(face, facing, edges, depth, culled or _clipped(piece, lines, i, j))
    if min(edges.values()) <= -REACH:
        return None
    return Layer(face, facing, edges, None, culled)


def _clipped(piece: Piece, lines: _Lines, i: int, j: int) -> str:
    spot = beside(i, j)
    for name, limit in lines.limits.items():
        offset, slope = form(limit)
        if piece.zeta.at(spot).affine(at(slope, spot), at(offset, spot)).sign() < 0:
            return name
    return ""


def _rims(piece: Piece, placement: Placement, i: int, j: int) -> dict[str, float]:
    """Return the distances to what bounds a curved piece on the image."""
    disc, discs = piece.face > placement.first, placement.shape.face_names[1:]
    edges = {"rim" if disc else "outline": pixels(piece.extent[0], i, j)}
    if discs and not disc and replace(piece, inside=()).depth_at(beside(i, j)) is not None:
        for name, bound in zip(discs, piece.inside, strict=False):
            edges[f"{name} rim"] = _form_distance(piece, bound, i, j)
    return edges


def _form_distance(piece: Piece, bound: Form, i: int, j: int) -> float:
    """Pixels from a sample to where a form l + k zeta vanishes on a piece, to first order.

    zeta = (p + q sqrt(r)) / s has the gradient (p' + q r' / 2 sqrt(r) - zeta s') / s: q is a number.
    Infinite on the outline, where zeta has none. The integer r has hundreds of digits; so has its root.
    """
    zeta, (offset, slope) = piece.zeta, bound
    p, q, r, s, level, k = (int(x(i, j)) for x in (zeta.p, zeta.q, zeta.r, zeta.s, offset, slope))
    root = math.isqrt(max(r, 0))
    if q and not root:
        return math.inf
    # All over the common denominator s, and 2 root s^2 for the gradient.
    above, double = p + q * root, 2 * root if q else 1
    value, square = level * s + k * above, 0
    for axis in (0, 1):
        dp, dr, ds, rise = (int(x.derivative(axis)(i, j)) for x in (zeta.p, zeta.r, zeta.s, offset))
        square += (double * (rise * s * s + k * (dp * s - above * ds)) + k * q * dr * s) ** 2
    return pixels_to_zero(value * double * s, square)


# ---------------------------------------------------------------- distances


def pixels(polynomial: Polynomial, i: int, j: int) -> float:
    """Distance to where a polynomial vanishes, to first order; a pixel is two units of (i, j)."""
    slopes = [int(polynomial.derivative(k)(i, j)) for k in (0, 1)]
    return pixels_to_zero(int(polynomial(i, j)), slopes[0] ** 2 + slopes[1] ** 2)


def pixels_to_zero(value: int, square: int) -> float:
    """Turn a value, and the square of its gradient by (i, j), into a distance.

    Infinite if the value is stationary at the sample, as that of what does not cut is, or all but so: if the
    square of the distance is beyond float64.
    """
    side = 1.0 if value >= 0 else -1.0
    return side * (math.inf if value**2 >> 1023 >= square else 0.5 * math.sqrt(value**2 / square))
