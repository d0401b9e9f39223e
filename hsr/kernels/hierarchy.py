"""A bounding-volume hierarchy over boxes: sort along a Morton curve, halve where the codes part.

The linear hierarchy of Lauterbach et al., "Fast BVH Construction on GPUs" (Eurographics 2009): the
boxes are sorted by the Morton code of their centres, and a run of them is cut where the highest bit
that differs within it flips. Children are numbered after their parent, so that one backward pass
over the nodes visits children first.
"""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.base.jit import jit, parallel_jit, prange

LEAF = 8
"""Most boxes in one leaf of the hierarchies for single rays."""

INNER = -1
"""The ``count`` of a node that is no leaf."""

AXIS_BITS = 10
CELLS = 1 << AXIS_BITS
"""Cells of the Morton curve along each axis; a code has three times ten bits."""

STACK = 64
"""Room for the nodes that wait in a walk: 30 levels of code bits, and 31 halvings of equal codes."""


NODE = np.dtype([("first", np.int32), ("count", np.int32), ("low", np.float64, 3), ("high", np.float64, 3)])
"""One node of a hierarchy.

first : of a leaf its first box, in the order of the leaves; of an inner node its first child, the
    second being the next node.
count : boxes in a leaf, ``INNER`` for an inner node.
low, high : the box around everything below the node, closed.
"""


def build(low: Floats, high: Floats) -> tuple[Ints, Array]:
    """Build the hierarchy over boxes, for single rays.

    Parameters
    ----------
    low, high : (n, 3) float64
        Opposite corners of the boxes, low <= high, finite; at least one.

    Returns
    -------
    order : (n,) int32
        The boxes in the order of the leaves.
    nodes : (N,) NODE
        The root is the first.
    """
    order, tree = _tree(morton_codes(low, high), LEAF)
    nodes = np.empty(len(tree), NODE)
    nodes["first"], nodes["count"] = tree.T
    fit(low, high, order, nodes)
    return order, nodes


def tree_of(vertices: Floats, corner: Ints, box: Floats, leaf: int) -> tuple[Ints, Ints]:
    """Build the tree of a hierarchy over triangles, without boxes of its nodes.

    Parameters
    ----------
    vertices : (V, 3) float64
    corner : (n, 3) int32
    box : (2, 3) float64
        Opposite corners of the box in which the centres of the triangles' boxes lie.
    leaf : int
        Most triangles in one leaf.

    Returns
    -------
    order : (n,) int32
        The triangles in the order of the leaves.
    tree : (N, 2) int32
        ``first`` and ``count`` of each node, see :data:`NODE`.
    """
    return _tree(_triangle_codes(vertices, corner, box), leaf)


def _tree(code: Array, leaf: int) -> tuple[Ints, Ints]:
    code, order = radix_sort(code)
    tree = np.empty((2 * len(code), 2), np.int32)
    used = split(code, leaf, tree[:, 0], tree[:, 1])
    return order, tree[:used]


def morton_codes(low: Floats, high: Floats) -> Array:
    """Return the Morton code (n,) uint32 of every box's centre in the box around the centres."""
    # A box is as good as a triangle: one of its two corners is taken twice.
    number = np.arange(len(low), dtype=np.int32)
    corner = np.stack([number, number + np.int32(len(low)), number], axis=1)
    centre = 0.5 * low + 0.5 * high
    box = np.stack([centre.min(axis=0), centre.max(axis=0)])
    return _triangle_codes(np.concatenate([low, high]), corner, box)


@parallel_jit
def _triangle_codes(vertices: Floats, corner: Ints, box: Floats) -> Array:
    """Return the Morton codes of the centres of the boxes around triangles."""
    # Twice the centre is as good as the centre: only its place in the box counts.
    code, cell = np.empty(len(corner), np.uint32), np.empty(3)
    for axis in range(3):
        cell[axis] = cells_in(2.0 * (box[1, axis] - box[0, axis]))
    for i in prange(len(corner)):
        mixed = np.uint32(0)
        for axis in range(3):
            a, b, c = vertices[corner[i, 0], axis], vertices[corner[i, 1], axis], vertices[corner[i, 2], axis]
            centre = min(a, b, c) + max(a, b, c)
            mixed |= code_of((centre - 2.0 * box[0, axis]) * cell[axis]) << np.uint32(axis)
        code[i] = mixed
    return code


@jit
def box_of(vertices: Floats) -> Floats:
    """Return the opposite corners (2, 3) of the box around points (V, 3)."""
    box = np.empty((2, 3))
    box[0], box[1] = np.inf, -np.inf
    for i in range(len(vertices)):
        for axis in range(3):
            box[0, axis] = min(box[0, axis], vertices[i, axis])
            box[1, axis] = max(box[1, axis], vertices[i, axis])
    return box


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
def cells_in(length: float) -> float:
    """Return how many cells of the curve there are to a unit, if so long a range has all.

    A range so short that this might overflow is as good as none.
    """
    return CELLS / length if length > 1e-300 else 0.0


@jit
def code_of(place: float) -> np.uint32:
    """Return every third bit of the Morton code of a place along an axis, counted in cells.

    What overflowed, and is not a number, counts as the last cell.
    """
    return spread(np.uint32(min(CELLS - 1.0, place)))


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
    order = np.empty(n, np.int32)
    for i in range(n):
        order[i] = i
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
def split(code: Array, leaf: int, first: Ints, count: Ints) -> int:
    """Cut sorted codes into a tree with at most ``leaf`` of them in one leaf.

    Parameters
    ----------
    code : (n,) uint32, ascending
    leaf : int
    first, count : (2 n,) int32
        Receive those fields of the nodes, see :data:`NODE`.

    Returns
    -------
    int
        Number of nodes.
    """
    pending = np.empty((STACK, 3), np.int64)
    pending[0, 0], pending[0, 1], pending[0, 2] = 0, 0, len(code)
    used, waiting = 1, 1
    while waiting > 0:
        waiting -= 1
        node, start, end = pending[waiting, 0], pending[waiting, 1], pending[waiting, 2]
        if end - start <= leaf:
            first[node], count[node] = start, end - start
            continue
        first[node], count[node] = used, INNER
        middle = parting(code, start, end)
        pending[waiting, 0], pending[waiting, 1], pending[waiting, 2] = used + 1, middle, end
        waiting += 1
        pending[waiting, 0], pending[waiting, 1], pending[waiting, 2] = used, start, middle
        used += 2
        waiting += 1
    return used


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
def fit(low: Floats, high: Floats, order: Ints, nodes: Array) -> None:
    """Fit the boxes of all nodes, from the last to the first."""
    for k in range(len(nodes) - 1, -1, -1):
        node = nodes[k]
        first, count = node["first"], node["count"]
        for axis in range(3):
            least, most = np.inf, -np.inf
            if count == INNER:
                least = min(nodes[first]["low"][axis], nodes[first + 1]["low"][axis])
                most = max(nodes[first]["high"][axis], nodes[first + 1]["high"][axis])
            for i in range(first, first + count):
                least, most = min(least, low[order[i], axis]), max(most, high[order[i], axis])
            node["low"][axis], node["high"][axis] = least, most
