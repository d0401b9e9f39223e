"""Rays for Embree: made, traced and read packet by packet, in compiled code on all threads.

A packet holds the rays of a square of samples, 4 x 4 or a single one, field by field: all x of the
origins, all y, and so on. That is how vector instructions want them, and Embree's ``RTCRayHit`` of 1 or
16 rays in memory (Wald, Woop, Benthin, Johnson & Ernst, "Embree: a kernel framework for efficient CPU ray
tracing", ACM Transactions on Graphics, 2014).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.base.jit import jit, parallel_jit, prange

ALIGNMENT = 64
"""Bytes to whose multiples Embree wants packets of 16 rays and their masks aligned."""

PACKET_SIDE = 4
"""Rows and columns of a packet of 16 rays."""

SHARES = 32
"""Shares of the image for the threads; share s has the rows of packets s, s + SHARES, ..."""

NOTHING = -1
"""Embree's id of no triangle and no geometry: all bits set."""


def packet_of(rays: int) -> np.dtype[Any]:
    """Return Embree's ``RTCRayHit`` for a number of rays, as a record of a multiple of ``ALIGNMENT`` bytes.

    Of the hit only the triangle is read; Embree writes the rest, too.
    """
    fields = [
        ("origin", np.float32, (3, rays)),
        ("nearest", np.float32, rays),
        ("direction", np.float32, (3, rays)),
        ("time", np.float32, rays),
        ("farthest", np.float32, rays),
        ("mask", np.int32, rays),
        ("id", np.int32, rays),
        ("flags", np.int32, rays),
        ("normal", np.float32, (3, rays)),
        ("place", np.float32, (2, rays)),
        ("triangle", np.int32, rays),
        ("geometry", np.int32, rays),
        ("instance", np.int32, (2, rays)),
    ]
    spare = ALIGNMENT - np.dtype(fields).itemsize % ALIGNMENT
    return np.dtype([*fields, ("spare", np.uint8, spare)])


def aligned(count: int, kind: np.dtype[Any]) -> Array:
    """Return an array (count,) of zeros that starts at a multiple of ``ALIGNMENT`` bytes."""
    room = np.zeros(count * kind.itemsize + ALIGNMENT, np.uint8)
    start = -room.ctypes.data % ALIGNMENT
    return room[start : start + count * kind.itemsize].view(kind)


class Sight(NamedTuple):
    """The rays of a picture, in world space, by six coordinates: three of the origin, three of the direction.

    Those of the sample at a row and a column are the sum of what the two contribute, rounded to float32.

    Attributes
    ----------
    of_row, of_column : (6, n) float64
        As many rows and columns as packets reach; that may be more than the image has.
    near : float
        The depth at which rays start; their directions are of depth 1.
    reach : float32
        The greatest distance that counts, in units of the direction; the least is 0. Both are closed.
    """

    of_row: Floats
    of_column: Floats
    near: float
    reach: np.float32


@parallel_jit
def trace(
    intersect: Callable[..., None],
    whereby: tuple[int, ...],
    query: int,
    sight: Sight,
    packets: Array,
    side: int,
    face_of: Ints,
    face: Ints,
    depth: Floats,
) -> None:
    """Have Embree find the nearest triangle of every sample's ray.

    Packets that reach beyond the image are traced whole.

    Parameters
    ----------
    intersect : C function
        ``rtcIntersect1`` or ``rtcIntersect16``.
    whereby : tuple of int
        What it wants to know before the packet: addresses of a mask, if any, and of Embree's scene.
    query : int
        What it wants to know after that: the address of its ``RTCIntersectArguments``.
    sight : Sight
    packets : (SHARES,) record
        Room for one packet a share, see :func:`packet_of`.
    side : int
        Rows and columns of a packet, 1 or ``PACKET_SIDE``.
    face_of : (n + 1,) int32
        Face of each triangle; the last is the background.
    face : (H, W) int32
        Receives the face id of every sample.
    depth : (H, W) float64
        Receives its depth, ``+inf`` for the background.
    """
    for share in prange(SHARES):
        packet, address = packets[share], packets.ctypes.data + share * packets.itemsize
        for top in range(share * side, face.shape[0], SHARES * side):
            for left in range(0, face.shape[1], side):
                _fill(packet, sight, side, top, left)
                intersect(*(whereby + (address, query)))  # noqa: RUF005 - Numba knows no other way
                _read(packet, sight.near, side, top, left, face_of, face, depth)


@jit
def _fill(packet: Any, sight: Sight, side: int, top: int, left: int) -> None:
    """Make the rays of the samples from (top, left), ``side`` rows and columns of them."""
    for axis in range(3):
        _add(packet["origin"][axis], sight, axis, side, top, left)
        _add(packet["direction"][axis], sight, axis + 3, side, top, left)
    for k in range(side * side):
        packet["nearest"][k], packet["farthest"][k] = 0.0, sight.reach
        packet["mask"][k], packet["triangle"][k], packet["geometry"][k] = -1, NOTHING, NOTHING


@jit
def _add(target: Array, sight: Sight, coordinate: int, side: int, top: int, left: int) -> None:
    """Add up one coordinate of the rays of the samples from (top, left)."""
    for row in range(side):
        for column in range(side):
            whole = sight.of_row[coordinate, top + row] + sight.of_column[coordinate, left + column]
            target[row * side + column] = whole


@jit
def _read(
    packet: Any, near: float, side: int, top: int, left: int, face_of: Ints, face: Ints, depth: Floats
) -> None:
    """Note faces and depths of the samples from (top, left) that lie within the image."""
    for row in range(top, min(top + side, face.shape[0])):
        for column in range(left, min(left + side, face.shape[1])):
            k = (row - top) * side + column - left
            triangle = packet["triangle"][k]
            face[row, column] = face_of[triangle]
            depth[row, column] = np.inf if triangle == NOTHING else near + np.float64(packet["farthest"][k])
