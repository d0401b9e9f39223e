"""A bounding-volume hierarchy over boxes: sort along a Morton curve, halve where the codes part.

The linear hierarchy of Lauterbach et al., "Fast BVH Construction on GPUs" (Eurographics 2009): the
boxes are sorted by the Morton code of their centres, and a run of them is cut where the highest bit
that differs within it flips. Children are numbered after their parent, so that one backward pass
over the nodes visits children first.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hsr.arrays import Array, Floats, Ints
from hsr.jit import jit

LEAF = 8
"""Most boxes in one leaf."""

INNER = -1
"""The ``count`` of a node that is no leaf."""

AXIS_BITS = 10
CELLS = 1 << AXIS_BITS
"""Cells of the Morton curve along each axis; a code has three times ten bits."""

STACK = 64
"""Room for the nodes that wait in a walk: 30 levels of code bits, and 31 halvings of equal codes."""


class Tree(NamedTuple):
    """The nodes of one or more hierarchies over n boxes in the order of the leaves.

    Attributes
    ----------
    first : (m,) int32
        Of a leaf: its first box. Of an inner node: its first child; the second is the next node.
    count : (m,) int32
        Boxes in a leaf, ``INNER`` for an inner node.
    low, high : (m, 3) float64
        The box around everything below the node, closed; low > high if there is nothing.
    """

    first: Ints
    count: Ints
    low: Floats
    high: Floats


@jit
def build(low: Floats, high: Floats) -> tuple[Ints, Tree]:
    """Build the hierarchy over boxes.

    Parameters
    ----------
    low, high : (n, 3) float64
        Opposite corners of the boxes, low <= high, finite. Without boxes the root is an empty leaf.

    Returns
    -------
    order : (n,) int32
        The boxes in the order of the leaves.
    tree : Tree
        Its root is node 0.
    """
    code, order = radix_sort(morton_codes(low, high))
    first, count = split(code)
    node_low, node_high = fit(low, high, order, first, count)
    return order, Tree(first, count, node_low, node_high)


@jit
def boxes_of(vertices: Floats, corner: Ints) -> tuple[Floats, Floats]:
    """Return the opposite corners (n, 3) of the boxes around triangles of vertex indices (n, 3)."""
    n = len(corner)
    low, high = np.empty((n, 3)), np.empty((n, 3))
    for i in range(n):
        for axis in range(3):
            a = vertices[corner[i, 0], axis]
            b = vertices[corner[i, 1], axis]
            c = vertices[corner[i, 2], axis]
            low[i, axis] = min(a, b, c)
            high[i, axis] = max(a, b, c)
    return low, high


@jit
def morton_codes(low: Floats, high: Floats) -> Array:
    """Return the Morton code (n,) uint32 of every box's centre in the cube around the centres."""
    n = len(low)
    start, cell = np.empty(3), np.empty(3)
    for axis in range(3):
        # Twice the centre is as good as the centre: only its place in the range counts.
        least, most = np.inf, -np.inf
        for i in range(n):
            centre = low[i, axis] + high[i, axis]
            least, most = min(least, centre), max(most, centre)
        start[axis] = least
        cell[axis] = CELLS / (most - least) if most > least else 0.0

    code = np.empty(n, np.uint32)
    for i in range(n):
        mixed = np.uint32(0)
        for axis in range(3):
            place = (low[i, axis] + high[i, axis] - start[axis]) * cell[axis]
            mixed |= spread(np.uint32(min(place, CELLS - 1.0))) << np.uint32(axis)
        code[i] = mixed
    return code


@jit
def spread(bits: np.uint32) -> np.uint32:
    """Move bit k of a ten-bit number to bit 3 k."""
    bits = (bits | (bits << np.uint32(16))) & np.uint32(0x030000FF)
    bits = (bits | (bits << np.uint32(8))) & np.uint32(0x0300F00F)
    bits = (bits | (bits << np.uint32(4))) & np.uint32(0x030C30C3)
    return (bits | (bits << np.uint32(2))) & np.uint32(0x09249249)


@jit
def radix_sort(code: Array) -> tuple[Array, Ints]:
    """Sort 30-bit codes by three stable counting sorts of ten bits each.

    Returns
    -------
    code : (n,) uint32, ascending
    order : (n,) int32
        Where each of them stood; equal codes keep their order.
    """
    n = len(code)
    order = np.arange(n).astype(np.int32)
    next_code, next_order = np.empty_like(code), np.empty_like(order)
    for digit in range(3):
        shift, mask = np.uint32(AXIS_BITS * digit), np.uint32(CELLS - 1)
        place = np.zeros(CELLS + 1, np.int32)
        for i in range(n):
            place[((code[i] >> shift) & mask) + 1] += 1
        for k in range(CELLS):
            place[k + 1] += place[k]
        for i in range(n):
            k = (code[i] >> shift) & mask
            next_code[place[k]], next_order[place[k]] = code[i], order[i]
            place[k] += 1
        code, next_code = next_code, code
        order, next_order = next_order, order
    return code, order


@jit
def split(code: Array) -> tuple[Ints, Ints]:
    """Cut the sorted codes into a tree; see ``first`` and ``count`` of :class:`Tree`."""
    n = len(code)
    first, count = np.empty(max(2 * n, 1), np.int32), np.empty(max(2 * n, 1), np.int32)
    pending = np.empty((STACK, 3), np.int64)
    pending[0] = 0, 0, n
    nodes, depth = 1, 1
    while depth > 0:
        depth -= 1
        node, start, end = pending[depth]
        if end - start <= LEAF:
            first[node], count[node] = start, end - start
            continue
        middle = parting(code, start, end)
        first[node], count[node] = nodes, INNER
        pending[depth] = nodes + 1, middle, end
        pending[depth + 1] = nodes, start, middle
        nodes += 2
        depth += 2
    return first[:nodes].copy(), count[:nodes].copy()


@jit
def parting(code: Array, start: int, end: int) -> int:
    """Return where the highest bit that differs within ``code[start:end]`` flips; else the middle."""
    differing = code[start] ^ code[end - 1]
    if differing == 0:
        return (start + end) // 2
    bit = np.uint32(0)
    while (differing >> bit) > 1:
        bit += np.uint32(1)
    low, high = start, end - 1
    while low < high:
        middle = (low + high) // 2
        if (code[middle] >> bit) & np.uint32(1):
            high = middle
        else:
            low = middle + 1
    return low


@jit
def fit(low: Floats, high: Floats, order: Ints, first: Ints, count: Ints) -> tuple[Floats, Floats]:
    """Return the boxes (m, 3) of all nodes, working them out from the last to the first."""
    nodes = len(first)
    node_low, node_high = np.full((nodes, 3), np.inf), np.full((nodes, 3), -np.inf)
    for node in range(nodes - 1, -1, -1):
        for axis in range(3):
            least, most = np.inf, -np.inf
            if count[node] == INNER:
                child = first[node]
                least = min(node_low[child, axis], node_low[child + 1, axis])
                most = max(node_high[child, axis], node_high[child + 1, axis])
            else:
                for k in range(first[node], first[node] + count[node]):
                    least = min(least, low[order[k], axis])
                    most = max(most, high[order[k], axis])
            node_low[node, axis], node_high[node, axis] = least, most
    return node_low, node_high
