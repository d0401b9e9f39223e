"""Lines of sight, decided exactly: every face on them, and those that just miss them.

Only the faces near a sample are looked at, and they are set up in exact numbers once as the view
has them, which gives the owner, and once without culling and clipping, which gives all that lies
there at all. Samples of one view share all that is set up, and flat faces are met by all of them
together; so many cost little more each than what is told of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import chain, pairwise
from typing import NamedTuple

import numpy as np

from hsr.base.arrays import Array, Bools, ranges
from hsr.base.deprecated import sample_by_name
from hsr.difference.nearby import REACH, Nearby, check_sample, faces_nearby
from hsr.exact.decide import Form, Piece
from hsr.exact.depths import depth_quotient
from hsr.exact.infinitesimals import Polynomial, at, beside, coefficients
from hsr.exact.numbers import Frame, frame_of, points
from hsr.exact.oracle import answers
from hsr.exact.planes import cross, on_planes, triangles_of
from hsr.exact.quadrics import form, rounds_of
from hsr.problem.map import BACKGROUND
from hsr.problem.view import CULL, Placement, View

FRONT, BACK, EDGE_ON = "front", "back", "edge-on"

SIDES = (EDGE_ON, FRONT, BACK)
"""What is seen of a face by how it turns: 0, 1 or -1."""

CULLED = {CULL["none"]: "", CULL["back"]: BACK, CULL["front"]: FRONT}
"""The side that an object culls."""


class Layer(NamedTuple):
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
        # A face's later entries overwrite earlier ones, so what is seen first comes last.
        seen = sorted(self.layers, key=lambda layer: layer.removed != "")
        return {layer.face: layer for layer in reversed(seen)}


@sample_by_name
def sightline(view: View, *, x: int, y: int) -> Sightline:
    """Look along the line of sight of a sample.

    Parameters
    ----------
    view : View
    x, y : int
        Column and row of the sample, counted from 0 at the top left.

    Returns
    -------
    Sightline

    Raises
    ------
    ViewError
        If there is no such sample, or the view has no exact answer.
    """
    check_sample(view, x, y)
    sample = y * view.width + x
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
    frame, name = frame_of(nearby.view), [*nearby.origin.tolist(), BACKGROUND]
    found: dict[int, list[Layer]] = {sample: [] for sample in nearby.samples.tolist()}
    for sample, layer in chain(_flat_layers(nearby, frame), _curved_layers(nearby, frame)):
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


def _opened(view: View, frame: Frame, cull: str = "none") -> tuple[View, Frame]:
    """See all there is in front of the eye, or all of one side: nothing is clipped by near and far."""
    placements = tuple(replace(placement, cull=CULL[cull]) for placement in view.placements)
    return replace(view, placements=placements), replace(frame, limits=frame.limits[:0])


def _clippers(frame: Frame) -> Iterator[tuple[str, Array]]:
    """Yield what clips, and the form that is negative where it does."""
    return zip(("near", "far"), frame.limits, strict=False)


def _affine(forms: Array, i: Array, j: Array) -> Array:
    """Evaluate affine functions (n, k, 3) at samples (n,)."""
    return np.asarray(forms[..., 0] * i[:, None] + forms[..., 1] * j[:, None] + forms[..., 2])


def _conic(polynomial: Polynomial, i: Array, j: Array) -> Array:
    """Evaluate a polynomial of the second degree at samples (n,)."""
    a, b, c, d, e, f = coefficients(polynomial)
    return np.asarray((a * i + b * j + d) * i + (c * j + e) * j + f)


# ---------------------------------------------------------------- flat faces


def _outlines(view: View, frame: Frame) -> tuple[Array, Array, Array]:
    """Return the outlines of faces on the image; none of those that are curved or edge-on.

    Returns
    -------
    edges : (E, 3) object
        Affine functions of the sample, positive within the polygon.
    start : (F + 1,) int64
        Those of face k are ``edges[start[k]:start[k + 1]]``.
    side : (F,) int64
        Which side is seen, by its place in ``SIDES``.
    """
    found = [(np.zeros((0, 3), object), np.zeros(1, np.int64), np.zeros(0, np.int64))]
    found += [_edges(placement, frame) for placement in view.placements]
    edges, sizes, side = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return edges, np.cumsum(sizes), side


def _edges(placement: Placement, frame: Frame) -> tuple[Array, Array, Array]:
    """Return the edges of an object's polygons, positive inside, how many each has, and the side seen.

    A polygon turns as its triangles do, which are a fan about its first corner.
    """
    polygons = placement.shape.polygons
    if polygons is None:
        nothing = np.zeros(placement.shape.faces, np.int64)
        return np.zeros((0, 3), object), nothing, nothing
    corners = (points(polygons.vertices) @ frame.placed(placement.world_from_object).T)[polygons.corner]
    first, sizes = polygons.start[:-1], np.diff(polygons.start)
    after = np.arange(1, len(corners) + 1)
    after[polygons.start[1:] - 1] = first
    edges = cross(corners, corners[after])
    turn = np.add.reduceat((edges * np.repeat(corners[first, :3], sizes, axis=0)).sum(axis=1), first)
    turn = np.sign(turn).astype(np.int64)
    each = np.repeat(turn, sizes)
    side = -turn if placement.mirrored else turn
    return (edges * each[:, None])[each != 0], np.where(turn != 0, sizes, 0), side


def _flat_layers(nearby: Nearby, frame: Frame) -> Iterator[tuple[int, Layer]]:
    """Yield the samples and the planar faces that cover them, or miss them by less than a pixel."""
    view, edges, start, side = nearby.view, *_outlines(nearby.view, frame)
    which, edge = ranges(start[nearby.face], start[nearby.face + 1])
    value = _affine(edges[edge][:, None], *frame.exactly_at(nearby.sample[which]))[:, 0]
    square = (edges[:, :2] ** 2).sum(axis=1)[edge]
    pixel = np.frompyfunc(pixels_to_zero, 2, 1)(value, square).tolist()
    ends = np.searchsorted(which, np.arange(len(nearby.face) + 1)).tolist()
    pairs = zip(nearby.sample.tolist(), nearby.face.tolist(), pairwise(ends), strict=True)
    met, owner = _met(nearby, frame), view.object_of(nearby.face).tolist()
    for pair, (sample, face, (first, end)) in enumerate(pairs):
        depth, clipped = met.get(pair, (None, ""))
        if depth is None and min(pixel[first:end], default=0.0) <= -REACH:
            continue
        facing = SIDES[side[face]]
        removed = "culled" if facing == CULLED[view.placements[owner[pair]].cull] else clipped
        named = {f"edge {n}": distance for n, distance in enumerate(pixel[first:end])}
        yield sample, Layer(int(nearby.origin[face]), facing, named, depth, removed)


def _met(nearby: Nearby, frame: Frame) -> dict[int, tuple[Fraction, str]]:
    """Tell of the pairs whose face covers the sample how deep it lies, and what clips it."""
    triangles = triangles_of(*_opened(nearby.view, frame), nearby.samples)
    ends = (np.searchsorted(triangles.face, nearby.face, side=side) for side in ("left", "right"))
    pair, triangle = ranges(*ends)
    half, at = triangles.half[triangle], frame.exactly_at(nearby.sample[pair])
    (inside,) = np.nonzero((_beside(half, _affine(half, *at)) >= 0).all(axis=1))
    pair, once = np.unique(pair[inside], return_index=True)
    zeta, det = triangles.zeta[triangle[inside[once]]], triangles.det[triangle[inside[once]]]
    at = frame.exactly_at(nearby.sample[pair])
    clipped = np.full(len(pair), "", dtype=object)
    for name, limit in reversed([*_clippers(frame)]):
        form = on_planes(limit, zeta, det)[:, None]
        clipped[_beside(form, _affine(form, *at))[:, 0] < 0] = name
    values = (_affine(on_planes(form, zeta, det)[:, None], *at)[:, 0] for form in (frame.depth, frame.unit))
    return dict(zip(pair.tolist(), zip(map(Fraction, *values), clipped.tolist(), strict=True), strict=True))


def _beside(forms: Array, value: Array) -> Array:
    """Return the signs of affine functions just to the right of and below samples where they have a value.

    Moved by e to the right and by d down, a i + b j + c grows by a e - b d.
    See :mod:`hsr.exact.infinitesimals`.
    """
    right, below = forms[..., 0], -forms[..., 1]
    return np.asarray(np.sign(np.where(value != 0, value, np.where(right != 0, right, below))))


# ---------------------------------------------------------------- curved faces


def _curved_layers(nearby: Nearby, frame: Frame) -> Iterator[tuple[int, Layer]]:
    """Yield the samples and the sides of curved faces that cover them, or miss them by less than a pixel."""
    i, j = frame.exactly_at(nearby.samples)
    for facing, other in ((FRONT, "back"), (BACK, "front")):
        for piece in rounds_of(*_opened(nearby.view, frame, cull=other), 0):
            placement = nearby.view.placements[int(nearby.view.object_of(np.array(piece.face)))]
            face, culled = int(nearby.origin[piece.face]), facing == CULLED[placement.cull]
            for k in np.flatnonzero(_reached(piece.extent[0], i, j)):
                edges, depth, clipped = _rims(piece, placement, i[k], j[k]), None, ""
                if piece.depth_at(beside(i[k], j[k])) is not None:
                    depth = Fraction(*depth_quotient(frame, piece, i[k], j[k]))
                    clipped = _clipped(piece, frame, i[k], j[k])
                elif min(edges.values()) <= -REACH:
                    continue
                removed = "culled" if culled else clipped
                yield int(nearby.samples[k]), Layer(face, facing, edges, depth, removed)


def _reached(bound: Polynomial, i: Array, j: Array) -> Bools:
    """Tell where (n,) a polynomial is not negative, or vanishes less than REACH away, to first order."""
    value, *slopes = (_conic(one, i, j) for one in (bound, bound.derivative(0), bound.derivative(1)))
    near = value**2 < int(2 * REACH) ** 2 * sum(slope**2 for slope in slopes)
    return np.asarray((value >= 0) | near, dtype=np.bool_)


def _clipped(piece: Piece, frame: Frame, i: int, j: int) -> str:
    spot = beside(i, j)
    for name, limit in _clippers(frame):
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
