"""One line of sight, decided exactly: every face on it, and those that just miss it.

Only the faces near the sample are looked at, and they are set up in exact numbers once as the view
has them, which gives the owner, and once without culling and clipping, which gives all that lies
there at all.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise

import numpy as np

from hsr.arrays import Array, Bools, Floats, Ints
from hsr.errors import ViewError
from hsr.exact.decide import Form, Piece, decide
from hsr.exact.depths import depth_quotient
from hsr.exact.germs import Polynomial, affine, at, beside
from hsr.exact.margins import REACH, pixels
from hsr.exact.numbers import Frame, frame_of, integers
from hsr.exact.planes import cross
from hsr.exact.problem import Problem, problem_of
from hsr.exact.quadrics import form
from hsr.scene.shapes import Kind, Polygons, Shape
from hsr.viewing import CULL, Placement, View
from hsr.visibility import BACKGROUND

FRONT, BACK, EDGE_ON = "front", "back", "edge-on"

CULLED = {CULL["none"]: "", CULL["back"]: BACK, CULL["front"]: FRONT}
"""The side that an object culls."""

ROUNDING = 2.0**-49
"""Bound of the relative error of a coordinate in :func:`_beyond`, 16 u with u = 2^-53.

A side of the pixel carries three roundings, its products with the transform and with the point five
each (Higham, Accuracy and Stability of Numerical Algorithms, section 3.1); the bound itself is rounded.
"""


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
class Sight:
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
        layers = [layer for layer in self.layers if layer.face == face]
        return min(layers, key=lambda layer: layer.removed != "", default=None)


def sight(view: View, row: int, column: int) -> Sight:
    """Look along the line of sight of a sample.

    Parameters
    ----------
    view : View
    row, column : int
        Row 0 is the top row.

    Returns
    -------
    Sight

    Raises
    ------
    ViewError
        If there is no such sample, or the view has no exact answer.
    """
    near, origin = nearby(view, row, column)
    problem = problem_of(near)
    line = _Line.of(view, _opened(near), int(problem.i[column]), int(problem.j[row]))
    owner, admissible = _owner(problem, line.i, line.j)
    layers = [*_flat_layers(near, line), *_curved_layers(near, line)]
    name = [*map(int, origin), BACKGROUND]
    return Sight(
        name[owner],
        frozenset(name[face] for face in admissible),
        tuple(replace(layer, face=name[layer.face]) for layer in sorted(layers, key=_order)),
    )


def _owner(problem: Problem, i: int, j: int) -> tuple[int, frozenset[int]]:
    """Decide the sample among the pieces that are not surely beside it."""
    pieces = _pieces(problem)
    touching = [piece for piece in pieces if all(int(bound(i, j)) >= 0 for bound in piece.extent)]
    owner, admissible = decide(touching, i, j, problem.frame.nearer)
    return pieces[owner].face if owner >= 0 else BACKGROUND, admissible


def _pieces(problem: Problem) -> list[Piece]:
    return [problem.piece(number) for number in range(len(problem.triangles) + len(problem.rounds))]


def _order(layer: Layer) -> tuple[int, Fraction]:
    """Put what covers the sample first, by depth, then the rest by distance, then what is edge-on."""
    if layer.depth is not None:
        return 0, layer.depth
    return (1, -Fraction(layer.nearest_edge[1])) if layer.edges else (2, Fraction(0))


# ---------------------------------------------------------------- the faces near a sample


@lru_cache(maxsize=1)  # the same sample is asked about several times in a row
def nearby(view: View, row: int, column: int) -> tuple[View, Ints]:
    """Leave only the faces that come within a pixel of a sample, and perhaps a few more.

    Of meshes the polygons that may come near are left, each a face of its own; other shapes stay whole.

    Parameters
    ----------
    view : View
    row, column : int

    Returns
    -------
    View
        The same camera and size; possibly no object at all.
    origin : (n,) int32
        Face of ``view`` that each of its faces is.

    Raises
    ------
    ViewError
        If there is no such sample.
    """
    check_sample(view, row, column)
    sides = _pixel_sides(view, row, column)
    placements: list[Placement] = []
    origin = [np.zeros(0, dtype=np.int32)]
    for placement in view.placements:
        shape, face = _shape_near(placement, sides)
        if len(face):
            first = sum(len(part) for part in origin)
            placements.append(replace(placement, shape=shape, first=first))
            origin.append(face + np.int32(placement.first))
    return replace(view, placements=tuple(placements)), np.concatenate(origin)


def check_sample(view: View, row: int, column: int) -> None:
    """Raise :class:`hsr.errors.ViewError` if there is no such sample; row 0 is the top row."""
    if not (0 <= row < view.height and 0 <= column < view.width):
        size = f"{view.width}x{view.height}"
        raise ViewError(f"no sample at column {column}, row {row}: the image is {size}, counted from 0")


def _shape_near(placement: Placement, sides: Floats) -> tuple[Shape, Ints]:
    """Return what is left of an object's shape, and the face of the object that each face of it is."""
    shape, polygons = placement.shape, placement.shape.polygons
    everything = np.arange(shape.faces, dtype=np.int32)
    if polygons is None:
        return shape, everything
    chosen = np.flatnonzero(~_beyond(polygons, sides, placement.world_from_object))
    if shape.kind == Kind.MESH:
        return Shape(Kind.MESH, shape.label, _chosen(polygons, chosen)), polygons.face[chosen]
    return shape, everything[: shape.faces if len(chosen) else 0]


def _pixel_sides(view: View, row: int, column: int) -> Floats:
    """Return five world functions (5, 4), negative a pixel beside the sample's lines, or behind the eye.

    On lines of sight x_clip = x_ndc w: no division, and nothing in front of the eye is special.
    """
    x, y, _, w = view.clip_from_world
    left, right = ((2.0 * (column + shift) + 1.0) / view.width - 1.0 for shift in (-REACH, REACH))
    top, bottom = (1.0 - (2.0 * (row + shift) + 1.0) / view.height for shift in (-REACH, REACH))
    return np.array([x - left * w, right * w - x, y - bottom * w, top * w - y, w])


def _beyond(polygons: Polygons, sides: Floats, world_from_object: Floats) -> Bools:
    """Tell which polygons (P,) have all corners surely beyond one and the same side."""
    rows = sides @ world_from_object
    value = polygons.vertices @ rows[:, :3].T + rows[:, 3]
    greatest = np.abs(sides) @ np.abs(world_from_object)
    bound = np.abs(polygons.vertices) @ greatest[:, :3].T + greatest[:, 3]
    outside = (value < -ROUNDING * bound)[polygons.corner]
    return np.asarray(np.logical_and.reduceat(outside, polygons.start[:-1], axis=0).any(axis=1))


def _chosen(polygons: Polygons, chosen: Array) -> Polygons:
    """Return some of the polygons, each a face of its own, with only the vertices they use."""
    loops = [polygons.corner[polygons.start[k] : polygons.start[k + 1]].tolist() for k in chosen]
    used = sorted({vertex for loop in loops for vertex in loop})
    number = {vertex: k for k, vertex in enumerate(used)}
    return Polygons.of(polygons.vertices[used], [[number[vertex] for vertex in loop] for loop in loops])


# ---------------------------------------------------------------- layers


@dataclass(frozen=True, eq=False)
class _Line:
    """A line of sight in exact numbers, from the eye to infinity.

    Attributes
    ----------
    frame : Frame
    i, j : int
        The sample.
    limits : dict of str to (4,) object
        Forms that are negative in front of ``near`` and behind ``far``.
    """

    frame: Frame
    i: int
    j: int
    limits: Mapping[str, Array]

    @classmethod
    def of(cls, view: View, opened: View, i: int, j: int) -> _Line:
        frame = frame_of(opened)
        limits = {}
        for name, sign, limit in (("near", 1, view.near), ("far", -1, view.far)):
            if limit < float("inf"):
                above, below = limit.as_integer_ratio()
                limits[name] = sign * (below * frame.depth - above * frame.unit)
        return cls(frame, i, j, limits)

    def distance(self, polynomial: Polynomial) -> float:
        """Pixels from the sample to where a polynomial vanishes, to first order."""
        return pixels(polynomial, self.i, self.j)

    def layer(
        self, face: int, facing: str, edges: Mapping[str, float], culls: str, pieces: Iterable[Piece]
    ) -> Layer | None:
        """Say how one side of a face lies, which is made of pieces; None if it is too far away."""
        culled = "culled" if facing == culls else ""
        spot = beside(self.i, self.j)
        for piece in pieces:
            if piece.depth_at(spot) is not None:
                depth = Fraction(*depth_quotient(self.frame, piece, self.i, self.j))
                return Layer(face, facing, edges, depth, culled or self._clipped(piece))
        if min(edges.values(), default=0.0) <= -REACH:
            return None
        return Layer(face, facing, edges, None, culled)

    def _clipped(self, piece: Piece) -> str:
        spot = beside(self.i, self.j)
        for name, limit in self.limits.items():
            offset, slope = form(limit)
            if piece.zeta.at(spot).affine(at(slope, spot), at(offset, spot)).sign() < 0:
                return name
        return ""


def _opened(view: View, cull: str = "none") -> View:
    """See all there is in front of the eye, or all of one side."""
    placements = tuple(replace(placement, cull=CULL[cull]) for placement in view.placements)
    near = 0.0 if view.perspective else -sys.float_info.max
    return replace(view, placements=placements, near=near, far=float("inf"))


def _flat_layers(near: View, line: _Line) -> Iterator[Layer]:
    pieces = _pieces(problem_of(_opened(near)))
    for placement in near.placements:
        polygons = placement.shape.polygons
        if polygons is None:
            continue
        points = np.column_stack([polygons.vertices, np.ones(len(polygons.vertices))])
        corners = integers(points) @ line.frame.placed(placement.world_from_object).T
        for k, (start, end) in enumerate(pairwise(polygons.start)):
            face = placement.first + k
            facing, edges = _outline(corners[polygons.corner[start:end]], placement.mirrored, line)
            present = (piece for piece in pieces if piece.face == face)
            layer = line.layer(face, facing, edges, CULLED[placement.cull], present)
            if layer is not None:
                yield layer


def _outline(corners: Array, mirrored: bool, line: _Line) -> tuple[str, dict[str, float]]:
    """Return how a polygon with corners (n, 4) of the frame faces the eye, and its edges' distances."""
    after = np.roll(corners, -1, axis=0)
    edges = cross(corners, after)
    turn = sum((edges[1:-1] * corners[0, :3]).sum(axis=1))
    if turn == 0:
        return EDGE_ON, {}
    inward = edges if turn > 0 else -edges
    facing = FRONT if (turn > 0) != mirrored else BACK
    return facing, {f"edge {k}": line.distance(affine(edge)) for k, edge in enumerate(inward)}


def _curved_layers(near: View, line: _Line) -> Iterator[Layer]:
    for facing, other in ((FRONT, "back"), (BACK, "front")):
        for this in problem_of(_opened(near, cull=other)).rounds:
            placement = near.placements[int(near.object_of(np.array(this.piece.face)))]
            edges = _rims(this.piece, placement, line)
            layer = line.layer(this.piece.face, facing, edges, CULLED[placement.cull], [this.piece])
            if layer is not None:
                yield layer


def _rims(piece: Piece, placement: Placement, line: _Line) -> dict[str, float]:
    """Return the distances to what bounds a curved piece on the image."""
    tube = placement.shape.kind == Kind.CYLINDER and piece.face == placement.first
    disc = placement.shape.kind == Kind.CYLINDER and not tube
    edges = {"rim" if disc else "outline": line.distance(piece.extent[0])}
    if tube and replace(piece, inside=()).depth_at(beside(line.i, line.j)) is not None:
        for name, bound in zip(("base rim", "cap rim"), piece.inside, strict=False):
            edges[name] = _form_distance(piece, bound, line.i, line.j)
    return edges


def _form_distance(piece: Piece, bound: Form, i: int, j: int) -> float:
    """Pixels from a sample to where a form l + k zeta vanishes on a piece, to first order.

    zeta = (p + q sqrt(r)) / s has the gradient (p' + q r' / 2 sqrt(r) - zeta s') / s: q is a number.
    Infinite on the outline, where zeta has none. The integer r has hundreds of digits; so has its root.
    """
    zeta, (offset, slope) = piece.zeta, bound
    p, q, r, s, level, k = (Fraction(int(x(i, j))) for x in (zeta.p, zeta.q, zeta.r, zeta.s, offset, slope))
    root = Fraction(math.isqrt(max(int(r), 0)))
    if q and not root:
        return math.inf
    value = (p + q * root) / s
    square = Fraction(0)
    for axis in (0, 1):
        dp, dr, ds, rise = (int(x.derivative(axis)(i, j)) for x in (zeta.p, zeta.r, zeta.s, offset))
        square += (rise + k * (dp + (q * dr / (2 * root) if q else 0) - value * ds) / s) ** 2
    distance = 0.5 * math.sqrt((level + k * value) ** 2 / square) if square else math.inf
    return distance if level + k * value >= 0 else -distance
