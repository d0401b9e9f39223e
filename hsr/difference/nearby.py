"""The faces near some samples: all that their lines of sight meet, or miss by less than a pixel."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hsr.base.arrays import Array, Ints, ranges
from hsr.base.errors import ViewError
from hsr.problem.view import Placement, View
from hsr.scene.shapes import Kind, Polygons, Shape

REACH = 1.0
"""Pixels by which a sample may miss a face that is still near it."""

ROUNDING = 2.0**-49
"""Bound of the relative error of a screen coordinate in :func:`_boxes`, 16 u with u = 2^-53.

A row of the transform carries four roundings, its product with a point four more, the quotient and what
turns it into pixels four (Higham, Accuracy and Stability of Numerical Algorithms, section 3.1). The rest is
for the bound's own, and for dividing by a rounded w, which is at least twice its error.
"""


class Nearby(NamedTuple):
    """What is left of a view if only the faces near some samples are looked at.

    Of meshes the polygons that may come near are left, each a face of its own; other shapes stay whole.

    Attributes
    ----------
    samples : (n,) int64
        Numbers ``row * W + column``, ascending, each once.
    view : View
        The same camera and size; possibly no object at all.
    origin : (faces,) int32
        Face of the whole view that each of its faces is.
    sample : (m,) int64
    face : (m,) int32
        A planar face of ``view`` and a sample that it may come within a pixel of; ascending by sample,
        then by face. Nothing is said of curved faces.
    """

    samples: Array
    view: View
    origin: Ints
    sample: Array
    face: Ints


def faces_nearby(view: View, samples: Array) -> Nearby:
    """Leave only the faces that come within a pixel of some samples, and perhaps a few more.

    Parameters
    ----------
    view : View
    samples : (n,) int
        Numbers ``row * W + column``.

    Returns
    -------
    Nearby
    """
    samples = np.unique(np.asarray(samples, dtype=np.int64))
    placements: list[Placement] = []
    origin = [np.zeros(0, dtype=np.int32)]
    pairs = [np.zeros((2, 0), dtype=np.int64)]
    first = 0
    for placement in view.placements:
        shape, own, sample, face = _shape_near(view, placement, samples)
        if len(own):
            placements.append(replace(placement, shape=shape, first=first))
            origin.append(own + np.int32(placement.first))
            pairs.append(np.stack([sample, face + first]))
            first += len(own)
    sample, face = np.concatenate(pairs, axis=1)
    order = np.lexsort((face, sample))
    left = replace(view, placements=tuple(placements))
    return Nearby(samples, left, np.concatenate(origin), sample[order], face[order].astype(np.int32))


def check_sample(view: View, x: int, y: int) -> None:
    """Raise :class:`hsr.base.errors.ViewError` if there is no such sample; row y = 0 is the top row."""
    if not (0 <= y < view.height and 0 <= x < view.width):
        size = f"{view.width}x{view.height}"
        raise ViewError(f"no sample at column {x}, row {y}: the image is {size}, counted from 0")


def _shape_near(view: View, placement: Placement, samples: Array) -> tuple[Shape, Ints, Array, Array]:
    """Return what is left of an object's shape, its faces' numbers in the whole shape, and the pairs."""
    shape, polygons = placement.shape, placement.shape.polygons
    everything = np.arange(shape.faces, dtype=np.int32)
    if polygons is None:
        nothing = np.zeros(0, dtype=np.int64)
        return shape, everything, nothing, nothing
    polygon, sample = _in_boxes(_boxes(view, placement, polygons), samples, view.width)
    if shape.kind != Kind.MESH:
        return shape, everything[: shape.faces if len(polygon) else 0], sample, polygon
    chosen, number = np.unique(polygon, return_inverse=True)
    part = polygons.part(chosen)
    own = replace(part, face=np.arange(len(chosen), dtype=np.int32))
    return Shape(Kind.MESH, shape.label, own), part.face, sample, number


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def _boxes(view: View, placement: Placement, polygons: Polygons) -> Array:
    """Bound the samples that polygons may come within a pixel of.

    A projection is the hull of its projected corners if all are in front of the eye. What lies behind it
    is nowhere, and what reaches through its plane, or overflows, may be anywhere.

    Returns
    -------
    (P, 4) int64
        First row, first column, last row, last column; none where the last is less than the first.
    """
    matrix = view.clip_from_world[[0, 1, 3]]
    rows, greatest = (both(matrix) @ both(placement.world_from_object) for both in (np.asarray, np.abs))
    x, y, w = rows[:, :3] @ polygons.vertices.T + rows[:, 3:]
    error = ROUNDING * (greatest[:, :3] @ np.abs(polygons.vertices.T) + greatest[:, 3:])
    ahead, nowhere = w > 2.0 * error[2], w < -error[2]
    first, corner = polygons.start[:-1], polygons.corner
    ends = []
    for value, slack, size in ((-y, error[1], view.height), (x, error[0], view.width)):
        share = value / w
        place = (share + 1.0) * (size / 2.0) - 0.5
        margin = REACH + ((slack + np.abs(share) * error[2]) / w + ROUNDING) * (size / 2.0)
        bounded = ahead & np.isfinite(margin)
        low = np.minimum.reduceat(np.where(bounded, place - margin, -np.inf)[corner], first)
        high = np.maximum.reduceat(np.where(bounded, place + margin, np.inf)[corner], first)
        ends.append((np.clip(np.ceil(low), 0, size), np.clip(np.floor(high), -1, size - 1)))
    (top, bottom), (left, right) = ends
    box = np.stack([top, left, bottom, right], axis=1).astype(np.int64)
    box[np.logical_and.reduceat(nowhere[corner], first), 2:] = -1
    return box


def _in_boxes(box: Array, samples: Array, width: int) -> tuple[Array, Array]:
    """Find the samples, ascending, in boxes (P, 4): pairs of a box's place and a sample."""
    used = np.unique(samples // width)
    which, row = ranges(np.searchsorted(used, box[:, 0]), np.searchsorted(used, box[:, 2], side="right"))
    begin = used[row] * width
    first = np.searchsorted(samples, begin + box[which, 1])
    last = np.searchsorted(samples, begin + box[which, 3], side="right")
    span, place = ranges(first, last)
    return which[span], samples[place]
