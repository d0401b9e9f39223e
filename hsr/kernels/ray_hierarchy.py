"""Single rays through extents: around every object of the list, or in hierarchies of them.

The nearest hit is that of the plain list (:mod:`hsr.kernels.rays`), found by fewer tests: both keep the best
of what they test by one rule, and what lies in an extent is found through it. For study, extents may also be
met without care for rounding. Work is counted here, in kernels compiled for that.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hsr.base.arrays import Array, Floats, Ints
from hsr.base.jit import jit, parallel_jit, prange
from hsr.kernels.boxes import Beam, box_entry, naive_entry, reciprocal
from hsr.kernels.hierarchy import INNER, STACK
from hsr.kernels.projection import nearness_of
from hsr.kernels.ray_objects import MESH, Camera, Data
from hsr.kernels.rays import NO_OWNER, Best, answer_of, at_sample, better, generic_hit, triangle_hit

LIST, EXTENTS, HIERARCHY = range(3)
"""How single rays go through the objects."""

NODES, EXTENT_TESTS, FACE_TESTS, HITS = range(4)
"""Places in an array of work counts. Tests of generic shapes count as one face test each."""

COUNTS = 4


class Way(NamedTuple):
    """How single rays go about it.

    Attributes
    ----------
    acceleration : int
        ``LIST``, ``EXTENTS`` or ``HIERARCHY``.
    test : int
        How triangles are tested, see :mod:`hsr.kernels.triangle_tests`.
    robust : bool
        Whether extents are met by ``box_entry``, else by ``naive_entry``.
    """

    acceleration: int
    test: int
    robust: bool


@parallel_jit
def cast_through_extents(
    camera: Camera, data: Data, way: Way, face: Ints, depth: Floats, work: Array | None
) -> None:
    """Cast the rays of all samples, one at a time; see :func:`hsr.kernels.rays.cast`.

    Parameters
    ----------
    camera, data, face, depth
    way : Way
    work : (H, COUNTS) int64 or None
        Receives the work done for every row.
    """
    nothing = Best(camera.farthest, NO_OWNER)
    for row in prange(camera.height):
        world = data.objects[len(data.objects) - 1]
        room, inner_room = np.empty(STACK, PENDING), np.empty(STACK, PENDING)
        done = None if work is None else work[row]
        y = row + 0.5 - 0.5 * camera.height
        for column in range(camera.width):
            x = column + 0.5 - 0.5 * camera.width
            if way.acceleration == HIERARCHY:
                best = nearest_among_objects(x, y, world, camera, data, way, nothing, room, inner_room, done)
            else:
                best = nearest_in_extents(x, y, camera, data, way, done)
            face[row, column], depth[row, column] = answer_of(best, camera.perspective)


# ---------------------------------------------------------------- extents in a list


@jit
def nearest_in_extents(x: float, y: float, camera: Camera, data: Data, way: Way, work: Array | None) -> Best:
    """Find the nearest hit of the ray of sample (x, y) with the objects whose extents it meets."""
    best = Best(camera.farthest, NO_OWNER)
    for k in range(len(data.objects)):
        thing = data.objects[k]
        if way.acceleration == EXTENTS and not meets_extent(x, y, thing, camera, way.robust, work):
            continue
        if thing["kind"] != MESH:
            best = better(counted(generic_hit(x, y, thing, data.planes, camera), work), best)
            continue
        for i in range(thing["start"], thing["end"]):
            hit = triangle_hit(x, y, thing, data.triangles[i], data.vertices, camera, way.test)
            best = better(counted(hit, work), best)
    return best


@jit
def meets_extent(x: float, y: float, thing: Any, camera: Camera, robust: bool, work: Array | None) -> bool:
    """Whether the ray of sample (x, y) meets the extent of an object."""
    tally(work, EXTENT_TESTS)
    return entry_of(thing, beam_of(thing, x, y, camera), robust) < np.inf


@jit
def entry_of(box: Any, beam: Beam, robust: bool) -> float:
    """Return the parameter at which a beam enters a box, ``+inf`` if it misses."""
    return box_entry(box, beam) if robust else naive_entry(box, beam)


@jit
def beam_of(thing: Any, x: float, y: float, camera: Camera) -> Beam:
    """Return the ray of sample (x, y) in an object's space, as thick as rounding may have moved it."""
    d, margin = at_sample(thing["direction"], x, y), thing["margin"]
    return Beam(
        at_sample(thing["origin"], x, y),
        (reciprocal(d[0]), reciprocal(d[1]), reciprocal(d[2])),
        (margin[0], margin[1], margin[2]),
        camera.near,
        camera.far,
    )


# ---------------------------------------------------------------- hierarchies of extents

PENDING = np.dtype([("node", np.int64), ("entry", np.float64)])
"""A node that waits in a walk, and the depth at which the ray enters it."""


def _nearest_below(
    x: float,
    y: float,
    thing: Any,
    camera: Camera,
    data: Data,
    way: Way,
    best: Best,
    room: Array,
    inner_room: Array | None,
    work: Array | None,
) -> Best:
    """Return the better of ``best`` and the nearest hit of the ray of sample (x, y) below an object's root.

    Parameters
    ----------
    thing : OBJECT
        The world, whose leaves hold objects; or a mesh, whose leaves hold triangles.
    room, inner_room : (STACK,) PENDING
        Room for the nodes that wait here, and in the walk within one mesh: within one it is None.
    """
    nodes, beam = data.nodes, beam_of(thing, x, y, camera)
    waiting = push(room, 0, nodes, thing["root"], beam, way.robust)
    while waiting > 0:
        waiting -= 1
        node = nodes[room[waiting]["node"]]
        tally(work, NODES)
        # Pass by what is entered behind the best hit so far.
        if nearness_of(room[waiting]["entry"], camera.perspective) < best.nearness:
            continue
        if node["count"] == INNER:
            waiting = push_children(room, waiting, nodes, node["first"], beam, way.robust)
            continue
        for k in range(node["first"], node["first"] + node["count"]):
            if inner_room is None:
                hit = triangle_hit(x, y, thing, data.triangles[k], data.vertices, camera, way.test)
                best = better(counted(hit, work), best)
            elif data.objects[k]["kind"] == MESH:
                inner = data.objects[k]
                best = nearest_in_mesh(x, y, inner, camera, data, way, best, inner_room, None, work)
            elif meets_extent(x, y, data.objects[k], camera, way.robust, work):
                hit = generic_hit(x, y, data.objects[k], data.planes, camera)
                best = better(counted(hit, work), best)
    return best


# One walk, compiled twice: numba does not keep compiled functions that call themselves.
nearest_in_mesh = jit(_nearest_below)
nearest_among_objects = jit(_nearest_below)


@jit
def push(room: Array, waiting: int, nodes: Array, node: int, beam: Beam, robust: bool) -> int:
    """Let a node wait if the beam meets it; return how many nodes wait now."""
    entry = entry_of(nodes[node], beam, robust)
    room[waiting]["node"], room[waiting]["entry"] = node, entry
    return waiting + int(entry < np.inf)


@jit
def push_children(room: Array, waiting: int, nodes: Array, first: int, beam: Beam, robust: bool) -> int:
    """Let two sister nodes wait, the one entered earlier on top; return how many nodes wait now."""
    one = push(room, waiting, nodes, first, beam, robust)
    two = push(room, one, nodes, first + 1, beam, robust)
    if two == waiting + 2 and room[waiting]["entry"] < room[one]["entry"]:
        earlier = room[waiting]["entry"]
        room[waiting]["node"], room[one]["node"] = first + 1, first
        room[waiting]["entry"], room[one]["entry"] = room[one]["entry"], earlier
    return two


# ---------------------------------------------------------------- work


@jit
def tally(work: Array | None, what: int) -> None:
    """Count one more piece of work, if work is counted."""
    if work is not None:
        work[what] += 1


@jit
def counted(hit: tuple[float, int], work: Array | None) -> tuple[float, int]:
    """Tally a tested face, and its hit if it is one."""
    tally(work, FACE_TESTS)
    if hit[0] > -np.inf:
        tally(work, HITS)
    return hit
