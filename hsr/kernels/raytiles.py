"""Coherent rays: tiles of 16 x 16 samples go through the hierarchies together.

A tile's rays share their way down a hierarchy. For that the hierarchy is refitted to the screen: each
node gets the rectangle of samples it can reach and the greatest nearness it can have (bottom-up, as
in Wald, Boulos and Shirley, "Ray Tracing Deformable Scenes Using Dynamic Bounding Volume
Hierarchies", 2007). A node is passed by if its rectangle misses the tile, or if the whole tile
already shows something nearer. What is left in the leaves is tested row by row of the tile.

Objects are laid out on the screen in batches, nearest first, and forgotten afterwards, so that memory
does not grow with the number of instances. The tests themselves are those of ``rays``.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hsr.arrays import Array, Floats, Ints
from hsr.jit import jit, parallel_jit, prange
from hsr.kernels.bounds import Corner, Reach, corner_of, reach_box, reach_triangle, samples_of
from hsr.kernels.facets import Facet, covered_nearness, facet_of, row_of
from hsr.kernels.hierarchy import INNER, STACK
from hsr.kernels.rays import (
    EXTENT_TESTS,
    FACE_TESTS,
    MESH,
    NODES,
    Best,
    Camera,
    answer_of,
    better,
    counted,
    generic_hit,
    tally,
)

SIDE = 16
"""Samples along each side of a tile: two vectors of eight float64."""

SHARES = 16
"""Shares of the image for the threads; share s has the tile rows s, s + SHARES, ..."""

NONE = 32767
"""More than any column or row: images are at most 2^14 samples wide and high."""

TILE = np.dtype(
    [
        ("nearness", np.float64, (SIDE, SIDE)),
        ("face", np.int64, (SIDE, SIDE)),
        ("column", np.float64, SIDE),
        ("floor", np.float64),
    ]
)
"""The nearest hits of a tile so far; the least nearness of each column, and of all: what is less near
than the floor is hidden."""

REACH = np.dtype(
    [
        ("left", np.int16),
        ("right", np.int16),
        ("top", np.int16),
        ("bottom", np.int16),
        ("nearest", np.float64),
    ]
)
"""First and last column, first and last row that something can reach (first > last where there is
nothing), and its greatest nearness."""

MEMBER = np.dtype(
    [("object", np.int64), ("to_corner", np.int64), ("to_node", np.int64), ("to_triangle", np.int64)]
)
"""An object of a batch, and what to add to the row of a vertex to find its projected corner, to that of
a node or triangle to find its reach."""


# ---------------------------------------------------------------- laying out


@jit
def note_reach(noted: Any, reach: Reach, camera: Camera) -> None:
    """Write down the samples within a reach, and its greatest nearness."""
    noted["left"], noted["right"] = samples_of(reach.left, reach.right, camera.width)
    noted["top"], noted["bottom"] = samples_of(reach.top, reach.bottom, camera.height)
    noted["nearest"] = reach.nearest


@jit
def reach_objects(camera: Camera, objects: Array, reaches: Array) -> None:
    """Find the reach of every object's extent."""
    for k in range(len(reaches)):
        thing = objects[k]
        low, high, margin = thing["low"], thing["high"], thing["margin"]
        start = (low[0] - margin[0], low[1] - margin[1], low[2] - margin[2])
        end = (high[0] + margin[0], high[1] + margin[1], high[2] + margin[2])
        reach = reach_box(thing["screen"], start, end, camera.perspective, camera.near)
        note_reach(reaches[k], reach, camera)


@parallel_jit
def lay_out(
    camera: Camera,
    objects: Array,
    vertices: Floats,
    triangles: Array,
    nodes: Array,
    members: Array,
    corners: Floats,
    reaches: Array,
    tiles: Array,
) -> None:
    """Project a batch of objects and refit their hierarchies; those hidden lose their reach.

    Parameters
    ----------
    camera, objects, vertices, triangles, nodes
        As for ``rays.cast``.
    members : (n,) MEMBER
        The batch, nearest first.
    corners : (V, 4) float64
        Receives the projected vertices, see ``corner_of``.
    reaches : (R,) REACH
        Those of all objects; receives those of the batch's nodes and triangles.
    tiles : (rows, columns) TILE
    """
    for place in prange(len(members)):
        member = members[place]
        thing = objects[member["object"]]
        if is_hidden(reaches[member["object"]], tiles):
            reaches[member["object"]]["right"] = -1
        elif thing["kind"] == MESH:
            project_mesh(camera, thing, member, vertices, corners)
            reach_triangles(camera, thing, member, triangles, corners, reaches)
            reach_nodes(thing, member, nodes, reaches)


@jit
def is_hidden(reach: Any, tiles: Array) -> bool:
    """Whether every tile within reach already shows something nearer."""
    for row in range(reach["top"] // SIDE, reach["bottom"] // SIDE + 1):
        for column in range(reach["left"] // SIDE, reach["right"] // SIDE + 1):
            if reach["nearest"] >= tiles[row, column]["floor"]:
                return False
    return True


@jit
def project_mesh(camera: Camera, thing: Any, member: Any, vertices: Floats, corners: Floats) -> None:
    """Carry the vertices of a mesh to the screen."""
    screen, target = thing["screen"], member["to_corner"]
    for k in range(thing["vertex_start"], thing["vertex_end"]):
        x, y, z = vertices[k, 0], vertices[k, 1], vertices[k, 2]
        corner = corner_of(screen, x, y, z, camera.perspective)
        for i in range(4):
            corners[k + target, i] = corner[i]


@jit
def reach_triangles(
    camera: Camera, thing: Any, member: Any, triangles: Array, corners: Floats, reaches: Array
) -> None:
    """Find the reach of every triangle of a mesh."""
    for k in range(thing["start"], thing["end"]):
        a, b, c = corners_of(triangles[k], corners, member["to_corner"])
        reach = reach_triangle(a, b, c, camera.perspective, camera.near)
        note_reach(reaches[k + member["to_triangle"]], reach, camera)


@jit
def corners_of(triangle: Any, corners: Floats, to_corner: int) -> tuple[Corner, Corner, Corner]:
    """Return the projected corners of a triangle."""
    a, b, c = triangle["corner"][0], triangle["corner"][1], triangle["corner"][2]
    return (
        corner_at(corners, a + to_corner),
        corner_at(corners, b + to_corner),
        corner_at(corners, c + to_corner),
    )


@jit
def corner_at(corners: Floats, k: int) -> Corner:
    """Return one projected corner."""
    return corners[k, 0], corners[k, 1], corners[k, 2], corners[k, 3]


@jit
def reach_nodes(thing: Any, member: Any, nodes: Array, reaches: Array) -> None:
    """Find the reach of every node of a mesh's hierarchy, from the last to the first."""
    for k in range(thing["root_end"] - 1, thing["root"] - 1, -1):
        first, count = nodes[k]["first"], nodes[k]["count"]
        if count == INNER:
            join(reaches, k + member["to_node"], first + member["to_node"], 2)
        else:
            join(reaches, k + member["to_node"], first + member["to_triangle"], count)


@jit
def join(reaches: Array, place: int, first: int, count: int) -> None:
    """Make one reach of ``count`` that follow each other; empty ones add nothing."""
    left, right, top, bottom, nearest = NONE, -NONE, NONE, -NONE, -np.inf
    for k in range(first, first + count):
        part = reaches[k]
        if part["left"] <= part["right"] and part["top"] <= part["bottom"]:
            left, right = min(left, part["left"]), max(right, part["right"])
            top, bottom = min(top, part["top"]), max(bottom, part["bottom"])
            nearest = max(nearest, part["nearest"])
    whole = reaches[place]
    whole["left"], whole["right"], whole["top"], whole["bottom"] = left, right, top, bottom
    whole["nearest"] = nearest


# ---------------------------------------------------------------- casting


class Area(NamedTuple):
    """The samples of one tile: its first and last within the image, and where the first lies."""

    column: int
    row: int
    last_column: int
    last_row: int
    x: float
    y: float


@jit
def area_of(tile_row: int, tile_column: int, camera: Camera) -> Area:
    """Return the samples of the tile at a row and column of tiles."""
    row, column = tile_row * SIDE, tile_column * SIDE
    return Area(
        column,
        row,
        min(column + SIDE, camera.width) - 1,
        min(row + SIDE, camera.height) - 1,
        column + 0.5 - 0.5 * camera.width,
        row + 0.5 - 0.5 * camera.height,
    )


@parallel_jit
def cast_batch(
    camera: Camera,
    objects: Array,
    planes: Floats,
    triangles: Array,
    nodes: Array,
    members: Array,
    corners: Floats,
    reaches: Array,
    tiles: Array,
    work: Array | None,
) -> None:
    """Cast the rays of all tiles into a batch of objects that is laid out.

    Parameters
    ----------
    camera, objects, planes, triangles, nodes
        As for ``rays.cast``.
    members, corners, reaches, tiles
        As :func:`lay_out` left them; the tiles receive the nearest hits.
    work : (SHARES, COUNTS) int64 or None
        Receives the work done for every share of the image.
    """
    for share in prange(SHARES):
        done = None if work is None else work[share]
        for tile_row in range(share, len(tiles), SHARES):
            for place in range(len(members)):
                member = members[place]
                thing, reach = objects[member["object"]], reaches[member["object"]]
                for tile_column in range(reach["left"] // SIDE, reach["right"] // SIDE + 1):
                    area, tile = area_of(tile_row, tile_column, camera), tiles[tile_row, tile_column]
                    tally(done, EXTENT_TESTS)
                    if not can_show(reach, area, tile):
                        continue
                    if thing["kind"] == MESH:
                        cast_into_mesh(
                            area, camera, thing, member, triangles, nodes, corners, reaches, tile, done
                        )
                    else:
                        cast_into_generic(area, camera, thing, planes, reach, tile, done)


@jit
def can_show(reach: Any, area: Area, tile: Any) -> bool:
    """Whether something reaches into a tile, and may be nearer than some of what the tile shows."""
    return bool(
        reach["left"] <= area.last_column
        and reach["right"] >= area.column
        and reach["top"] <= area.last_row
        and reach["bottom"] >= area.row
        and reach["nearest"] >= tile["floor"]
    )


@jit
def cast_into_generic(
    area: Area, camera: Camera, thing: Any, planes: Floats, reach: Any, tile: Any, work: Array | None
) -> None:
    """Hit a generic object with each ray of a tile that its extent can reach."""
    left, right = max(area.column, reach["left"]), min(area.last_column, reach["right"])
    for row in range(max(area.row, reach["top"]), min(area.last_row, reach["bottom"]) + 1):
        nearness, owner = tile["nearness"][row - area.row], tile["face"][row - area.row]
        y = area.y + (row - area.row)
        for i in range(left - area.column, right - area.column + 1):
            hit = counted(generic_hit(area.x + i, y, thing, planes, camera), work)
            nearness[i], owner[i] = better(hit, Best(nearness[i], owner[i]))
    raise_floor(tile)


@jit
def cast_into_mesh(
    area: Area,
    camera: Camera,
    thing: Any,
    member: Any,
    triangles: Array,
    nodes: Array,
    corners: Floats,
    reaches: Array,
    tile: Any,
    work: Array | None,
) -> None:
    """Walk a tile through the hierarchy of a mesh, the nearer child first."""
    to_node = member["to_node"]
    stack = np.empty(STACK, np.int64)
    stack[0] = thing["root"]
    waiting = 1
    while waiting > 0:
        waiting -= 1
        k = stack[waiting]
        tally(work, NODES)
        if not can_show(reaches[k + to_node], area, tile):
            continue
        first, count = nodes[k]["first"], nodes[k]["count"]
        if count != INNER:
            leaf = (first, first + count)
            cast_into_leaf(area, camera, thing, member, leaf, triangles, corners, reaches, tile, work)
            continue
        nearest = reaches[first + to_node]["nearest"]
        second_nearer = reaches[first + 1 + to_node]["nearest"] > nearest
        stack[waiting] = first if second_nearer else first + 1
        stack[waiting + 1] = first + 1 if second_nearer else first
        waiting += 2


@jit
def cast_into_leaf(
    area: Area,
    camera: Camera,
    thing: Any,
    member: Any,
    leaf: tuple[int, int],
    triangles: Array,
    corners: Floats,
    reaches: Array,
    tile: Any,
    work: Array | None,
) -> None:
    """Test the triangles of a leaf, first to end, that reach into a tile."""
    tested = False
    for k in range(leaf[0], leaf[1]):
        reach = reaches[k + member["to_triangle"]]
        if not can_show(reach, area, tile):
            continue
        a, b, c = corners_of(triangles[k], corners, member["to_corner"])
        facet = facet_of(a, b, c, camera.perspective, thing["cull"], thing["mirrored"])
        tally(work, FACE_TESTS)
        if facet.turn == 0.0:
            continue
        face = thing["first_face"] + triangles[k]["face"]
        for row in range(max(area.row, reach["top"]), min(area.last_row, reach["bottom"]) + 1):
            cast_into_row(facet, face, row - area.row, area, camera.closest, tile)
        tested = True
    if tested:
        raise_floor(tile)


@jit
def cast_into_row(facet: Facet, face: int, row: int, area: Area, closest: float, tile: Any) -> None:
    """Test one triangle with a row of 16 rays; written without branches, to become vector code."""
    line = row_of(facet, area.y + row)
    nearness, owner = tile["nearness"][row], tile["face"][row]
    for i in range(SIDE):
        here = covered_nearness(line, area.x + i, closest)
        best, best_face = nearness[i], owner[i]
        nearer = (here > best) | ((here == best) & (face < best_face))
        nearness[i] = here if nearer else best
        owner[i] = face if nearer else best_face


@jit
def raise_floor(tile: Any) -> None:
    """Work out the least nearness in a tile: down its columns side by side, then across."""
    nearness, column = tile["nearness"], tile["column"]
    for i in range(SIDE):
        least = nearness[0, i]
        for row in range(1, SIDE):
            here = nearness[row, i]
            least = here if here < least else least
        column[i] = least
    floor = column[0]
    for i in range(1, SIDE):
        floor = column[i] if column[i] < floor else floor
    tile["floor"] = floor


@parallel_jit
def read_out(camera: Camera, tiles: Array, face: Ints, depth: Floats) -> None:
    """Copy the answers of all tiles into the map; see ``rays.cast``."""
    for tile_row in prange(len(tiles)):
        for tile_column in range(tiles.shape[1]):
            area, tile = area_of(tile_row, tile_column, camera), tiles[tile_row, tile_column]
            for row in range(area.row, area.last_row + 1):
                nearness, owner = tile["nearness"][row - area.row], tile["face"][row - area.row]
                for i in range(area.last_column - area.column + 1):
                    column = area.column + i
                    answer = answer_of(Best(nearness[i], owner[i]), camera.perspective)
                    face[row, column], depth[row, column] = answer
