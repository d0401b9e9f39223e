"""What certified methods that fill tiles of keys share: room for doubts, and the exact answers to them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.certify import resolve
from hsr.kernels.zbuffer import fill
from hsr.kernels.zbuffer.setup import Eye, nearness_at
from hsr.kernels.zbuffer.tiles import COUNTS
from hsr.problem.map import depth_format
from hsr.problem.view import View

NO_DOUBTS = np.empty(0, fill.DOUBT)


def filled(
    todo: Array, room: int, certified: bool, fill_tiles: Callable[[Array, Array | None, Array], None]
) -> Iterator[tuple[Array, Array]]:
    """Fill tiles, once more those whose doubts found no room; yield doubts (m,) and counts (COUNTS,).

    Parameters
    ----------
    todo : (T, 4) int64
        The tiles, see :func:`hsr.kernels.zbuffer.tiles.deal`.
    room : int
        Doubts of a tile for which there is room at first.
    certified : bool
        Whether doubts are noted.
    fill_tiles : callable
        Fills the tiles it is given; receives doubts (T, room) or None, and counts (T, COUNTS).
    """
    while len(todo):
        counts = np.zeros((len(todo), COUNTS), np.int64)
        noted = np.empty((len(todo), room), fill.DOUBT) if certified else None
        fill_tiles(todo, noted, counts)
        used = counts[:, fill.USED].tolist()
        parts = [] if noted is None else [noted[k, :n] for k, n in enumerate(used) if 0 < n <= room]
        again = [k for k, n in enumerate(used) if n > room]
        counts[again] = 0
        yield np.concatenate([NO_DOUBTS, *parts]), counts.sum(axis=0)
        # Settling a tile at most doubles its doubts.
        todo, room = todo[again], 2 * max(used)


def decide(view: View, found: Array, piece: Ints, answer: tuple[Ints, Floats]) -> int:
    """Decide the samples in doubt exactly, write them into face and depth (H, W), and return how many.

    Parameters
    ----------
    view : View
    found : (m,) DOUBT
    piece : (m,) int32
        What each doubt is about, see :func:`hsr.certify.resolve`.
    answer : (face, depth)
    """
    face, depth = answer
    resolved = resolve(view, found["sample"], piece, found["sure"])
    face.ravel()[resolved.sample], depth.ravel()[resolved.sample] = resolved.face, resolved.depth
    return len(resolved.sample)


def numbers_of(found: Array, count: int) -> Ints:
    """Return which of so many triangles or pieces each doubt (m,) is about."""
    return np.asarray(found["key"] & number_bits(count))


def number_bits(count: int) -> int:
    """Return the bits of a key that tell so many triangles apart."""
    return int(fill.EMPTY) - int(fill.depth_mask(count))


def format_of(view: View, count: int, eye: Eye) -> dict[str, Any]:
    """Describe the key depths of so many triangles as window depths, 0 at near and 1 at far."""
    step = (number_bits(count) + 1.0) * 2.0**-63 / eye.scale
    whole = nearness_at(view.near, view.perspective) - nearness_at(view.far, view.perspective)
    # Near and far may be too close to each other for more than one step.
    share = step / whole if whole > step else 1.0
    return depth_format("window", share, view.near, view.far, view.perspective)
