"""Embree, stage by stage, as far as it can be followed.

==============  ==============================================================================
Stage           Model: the exact answer for
==============  ==============================================================================
tessellation    curved shapes replaced by polygons
input rounding  the corners in world space, rounded to float32
transform       the same corners and the rays, rounded to float32
intersector     (Embree's own test of a ray with a triangle, in its arithmetic)
==============  ==============================================================================

The last model tests every triangle. Of several at equal distances Embree takes the one it comes to last,
which its hierarchy decides, and whether it goes through it with single rays or packets; the model takes
from Embree which of them it is. Whole maps would take the model too long.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache

import numpy as np

from hsr.algorithms.embree import Options, handed_over, rays, render
from hsr.base.arrays import Array, Ints
from hsr.exact.oracle import owners
from hsr.models.embree.float32 import MISS, distances
from hsr.models.embree.lines import may_meet
from hsr.models.rounded import TESSELLATED, of_polygons
from hsr.models.stages import Pipeline, at_samples, named, rerun
from hsr.problem.map import BACKGROUND
from hsr.problem.view import View

FARTHEST = float(np.finfo(np.float32).max)
"""Stands for an infinite far."""

TIE = BACKGROUND - 1
"""In place of a face where exact arithmetic finds several."""

RENDERED = rerun(render)


def input_rounding(view: View, options: Options, samples: Array) -> Ints:  # noqa: ARG001
    """Model the rounding of world points to float32."""
    view = view.tessellated()
    polygons = replace(view.polygons, vertices=view.polygons.vertices.astype(np.float32))
    return owners(of_polygons(view, polygons, np.ones(len(polygons), dtype=np.bool_)), samples)


def transform(view: View, options: Options, samples: Array) -> Ints:
    """Model the rounding of rays to float32: the nearest triangle in rational arithmetic.

    Where the rounded ray meets an edge exactly, or two triangles equally far away, it says nothing
    new: then the answer for the unrounded ray stands.
    """
    vertices, corner, face = handed_over(view)
    corners, reach = vertices[corner], min(view.far - view.near, FARTHEST)
    rays_of = _rays_of(view, samples)
    shown = np.array([_exact_nearest(corners, face, *ray, reach) for ray in rays_of], dtype=np.int32)
    tied = np.flatnonzero(shown == TIE)
    if len(tied):
        shown[tied] = input_rounding(view, options, samples[tied])
    return shown


def intersector(view: View, options: Options, samples: Array) -> Ints:
    """Model Embree's test of a ray with a triangle."""
    vertices, corner, face = handed_over(view)
    corners, reach = vertices[corner], np.float32(view.far - view.near)
    own = at_samples(RENDERED, view, options, samples)
    at = (distances(*ray, corners, reach) for ray in _rays_of(view, samples))
    return np.array([_nearest(t, face, shown) for t, shown in zip(at, own, strict=True)], dtype=np.int32)


def _nearest(t: Array, face: Ints, shown: int) -> int:
    """Return the face of the nearest triangle: if there are several, ``shown``, or else the lowest."""
    least = t.min(initial=MISS)
    if least == MISS:
        return BACKGROUND
    nearest = face[t == least]
    return shown if shown in nearest else int(nearest.min())


# ---------------------------------------------------------------- rays


@lru_cache(maxsize=1)
def _all_rays(view: View) -> tuple[Array, Array]:
    _, origins, directions = zip(*rays(view), strict=True)
    return np.concatenate(origins), np.concatenate(directions)


def _rays_of(view: View, samples: Array) -> Iterator[tuple[Array, Array]]:
    """Yield origin and direction (3,) float32 of each sample's ray."""
    origins, directions = _all_rays(view)
    yield from zip(origins[samples], directions[samples], strict=True)


# ---------------------------------------------------------------- one ray in exact arithmetic


def _exact_nearest(corners: Array, face: Ints, origin: Array, direction: Array, reach: float) -> int:
    """Return the face of the nearest triangle that a ray meets; ``TIE`` if it is not the only one."""
    near_by = np.flatnonzero(may_meet(corners, origin, direction))
    hits = [(*_exact_hit(corners[i], origin, direction), int(face[i])) for i in near_by]
    met = sorted(hit for hit in hits if 0 <= hit[0] <= Fraction(float(np.float32(reach))))
    if not met:
        return BACKGROUND
    (nearest, on_edge, shown), *others = met
    return TIE if on_edge or (others and others[0][0] == nearest) else shown


def _exact_hit(corners: Array, origin: Array, direction: Array) -> tuple[Fraction, bool]:
    """Return the distance of a triangle along a ray, and whether the ray meets its edge; -1 for a miss."""
    d, start = _exact(direction), _exact(origin)
    a, b, c = ([p - o for p, o in zip(_exact(corner), start, strict=True)] for corner in corners)
    sides = [_volume(p, q, d) for p, q in ((b, c), (c, a), (a, b))]
    # The volumes that the edges span with the direction add up to the normal's part along it.
    total = sum(sides)
    if total == 0 or min(sides) < 0 < max(sides):
        return Fraction(-1), False
    return _volume(a, b, c) / total, 0 in sides


def _exact(vector: Array) -> list[Fraction]:
    return [Fraction(number) for number in vector.tolist()]


def _volume(p: Sequence[Fraction], q: Sequence[Fraction], r: Sequence[Fraction]) -> Fraction:
    """Return (p x q) . r."""
    (a, b, c), (d, e, f), (g, h, i) = p, q, r
    return (b * f - c * e) * g + (c * d - a * f) * h + (a * e - b * d) * i


PIPELINE = Pipeline((TESSELLATED, *named(input_rounding, transform, intersector)), None)
