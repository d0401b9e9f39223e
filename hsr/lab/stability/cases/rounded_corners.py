"""Samples ever closer to edges: whoever rounds corners, to a grid or to float32, moves the edge past them."""

from __future__ import annotations

import math

import numpy as np

from hsr.lab.stability.building import (
    central,
    closed_fan,
    flat,
    grid,
    loose,
    mesh,
    net,
    parallel,
    rectangle,
    samples,
    scene_of,
    seen,
    wall,
)
from hsr.lab.stability.family import buffer, hard_case, octaves, variants
from hsr.lab.stability.rounding import in_space, on_screen, snapped
from hsr.scene.model import Scene

EPSILON = 2.0**-17


@hard_case("coverage", "distance of corners from samples, in pixels", octaves(-1, -43, 2))
@variants(
    *snapped(),
    on_screen(),
    buffer(
        "epsilon",
        0.5 * EPSILON,
        "epsilon / 2: level edges are widened by 2^-17 px, and twice as far from samples",
        epsilon=EPSILON,
    ),
)
def lattice_edges(offset: float, side: int) -> Scene:
    """Cover the picture by a flat net, its corners right of and above samples.

    A flat net of triangles has its corners ever closer to samples. However close, each sample has one
    owner, and at the sample itself the rule of top and left edges names it. Whoever rounds corners to a grid
    moves them onto the samples or past them; whoever widens edges by an epsilon lets two triangles own what
    lies within it, and the one drawn first keeps it.

    Truth: The triangle to the left of and below each corner.

    Source: J. Foley, A. van Dam, S. Feiner, J. Hughes, Computer Graphics: Principles and Practice, 3.6: who
    owns the pixels on an edge
    """
    corners, triangles = net(side, offset, 2.0 * offset)
    return scene_of(parallel(side), mesh(flat(corners), triangles))


@hard_case("coverage", "height of the needle, in pixels", octaves(1, -33, 2))
@variants(*snapped(2.0), on_screen(), *in_space())
def needle(height: float, side: int) -> Scene:
    """Lay a needle along every fourth line of samples, in front of a wall.

    A triangle twice as long as the picture is wide holds samples between its long edges, however thin it is.
    Snapped to a grid of 2^-b pixels it has no area left once its height is less than that; in float32 its
    area drowns in the rounding of products as long as the picture is wide.

    Truth: The needle at the samples between its edges, the wall behind elsewhere.

    Source: J. R. Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates
    (1997): the error of an orientation test grows with the length of the edges
    """
    y = samples(side, 0, side, 4)
    x = np.full_like(y, side)
    corners = np.stack([[-x, y], [x, y - 0.5 * height], [x, y + 0.5 * height]]).transpose(2, 0, 1)
    return scene_of(parallel(side), loose(flat(corners)), wall(1.5, side))


@hard_case("coverage", "width of the gap, in pixels", octaves(1, -33, 2))
@variants(*snapped(2.0), on_screen(2.0))
def needle_gap(width: float, side: int) -> Scene:
    """Leave a gap about a column of samples between two walls, in front of a third.

    Two walls leave a gap through which a third is seen, at one column of samples in the middle of it.
    However narrow the gap, it is seen there. A grid of 2^-b pixels closes it when both its edges are rounded
    to the column of samples, which one of the two walls then owns.

    Truth: The far wall in the column of samples, the near walls elsewhere.

    Source: Microsoft, Direct3D 11.3 Functional Specification, 3.4.1: corners are snapped to 8 fraction bits
    """
    left, right, end = 0.5 - 0.5 * width, 0.5 + 0.5 * width, float(side)
    walls = [rectangle(x, (-end, end), 1.0) for x in ((-end, left), (right, end))]
    return scene_of(parallel(side), *walls, wall(1.5, side))


AROUND = np.array([[3, 1], [1, 3], [-1, 3], [-3, 1], [-3, -1], [-1, -3], [1, -3], [3, -1]]) / 3.0
"""The rim about a sample, for a radius of 1."""


@hard_case("coverage", "radius of the eight triangles, in pixels", octaves(-1, -33, 2))
@variants(*snapped(), on_screen())
def micro_triangles(radius: float, side: int) -> Scene:
    """Put eight triangles about every eighth sample, in front of a wall.

    Eight triangles meet at a sample, and all of them together are smaller than a pixel. One of them owns the
    sample, however small they are. Corners that are rounded to a grid of 2^-b pixels fall together when the
    radius is less than half of it, and the triangles vanish.

    Truth: One of the eight triangles at each such sample, the wall behind everywhere else.

    Source: The OpenGL Graphics System, 3.6.1: rasterization of polygons, at least 4 bits of sub-pixel
    precision
    """
    line = samples(side, 4, side, 8)
    centre = np.stack(np.meshgrid(line, line), axis=2).reshape(-1, 1, 2)
    corners = np.concatenate([centre, centre + radius * AROUND], axis=1)
    triangles = (9 * np.arange(len(centre))[:, None, None] + closed_fan(8)).reshape(-1, 3)
    return scene_of(parallel(side), mesh(flat(corners), triangles), wall(1.5, side))


ALONG = np.array([3.0, 1.0])
"""Direction of the edges, from sample to sample."""


@hard_case("coverage", "grid that holds the corners, in pixels", octaves(-2, -28, 2), continuous=False)
@variants(*snapped(), on_screen())
def t_junction(step: float, side: int) -> Scene:
    """Divide many small squares by an edge on samples, one neighbour having a corner in the middle of it.

    On one side of an edge lies one triangle, on the other side lie two, which meet in a corner on the edge.
    All corners lie on it exactly, and so do samples. While the grid of a rasteriser holds the corners,
    nothing happens; with one bit more the three corners are rounded apart, and the background shines through
    the crack at samples on the edge.

    All corners are multiples of ``step`` along the edge, so that they lie on it exactly.

    Truth: A triangle at every sample of the edge, whichever of those that meet there.

    Source: The OpenGL Graphics System, appendix on corollaries: no promise holds where edges do not share
    corners
    """
    random = np.random.default_rng(0)
    first = np.mgrid[4 : side - 8 : 12, 4 : side - 4 : 8].reshape(2, -1).T + 0.5 - 0.5 * side
    away = step * (2 * random.integers(0, max(1, round(0.25 / step)), (len(first), 3, 1)) + 1)
    a, t, b = (first + (s * away[:, k] + place) * ALONG for k, s, place in ((0, -1, 0), (1, 1, 1), (2, 1, 2)))
    above, below = first + np.array([2.0, 4.0]), first + np.array([4.0, -3.0])
    triangles = np.array([[1, 0, 4], [0, 2, 3], [2, 1, 3]]) + 5 * np.arange(len(first))[:, None, None]
    corners = flat(np.stack([a, b, t, above, below], axis=1))
    return scene_of(parallel(side), mesh(corners, triangles.reshape(-1, 3)))


@hard_case("coverage", "how far tips reach beyond samples, in pixels", octaves(-1, -33, 2))
@variants(*snapped(), on_screen())
def vertex_on_edge(beyond: float, side: int) -> Scene:
    """Point triangles from the left at a column of samples, and end a wall behind them at the same column.

    Tips of triangles end at a column of samples, at which the edge of a wall behind them ends as well: seen
    from the eye, corners lie on an edge. Each tip reaches beyond its sample by a little, and owns it. Rounded
    to a grid the tip ends on the sample, which then belongs to what is behind.

    Truth: The triangles at the samples of their tips.

    Source: The lab's rule of ties: the limit from the right and below
    """
    y = samples(side, 2, side - 2, 4)
    x = np.full_like(y, 0.5)
    tips = np.stack([[x + beyond, y], [x - 3.0, y + 1.5], [x - 3.0, y - 1.5]]).transpose(2, 0, 1)
    edge = 3.0 * (0.5 - beyond) * 2.0 / side
    behind = rectangle((edge, 6.0), (-6.0, 6.0), 3.0)
    return scene_of(central(0.5), loose(2.0 * seen(tips, side)), behind, wall(4.0, 8.0))


@hard_case("coverage", "height of the strip, in pixels", octaves(0, -32, 2))
@variants(*snapped(2.0), on_screen(2.0))
def fold_over(height: float, side: int) -> Scene:
    """Join two sheets by a strip about a line of samples, its borders zigzags of half its height.

    Two sheets are joined by a strip of triangles in which a line of samples lies, and all of it faces the
    eye. Once the strip is thinner than the grid, its borders are rounded past each other: its triangles turn
    over and are culled, or lose their area. No hole opens, for the sheets share the moved corners; but the
    samples go to the wrong faces.

    Diagonals cross the line half-way between samples, and so do the sides of the strip's triangles.

    Truth: The strip along its line of samples, the sheets above and below.

    Source: Microsoft, Direct3D 11.3 Functional Specification, 3.4.1: culling comes after snapping
    """
    x = np.arange(-0.5 * side - 4.0, 0.5 * side + 5.0, 4.0)
    zigzag, end = 0.25 * height * (-1.0) ** np.arange(len(x)), np.full(len(x), float(side))
    y = [-end, 0.5 - 0.5 * height + zigzag, 0.5 + 0.5 * height + zigzag, end]
    corners = flat(np.stack([np.tile(x, 4), np.concatenate(y)], axis=1))
    return scene_of(parallel(side), mesh(corners, grid(4, len(x)), cull="back"))


@hard_case("coverage", "width of the right face on the screen, in pixels", octaves(0, -32, 2))
@variants(*snapped(2.0), on_screen(2.0))
def edge_on_cube(width: float, side: int) -> Scene:
    """Turn a cube about the y axis until its right face is so many pixels wide; samples lie within it.

    A cube is turned, by Pythagorean angles, until its right face is seen almost edge-on; a column of samples
    stays in the middle of that face. Which side of the face is seen is the sign of the area of its
    projection. Where corners are rounded, to a grid or to float32, the area becomes 0 or changes its sign,
    and the face is culled.

    The turn has the sine 2 t / (1 + t^2) and the cosine (1 - t^2) / (1 + t^2), rational as t is.

    Truth: The right face in its column of samples, the front face to the left of it.

    Source: D. Hearn, M. P. Baker, Computer Graphics, back-face detection
    """
    half = 0.25 * side
    t = width / (4.0 * half)
    sine, cosine = 2.0 * t / (1.0 + t * t), (1.0 - t * t) / (1.0 + t * t)
    # The right edge of the front face lies as far left of the samples as that of the back face lies right.
    x = 0.5 - half * cosine + math.floor(half)
    matrix = [
        [half * cosine, 0.0, -half * sine, x],
        [0.0, half, 0.0, 0.0],
        [half * sine, 0.0, half * cosine, -2.0 * half],
        [0.0, 0.0, 0.0, 1.0],
    ]
    cube = {"shape": "cube", "cull": "back", "transform": [{"matrix": matrix}]}
    return scene_of(parallel(side, 0.0, float(2 * side)), cube)


DIRECTIONS = ((4, 1), (1, 3), (-2, 3), (-3, 1), (-3, -2), (-1, -4), (1, -3), (3, -2))


@hard_case("order", "width of the wedges at their ends, in pixels", octaves(-3, -31, 2))
@variants(*snapped(2.0), on_screen(8.0))
def concurrent_edges(width: float, side: int) -> Scene:
    """Point wedges, so wide at their ends, at one sample, each about a line of samples and at its depth.

    Eight thin wedges at different depths point at one sample, so that sixteen edges meet in one point of the
    picture. Each wedge holds samples along its middle, out to its end. Rounding corners closes a wedge once
    it is narrower than the grid; in float32 it closes at its first sample, where it is about a seventh as
    wide as at its end.

    Truth: The wedge at the samples of its middle line, the wall elsewhere.

    Source: M. Attene, Indirect Predicates for Geometric Constructions (2020): do not round what is
    constructed
    """
    wedges = []
    for k, (x, y) in enumerate(DIRECTIONS):
        # Samples on the line lie at whole multiples of the direction; end between two of them.
        reach = np.floor(0.45 * side / np.hypot(x, y)) + 0.5
        end = reach * np.array([x, y])
        aside = 0.5 * width / np.hypot(x, y) * np.array([-y, x])
        wedges.append((2.0 + 0.125 * k) * seen(np.array([[0.0, 0.0], end - aside, end + aside]) + 0.5, side))
    return scene_of(central(0.5), loose(wedges), wall(4.0, 8.0))
