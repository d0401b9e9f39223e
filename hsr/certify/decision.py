"""From samples and the pieces that may own them to owners and depths."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator
from functools import lru_cache
from itertools import accumulate, groupby, pairwise, repeat
from math import inf
from operator import attrgetter
from typing import NamedTuple, cast

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.certify.curved import CurvedPiece, Hit, root_on_plane, sights_of
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


class Resolved(NamedTuple):
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
    if not len(sample):
        return Resolved(np.empty(0, np.int64), np.empty(0, np.int32), np.empty(0))
    order = sample.argsort(kind="stable")
    first = np.flatnonzero(np.diff(sample[order], prepend=-1, append=-1))
    sample = sample[order][first[:-1]].astype(np.int64)
    found = np.fromiter(_owners(view, sample, first, piece[order], sure[order]), OWNER, len(sample))
    return Resolved(sample, found["face"], found["depth"])


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
    return frame, [cast(Facet, made) for made in map(_pieces_of(view, frame), piece.tolist())]


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


def _pieces_of(view: View, frame: Frame) -> Callable[[int], Piece]:
    """Return what sets up a piece by its number, and keeps the last ones that were asked for."""
    starts = first_pieces(view.geometry)

    @lru_cache(KEPT)
    def matrix(thing: int) -> Matrix:
        return frame.matrix(view.placements[thing])

    @lru_cache(KEPT)
    def corner(thing: int, vertex: int) -> Corner:
        polygons = cast(Polygons, view.placements[thing].shape.polygons)
        return corner_of(matrix(thing), polygons.vertices[vertex].tolist())

    @lru_cache(KEPT)
    def piece(number: int) -> Piece:
        thing = bisect_right(starts, number) - 1
        placement, part = view.placements[thing], number - starts[thing]
        polygons = placement.shape.polygons
        if polygons is None:
            return CurvedPiece(frame, placement, part)
        part = _turned(polygons, part) if placement.mirrored else part
        face = placement.first + int(polygons.triangle_face[part])
        corners = [corner(thing, vertex) for vertex in polygons.triangle_vertex[part].tolist()]
        return facet_of(frame, placement, face, corners)

    return piece


def _turned(polygons: Polygons, triangle: int) -> int:
    """Return the triangle in the same place of its fan if that runs the other way round.

    So ``view.polygons`` has the fans of mirrored objects.
    """
    polygon = polygons.triangle_polygon
    first, end = (np.searchsorted(polygon, polygon[triangle], side) for side in ("left", "right"))
    return int(first + end) - 1 - triangle


# ---------------------------------------------------------------- the owners


def _owners(view: View, sample: Array, first: Array, piece: Ints, sure: Bools) -> Iterator[tuple[int, float]]:
    """Yield the owner of each sample, and its depth; their candidates begin at ``first``, then end."""
    frame = frame_of(view)
    pieces = _pieces_of(view, frame)
    for row, column, length, numbers, certain in _spans(view.width, sample, first, piece, sure):
        asked = [pieces(number) for number in numbers]
        i, j = frame.place(row, column)
        facet = _settled(asked) if all(certain) else None
        if facet is not None:
            yield from zip(repeat(facet.face), facet.depths(i, j, length), strict=False)
        else:
            yield from (_owner(frame, asked, certain, i + 2 * k, j) for k in range(length))


def _spans(
    width: int, sample: Array, first: Array, piece: Ints, sure: Bools
) -> Iterator[tuple[int, int, int, list[int], list[bool]]]:
    """Yield row, first column and length of spans of samples that have the same candidates, and those."""
    for low in range(0, len(sample), CHUNK):
        row, column = np.divmod(sample[low : low + CHUNK], width)
        bounds = first[low : low + CHUNK + 1]
        run, ends = slice(bounds[0], bounds[-1]), (bounds - bounds[0]).tolist()
        pieces, certain = piece[run].tolist(), sure[run].tolist()
        # Along a span the column grows as the index of the sample does.
        origin, index = column - np.arange(len(column)), 0
        asked = (
            (y, x, pieces[start:end], certain[start:end])
            for y, x, (start, end) in zip(row.tolist(), origin.tolist(), pairwise(ends), strict=True)
        )
        for (y, x, *question), alike in groupby(asked):
            length = sum(1 for _ in alike)
            yield y, x + index, length, *question
            index += length


def _settled(asked: list[Piece]) -> Facet | None:
    """Return the owner wherever all these cover a sample, if they are of one plane."""
    facets = [piece for piece in asked if isinstance(piece, Facet)]
    alike = len(facets) == len(asked) and all(facet.plane == facets[0].plane for facet in facets)
    return min(facets, key=attrgetter("face")) if alike else None


def _owner(frame: Frame, asked: list[Piece], sure: list[bool], i: int, j: int) -> tuple[int, float]:
    """Return which of some pieces owns a place, and its depth."""
    owner, curved = None, []
    for piece, certain in zip(asked, sure, strict=True):
        if isinstance(piece, CurvedPiece):
            curved.append(piece)
        elif (owner is None or piece.hides(owner, i, j)) and (certain or piece.covers(i, j)):
            owner = piece
    hit = min((hit for piece in curved for hit in piece.hits(i, j)), default=None)
    if hit and owner and not hit < Hit(owner.face, root_on_plane(owner.plane, frame.perspective, i, j)):
        hit = None
    if hit is not None:
        return hit.face, hit.depth(frame.unit)
    if owner is not None:
        return owner.face, next(owner.depths(i, j, 1))
    return BACKGROUND, inf
