"""From samples and the pieces that may own them to owners and depths."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from hsr.algorithms.resolve.curved import CurvedPiece, Hit, curved_piece, root_on_plane, sights_of
from hsr.algorithms.resolve.facets import Facets, facets_of, joined
from hsr.algorithms.resolve.frame import Frame, frame_of
from hsr.arrays import Array, Bools, Floats, Ints
from hsr.viewing import Placement, View
from hsr.visibility import BACKGROUND

CHUNK = 2**17
"""Candidates decided at a time: a piece takes up to some 3 kB, a candidate some hundred bytes."""


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
    ordered = sample[order].astype(np.int64)
    first = _firsts(ordered)
    candidates = Candidates(ordered[first], first, piece[order], sure[order])
    frame, starts = frame_of(view), first_pieces(view)
    answers = []
    for chunk in _chunks(candidates):
        pieces = _pieces_of(view, frame, starts, chunk.piece)
        answers.append(_decide(frame, pieces, chunk))
    face, depth = (np.concatenate(column) for column in zip(*answers, strict=True))
    return Resolved(candidates.sample, face, depth)


def facets_at(view: View, piece: Ints) -> tuple[Frame, Facets]:
    """Set up planar pieces exactly, for methods that cannot do it in float64.

    Parameters
    ----------
    view : View
    piece : (n,) int, ascending, at least one

    Returns
    -------
    frame : Frame
        The integers in which the view is measured.
    facets : Facets
        One a piece.
    """
    frame = frame_of(view)
    facets = _pieces_of(view, frame, first_pieces(view), piece).facets
    assert facets is not None, "curved pieces are no facets"
    return frame, facets


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
        See :func:`hsr.algorithms.resolve.curved.sights_of`.
    """
    frame = frame_of(view)
    return frame, *sights_of(frame, things)


class Candidates(NamedTuple):
    """Pieces that may own samples, sample after sample.

    Attributes
    ----------
    sample : (n,) int64
    first : (n,) int64
        First candidate of each sample.
    piece : (m,) int32
    sure : (m,) bool
    """

    sample: Array
    first: Array
    piece: Ints
    sure: Bools

    @property
    def at(self) -> Array:
        """Index (m,) of the sample of each candidate."""
        many = np.diff(self.first, append=len(self.piece))
        return np.repeat(np.arange(len(self.sample)), many)


def _chunks(candidates: Candidates) -> Iterator[Candidates]:
    """Cut into runs of whole samples, of about CHUNK candidates each."""
    sample, first, piece, sure = candidates
    ends = np.append(first, len(piece))
    cuts = np.unique(np.searchsorted(first, np.arange(0, len(piece), CHUNK)))
    for low, high in zip(cuts, [*cuts[1:], len(sample)], strict=True):
        run = slice(ends[low], ends[high])
        yield Candidates(sample[low:high], first[low:high] - ends[low], piece[run], sure[run])


# ---------------------------------------------------------------- the pieces


@dataclass(frozen=True, eq=False)
class Pieces:
    """The pieces that occur.

    Attributes
    ----------
    facets : Facets or None
        The planar ones, if there are any.
    facet : (m,) int64
        Index among them of the piece of each candidate; -1 for curved pieces.
    curved : dict of int to CurvedPiece
    """

    facets: Facets | None
    facet: Array
    curved: dict[int, CurvedPiece]


def _pieces_of(view: View, frame: Frame, starts: Array, piece: Ints) -> Pieces:
    """Set up the pieces that occur; those of each object begin at ``starts``."""
    occurring, which = np.unique(piece, return_inverse=True)
    thing = np.searchsorted(starts, occurring, side="right") - 1
    is_curved = np.zeros(len(occurring), dtype=bool)
    planar: list[Facets] = []
    curved: dict[int, CurvedPiece] = {}
    first = _firsts(thing)
    for own in map(slice, first, [*first[1:], len(thing)]):
        k = thing[own.start]
        placement, part = view.placements[k], occurring[own] - starts[k]
        if placement.shape.curved:
            curved |= {int(starts[k] + p): curved_piece(frame, k, placement, int(p)) for p in part}
            is_curved[own] = True
        else:
            planar.append(facets_of(frame, k, placement, part))
    facet = np.where(is_curved, -1, np.cumsum(~is_curved) - 1)[which]
    return Pieces(joined(planar) if planar else None, facet, curved)


# ---------------------------------------------------------------- the owners


def _decide(frame: Frame, pieces: Pieces, candidates: Candidates) -> tuple[Ints, Floats]:
    """Return the owner (n,) of each sample, and its depth."""
    i, j = frame.place(candidates.sample)
    face, depth = np.full(len(i), BACKGROUND, np.int32), np.full(len(i), np.inf)
    nearest = np.full(len(i), -1)
    if pieces.facets is not None:
        nearest = _nearest_facets(pieces.facets, pieces.facet, candidates, i, j)
        owned = np.flatnonzero(nearest >= 0)
        face[owned] = pieces.facets.face[nearest[owned]]
        depth[owned] = pieces.facets.depth_at(nearest[owned], i[owned], j[owned])
    for k, curved in _curved_candidates(pieces, candidates):
        hits = [hit for piece in curved for hit in piece.hits(i[k], j[k])]
        if pieces.facets is not None and nearest[k] >= 0:
            plane = pieces.facets.plane[nearest[k]]
            hits.append(Hit(face[k], root_on_plane(plane, frame.perspective, i[k], j[k])))
        owner = min(hits, default=None)
        if owner is not None and owner.line is not None:
            face[k], depth[k] = owner.face, owner.depth(frame.unit)
    return face, depth


def _nearest_facets(facets: Facets, facet: Array, candidates: Candidates, i: Array, j: Array) -> Array:
    """Return the index (n,) of the nearest planar piece at each sample, -1 where there is none."""
    which, at, sure = facet, candidates.at, candidates.sure
    asked = np.flatnonzero(facet >= 0)
    asked = asked[~_idle(facets, which[asked], at[asked], sure[asked])]
    asked = asked[facets.covers(which[asked], i[at[asked]], j[at[asked]], sure[asked])]
    which, at = which[asked], at[asked]
    first = _firsts(at)
    nearest = np.full(len(i), -1)
    nearest[at[first]] = which[facets.nearest(which, i[at], j[at], first)]
    return nearest


def _idle(facets: Facets, which: Array, at: Array, sure: Bools) -> Bools:
    """Tell which candidates (m,) need not be looked at: higher faces where all are sure and of one plane."""
    first = _firsts(at)
    group = np.repeat(np.arange(len(first)), np.diff(first, append=len(at)))
    plane, face = facets.plane_id[which], facets.face[which]
    settled = np.minimum.reduceat(plane, first) == np.maximum.reduceat(plane, first)
    settled &= np.logical_and.reduceat(sure, first)
    idle: Bools = settled[group] & (face > np.minimum.reduceat(face, first)[group])
    return idle


def _firsts(at: Array) -> Array:
    """Return where each run of equal numbers (m,) begins."""
    return np.flatnonzero(np.diff(at, prepend=-1))


def _curved_candidates(pieces: Pieces, candidates: Candidates) -> Iterator[tuple[int, list[CurvedPiece]]]:
    """Yield the samples that have curved candidates, and these."""
    curved = np.flatnonzero(pieces.facet < 0)
    pairs = zip(candidates.at[curved].tolist(), candidates.piece[curved].tolist(), strict=True)
    for k, run in groupby(pairs, key=itemgetter(0)):
        yield k, [pieces.curved[piece] for _, piece in run]
