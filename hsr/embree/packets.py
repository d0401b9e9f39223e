"""Rays for Embree: made, traced and read packet by packet, in compiled code on all threads.

A packet holds the rays of a square of samples, 4 x 4 or a single one, field by field: all x of the
origins, all y, and so on. That is how vector instructions want them, and Embree's ``RTCRayHit`` of 1 or
16 rays in memory (Wald, Woop, Benthin, Johnson & Ernst, "Embree: a kernel framework for efficient CPU ray
tracing", ACM Transactions on Graphics, 2014).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

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

ROWS = 32
"""Rows of a packet, each a number of every ray: the 21 of Embree's ``RTCRayHit``, and some for alignment."""

ORIGIN, NEAREST, DIRECTION, FARTHEST, MASK, TRIANGLE, GEOMETRY = 0, 3, 4, 8, 9, 17, 18
"""First rows of what is set and read, float32, from the mask on int32; Embree writes more of a hit."""

Answer = tuple[Ints, Floats]
"""Face and depth (H, W)."""


def packets_of(rays: int) -> Array:
    """Return room (SHARES + 1, ROWS, rays) float32 for a packet a share and a mask, each of them aligned."""
    room = np.zeros((SHARES + 1) * ROWS * rays + ALIGNMENT // 4, np.float32)
    start = -room.ctypes.data % ALIGNMENT // 4
    return room[start : start + (SHARES + 1) * ROWS * rays].reshape(SHARES + 1, ROWS, rays)


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
    face_of: Ints,
    answer: Answer,
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
    packets : (SHARES + 1, ROWS, rays) float32
        Room for one packet a share, see :func:`packets_of`.
    face_of : (n + 1,) int32
        Face of each triangle; the last is the background.
    answer : face (H, W) int32 and depth (H, W) float64
        Receive the face id of every sample and its depth, ``+inf`` for the background.
    """
    (height, width), side = answer[0].shape, 1 if packets.shape[2] == 1 else PACKET_SIDE
    for share in prange(SHARES):
        packet, address = packets[share], packets[share].ctypes.data
        for top in range(share * side, height, SHARES * side):
            for left in range(0, width, side):
                _fill(packet, sight, side, top, left)
                intersect(*(whereby + (address, query)))  # noqa: RUF005 - Numba knows no other way
                _read(packet, sight.near, side, top, left, face_of, answer)


@jit
def _fill(packet: Array, sight: Sight, side: int, top: int, left: int) -> None:
    """Make the rays of the samples from (top, left), ``side`` rows and columns of them."""
    for axis in range(6):
        target = packet[ORIGIN + axis if axis < 3 else DIRECTION - 3 + axis]
        for row in range(side):
            for column in range(side):
                whole = sight.of_row[axis, top + row] + sight.of_column[axis, left + column]
                target[row * side + column] = whole
    packet[NEAREST], packet[FARTHEST] = 0.0, sight.reach
    ids = packet.view(np.int32)
    ids[MASK], ids[TRIANGLE], ids[GEOMETRY] = -1, NOTHING, NOTHING


@jit
def _read(packet: Array, near: float, side: int, top: int, left: int, face_of: Ints, answer: Answer) -> None:
    """Note faces and depths of the samples from (top, left) that lie within the image."""
    (face, depth), triangles = answer, packet.view(np.int32)[TRIANGLE]
    for row in range(top, min(top + side, face.shape[0])):
        for column in range(left, min(left + side, face.shape[1])):
            k = (row - top) * side + column - left
            face[row, column] = face_of[triangles[k]]
            missed = triangles[k] == NOTHING
            depth[row, column] = np.inf if missed else near + np.float64(packet[FARTHEST, k])
