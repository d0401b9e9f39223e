"""From samples and the pieces that may own them to owners and depths."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import accumulate, chain, groupby, repeat
from math import inf
from typing import NamedTuple, TypeVar, cast

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.certify.curved import CurvedPiece, Hit, curved_piece, root_on_plane, sights_of
from hsr.certify.facets import Corner, Facet, corner_of, facet_of
from hsr.certify.frame import Frame, Matrix, frame_of
from hsr.problem.geometry import Geometry
from hsr.problem.map import BACKGROUND
from hsr.problem.view import Placement, View
from hsr.scene.shapes import Polygons

CHUNK = 2**12
"""Samples decided at a time: each takes some hundred bytes as Python's numbers."""

KEPT = 2**15
"""Pieces, or corners of pieces, that are kept: each takes some 3 kB, or 14 where numbers are extreme."""

OWNER = np.dtype([("face", np.int32), ("depth", np.float64)])
"""Who owns a sample, and how deep."""


@dataclass(frozen=True, eq=False)
class Resolved:
    """Exact answers at some samples.

    Attributes
    ----------
    sample : (n,) int64
        Numbers ``row * W + column``, ascending, each once.
    face : (n,) int32
        Owner, -1 for the background.
    depth : (n,) float64
        Depth of the owner in scene units, correctly rounded; infinite for the background.
    """

    sample: Array
    face: Ints
    depth: Floats


def first_pieces(geometry: Geometry) -> list[int]:
    """Return where the pieces of each object begin, in file order, and the number of pieces.

    An object of planar faces has the triangles of its polygons' fans, in the order of
    ``shape.polygons.triangle_vertex``; a sphere is 1 piece, a cylinder 3 (side, base, cap). For a view
    without curved shapes the pieces are the triangles of ``view.polygons``.
    """
    return geometry.once("certify", lambda: list(accumulate(map(_piece_count, geometry), initial=0)))


def _piece_count(placement: Placement) -> int:
    polygons = placement.shape.polygons
    return placement.shape.faces if polygons is None else len(polygons.triangle_vertex)


def resolve(view: View, sample: Array, piece: Ints, sure: Bools) -> Resolved:
    """Decide exactly which of the given candidates owns each sample.

    The view's camera must be invertible, and depth must grow along its lines of sight, from less than
    ``view.near`` at the eye if there is one.

    Parameters
    ----------
    view : View
    sample : (m,) int64
        Numbers ``row * W + column`` of samples in any order, repeated for each candidate.
    piece : (m,) int32
        A candidate for that sample, numbered as :func:`first_pieces` says. The owner in the limit must be
        among the candidates of its sample, unless it is the background.
    sure : (m,) bool
        Whether it is proven that the piece takes part in a whole neighbourhood of the sample: not culled,
        strictly within its edges and between near and far. Curved pieces are asked all the same.

    Returns
    -------
    Resolved
    """
    if len(sample) == 0:
        return Resolved(np.zeros(0, np.int64), np.zeros(0, np.int32), np.zeros(0))
    order = sample.argsort(kind="stable")
    sample = sample[order].astype(np.int64)
    first = np.flatnonzero(np.concatenate([[True], sample[1:] != sample[:-1], [True]]))
    candidates = Candidates(sample[first[:-1]], first, piece[order], sure[order])
    frame = frame_of(view)
    found = np.fromiter(_owners(frame, _pieces_of(view, frame), candidates), OWNER, len(candidates.sample))
    return Resolved(candidates.sample, found["face"], found["depth"])


def facets_at(view: View, piece: Ints) -> tuple[Frame, list[Facet]]:
    """Set up planar pieces exactly, for methods that cannot do it in float64.

    Parameters
    ----------
    view : View
    piece : (n,) int

    Returns
    -------
    frame : Frame
        The integers in which the view is measured.
    facets : list of n Facet
    """
    frame = frame_of(view)
    pieces = _pieces_of(view, frame)
    return frame, [cast(Facet, pieces[number]) for number in piece.tolist()]


def sights_at(view: View, things: Array) -> tuple[Frame, Array, Array, Array]:
    """Carry the lines of sight exactly into the spaces of some objects, for methods that meet them there.

    Parameters
    ----------
    view : View
    things : (n,) int64
        Indices of objects.

    Returns
    -------
    frame : Frame
        The integers in which the view is measured.
    origin, step, scale
        See :func:`hsr.certify.curved.sights_of`.
    """
    frame = frame_of(view)
    matrices = [frame.matrix(view.placements[thing]) for thing in things.tolist()]
    return frame, *sights_of(frame, np.array(matrices, object))


# ---------------------------------------------------------------- the pieces

Piece = Facet | CurvedPiece
Key = TypeVar("Key")
Value = TypeVar("Value")


class Kept(dict[Key, Value]):
    """What a function makes of what it is given, made when first asked for and kept while there is room."""

    def __init__(self, make: Callable[[Key], Value]):
        self.make = make

    def __missing__(self, key: Key) -> Value:
        if len(self) >= KEPT:
            self.clear()
        made = self[key] = self.make(key)
        return made


def _pieces_of(view: View, frame: Frame) -> Kept[int, Piece]:
    """Return the pieces of a view."""
    matrices: Kept[int, Matrix] = Kept(lambda thing: frame.matrix(view.placements[thing]))
    corners = Kept(partial(_corner, view, matrices))
    return Kept(partial(_piece, view, frame, first_pieces(view.geometry), corners))


def _corner(view: View, matrices: Kept[int, Matrix], which: tuple[int, int]) -> Corner:
    thing, vertex = which
    polygons = view.placements[thing].shape.polygons
    assert polygons is not None, "spheres and cylinders have no vertices"
    return corner_of(matrices[thing], polygons.vertices[vertex].tolist())


def _piece(
    view: View, frame: Frame, starts: list[int], corners: Kept[tuple[int, int], Corner], number: int
) -> Piece:
    """Set up a piece; those of each object begin at ``starts``."""
    thing = bisect_right(starts, number) - 1
    placement, part = view.placements[thing], number - starts[thing]
    polygons = placement.shape.polygons
    if polygons is None:
        return curved_piece(frame, placement, part)
    if placement.mirrored:
        part = _turned(polygons, part)
    face = placement.first + int(polygons.face[polygons.triangle_polygon[part]])
    a, b, c = polygons.triangle_vertex[part].tolist()
    return facet_of(frame, placement, face, (corners[thing, a], corners[thing, b], corners[thing, c]))


def _turned(polygons: Polygons, triangle: int) -> int:
    """Return the triangle in the same place of its fan if that runs the other way round.

    So ``view.polygons`` has the fans of mirrored objects.
    """
    polygon = polygons.triangle_polygon
    first, end = (np.searchsorted(polygon, polygon[triangle], side) for side in ("left", "right"))
    return int(first + end) - 1 - triangle


# ---------------------------------------------------------------- the owners


class Candidates(NamedTuple):
    """Pieces that may own samples, sample after sample.

    Attributes
    ----------
    sample : (n,) int64
    first : (n + 1,) int64
        First candidate of each sample, and how many there are.
    piece : (m,) int32
    sure : (m,) bool
    """

    sample: Array
    first: Array
    piece: Ints
    sure: Bools


class Span(NamedTuple):
    """Samples side by side in a row that have the same candidates.

    Attributes
    ----------
    row, column : int
        Of the first sample.
    length : int
    pieces : list of int
    sure : list of bool
    """

    row: int
    column: int
    length: int
    pieces: list[int]
    sure: list[bool]


def _chunks(candidates: Candidates) -> Iterator[Candidates]:
    """Cut into runs of CHUNK samples."""
    sample, first, piece, sure = candidates
    for low in range(0, len(sample), CHUNK):
        own = first[low : low + CHUNK + 1]
        run = slice(own[0], own[-1])
        yield Candidates(sample[low : low + CHUNK], own - own[0], piece[run], sure[run])


def _spans(frame: Frame, candidates: Candidates) -> Iterator[Span]:
    """Gather samples in spans."""
    row, column = np.divmod(candidates.sample, frame.width)
    # Along a span the column grows as the index of the sample does.
    origin, index = column - np.arange(len(column)), 0
    pieces, sure, bounds = candidates.piece.tolist(), candidates.sure.tolist(), candidates.first.tolist()
    asked = (
        (y, x, pieces[low:high], sure[low:high])
        for y, x, low, high in zip(row.tolist(), origin.tolist(), bounds, bounds[1:], strict=False)
    )
    for (y, x, *question), alike in groupby(asked):
        length = sum(1 for _ in alike)
        yield Span(y, x + index, length, *question)
        index += length


def _owners(frame: Frame, pieces: Kept[int, Piece], candidates: Candidates) -> Iterator[tuple[int, float]]:
    """Yield the owner of each sample, and its depth."""
    spans = chain.from_iterable(_spans(frame, chunk) for chunk in _chunks(candidates))
    for row, column, length, numbers, sure in spans:
        asked = [pieces[number] for number in numbers]
        i, j = frame.place(row, column)
        facet = _settled(asked) if all(sure) else None
        if facet is not None:
            yield from zip(repeat(facet.face), facet.depths(i, j, length), strict=False)
        else:
            yield from (_owner(frame, asked, sure, i + 2 * k, j) for k in range(length))


def _settled(asked: list[Piece]) -> Facet | None:
    """Return the owner wherever all these cover a sample, if they are of one plane."""
    owner: Facet | None = None
    for piece in asked:
        if isinstance(piece, CurvedPiece) or (owner is not None and owner.plane != piece.plane):
            return None
        if owner is None or piece.face < owner.face:
            owner = piece
    return owner


def _owner(frame: Frame, asked: list[Piece], sure: list[bool], i: int, j: int) -> tuple[int, float]:
    """Return which of some pieces owns a place, and its depth."""
    owner, curved = None, []
    for piece, certain in zip(asked, sure, strict=True):
        if isinstance(piece, CurvedPiece):
            curved.append(piece)
        elif (owner is None or piece.hides(owner, i, j)) and (certain or piece.covers(i, j)):
            owner = piece
    hit = _first_hit(frame, curved, owner, i, j) if curved else None
    if hit is not None:
        return hit.face, hit.depth(frame.unit)
    if owner is not None:
        return owner.face, next(owner.depths(i, j, 1))
    return BACKGROUND, inf


def _first_hit(frame: Frame, curved: list[CurvedPiece], facet: Facet | None, i: int, j: int) -> Hit | None:
    """Return the first hit of curved pieces, unless a planar piece hides them all."""
    hit = min((hit for piece in curved for hit in piece.hits(i, j)), default=None)
    if hit is None or facet is None:
        return hit
    return hit if hit < Hit(facet.face, root_on_plane(facet.plane, frame.perspective, i, j)) else None
