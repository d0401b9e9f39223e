"""From samples and the pieces that may own them to owners and depths."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import groupby
from math import inf
from operator import itemgetter
from typing import cast

import numpy as np

from hsr.algorithms.resolve.curved import CurvedPiece, Hit, curved_piece, root_on_plane, sights_of
from hsr.algorithms.resolve.facets import Corner, Facet, corner_of, facet_of
from hsr.algorithms.resolve.frame import Frame, frame_of
from hsr.arrays import Array, Bools, Floats, Ints
from hsr.scene.shapes import Polygons
from hsr.viewing import Placement, View
from hsr.visibility import BACKGROUND

CHUNK = 2**17
"""Candidates turned to Python's numbers at a time: each takes some hundred bytes."""

KEPT = 2**15
"""Pieces, and corners of pieces, that are kept: each takes up to some 3 kB."""

OWNER = np.dtype([("sample", np.int64), ("face", np.int32), ("depth", np.float64)])
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


def first_pieces(view: View) -> Array:
    """Return where the pieces of each object of a view begin.

    An object of planar faces has the triangles of its polygons' fans, in the order of
    ``shape.polygons.triangle_vertex``; a sphere is 1 piece, a cylinder 3 (side, base, cap). For a view
    without curved shapes the pieces are the triangles of ``view.polygons``.

    Parameters
    ----------
    view : View

    Returns
    -------
    (objects + 1,) int64
        The first piece of each object, in the order of ``view.placements``, and the number of pieces.
    """
    counts = [_piece_count(placement) for placement in view.placements]
    return np.cumsum([0, *counts], dtype=np.int64)


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
    order = np.argsort(sample, kind="stable")
    frame, piece_of = _pieces_of(view, piece)
    candidates = _candidates(sample[order], piece[order], sure[order])
    found = np.fromiter(_owners(frame, piece_of, candidates), OWNER)
    return Resolved(found["sample"], found["face"], found["depth"])


def facets_at(view: View, piece: Ints) -> tuple[Frame, list[Facet]]:
    """Set up planar pieces exactly, for methods that cannot do it in float64.

    Parameters
    ----------
    view : View
    piece : (n,) int, at least one

    Returns
    -------
    frame : Frame
        The integers in which the view is measured.
    facets : list of n Facet
    """
    frame, piece_of = _pieces_of(view, piece)
    return frame, [cast(Facet, piece_of(number)) for number in piece.tolist()]


def sights_at(view: View, things: Array) -> tuple[Frame, Array, Array, Array]:
    """Carry the lines of sight exactly into the spaces of some objects, for methods that meet them there.

    Parameters
    ----------
    view : View
    things : (n,) int64
        Indices of objects, each once.

    Returns
    -------
    frame : Frame
        The integers in which the view is measured.
    origin, step, scale
        See :func:`hsr.algorithms.resolve.curved.sights_of`.
    """
    frame = frame_of(view, things.tolist())
    return frame, *sights_of(frame, things.tolist())


# ---------------------------------------------------------------- the pieces

Piece = Facet | CurvedPiece


def _pieces_of(view: View, piece: Ints) -> tuple[Frame, Callable[[int], Piece]]:
    """Return the frame of the objects of some pieces (n,), and what sets up each piece when first asked."""
    starts = first_pieces(view)
    things = np.flatnonzero(np.bincount(np.searchsorted(starts, piece, side="right") - 1))
    frame = frame_of(view, things.tolist())
    corner = lru_cache(KEPT)(partial(_corner, view, frame))
    return frame, lru_cache(KEPT)(partial(_piece, view, frame, starts.tolist(), corner))


def _corner(view: View, frame: Frame, thing: int, vertex: int) -> Corner:
    polygons = view.placements[thing].shape.polygons
    assert polygons is not None, "spheres and cylinders have no vertices"
    return corner_of(frame.matrices[thing], polygons.vertices[vertex].tolist())


def _piece(
    view: View, frame: Frame, starts: list[int], corner: Callable[[int, int], Corner], number: int
) -> Piece:
    """Set up a piece; those of each object begin at ``starts``."""
    thing = bisect_right(starts, number) - 1
    placement, part = view.placements[thing], number - starts[thing]
    polygons = placement.shape.polygons
    if polygons is None:
        return curved_piece(frame, thing, placement, part)
    if placement.mirrored:
        part = _turned(polygons, part)
    face = placement.first + int(polygons.face[polygons.triangle_polygon[part]])
    a, b, c = polygons.triangle_vertex[part].tolist()
    return facet_of(frame, placement, face, (corner(thing, a), corner(thing, b), corner(thing, c)))


def _turned(polygons: Polygons, triangle: int) -> int:
    """Return the triangle in the same place of its fan if that runs the other way round.

    So ``view.polygons`` has the fans of mirrored objects.
    """
    polygon = polygons.triangle_polygon
    first, end = (np.searchsorted(polygon, polygon[triangle], side) for side in ("left", "right"))
    return int(first + end) - 1 - triangle


# ---------------------------------------------------------------- the owners

Candidate = tuple[int, int, bool]
"""A sample, the number of a piece that may own it, and whether that is sure."""


def _candidates(sample: Array, piece: Ints, sure: Bools) -> Iterator[Candidate]:
    """Yield the candidates (m,), turned to Python's numbers in chunks."""
    for low in range(0, len(sample), CHUNK):
        run = slice(low, low + CHUNK)
        yield from zip(sample[run].tolist(), piece[run].tolist(), sure[run].tolist(), strict=True)


def _owners(
    frame: Frame, piece_of: Callable[[int], Piece], candidates: Iterator[Candidate]
) -> Iterator[tuple[int, int, float]]:
    """Yield each sample, its owner and its depth."""
    for sample, run in groupby(candidates, key=itemgetter(0)):
        i, j = frame.place(sample)
        owner, curved = None, []
        for _, number, sure in run:
            piece = piece_of(number)
            if isinstance(piece, CurvedPiece):
                curved.append(piece)
            elif (owner is None or piece.hides(owner, i, j)) and (sure or piece.covers(i, j)):
                owner = piece
        hit = _first_hit(frame, curved, owner, i, j) if curved else None
        if hit is not None:
            yield sample, hit.face, hit.depth(frame.unit)
        elif owner is not None:
            yield sample, owner.face, owner.depth_at(i, j)
        else:
            yield sample, BACKGROUND, inf


def _first_hit(frame: Frame, curved: list[CurvedPiece], facet: Facet | None, i: int, j: int) -> Hit | None:
    """Return the first hit of curved pieces, unless a planar piece hides them all."""
    hit = min((hit for piece in curved for hit in piece.hits(i, j)), default=None)
    if hit is None or facet is None:
        return hit
    return hit if hit < Hit(facet.face, root_on_plane(facet.plane, frame.perspective, i, j)) else None
