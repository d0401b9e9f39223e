"""Signs of edges: corners far outside the picture, on one line, or closer together than floats."""

from __future__ import annotations

import math

import numpy as np

from hsr.lab.stability.building import flat, mesh, parallel, samples, scene_of, wall
from hsr.lab.stability.family import Variant, buffer, hard_case, octaves, variants
from hsr.lab.stability.theory import U32, U64
from hsr.mistakes.renderers import GRID
from hsr.scene.model import Scene

OFF = 2.0**-6
"""How far from samples the edge of a huge triangle passes, in pixels along y."""


@hard_case("coverage", "distance of the corners, in pixels", octaves(4, 40, 3))
@variants(
    buffer("float32 corners", OFF / U32, "2^24 off", real=np.float32),
    Variant("opengl", OFF / U32, "2^24 off: its corners are float32"),
    Variant("scanline-direct", None, "2^53 off, beyond the sweep"),
)
def huge_triangle(length: float, side: int) -> Scene:
    """Lay an edge of slope 1/3 just below samples; its triangle reaches as far down.

    The edge of a triangle passes close to samples, and its ends move away along it, to where the picture is
    but a point. Rounding an end moves it by half the spacing of floats out there, and the edge in the picture
    moves with it. Clipping to the picture before anything is rounded keeps the numbers small.

    Truth: The triangle at the samples below its edge, the wall at those above.

    Source: M. Olano, T. Greer, Triangle Scan Conversion Using 2D Homogeneous Coordinates (1997), external
    triangles
    """
    left, right = ([0.5 + 3.0 * s * length, 0.5 + s * length - OFF, -1.0] for s in (-1.0, 1.0))
    triangle = mesh([left, [0.0, -4.0 * length, -1.0], right], [[0, 1, 2]])
    return scene_of(parallel(side), triangle, wall(1.5, side))


def first_overflow(bits: int) -> float:
    """Return the length from which on twice the area of the huge triangle does not fit.

    The long edge is 6 L by 2 L pixels, and the third corner lies 3 L to the right of its left end and 3 L
    below: the cross product, whose sign turns all edges, is 18 L^2 + 6 L^2 in squares of the grid.
    """
    return math.sqrt(2.0 ** (bits - 1) / 24.0) / GRID


@hard_case("coverage", "distance of the corners, in pixels", octaves(2, 16, 2))
@variants(
    buffer("int32", first_overflow(32), "sqrt(2^31 / 24) / 2^8 px", whole=np.int32),
    buffer("int64", None, "sqrt(2^63 / 24) / 2^8 px, beyond the sweep", whole=np.int64),
)
def integer_overflow(length: float, side: int) -> Scene:
    """Look at the huge triangle.

    On a grid, edge functions are exact in integers, as long as they fit: a triangle of 2^k pixels on a grid
    of 2^-b needs 2 (k + b) + 2 bits. With 8 bits of sub-pixels 32 of them are full at some two hundred
    pixels; from there on signs are those of the remainder. Real rasterisers choose 64 bits, or split.

    Truth: The triangle at the samples below its edge, the wall at those above.

    Source: Derived: the product of two differences of corners; cf. J. Pineda, A Parallel Algorithm for
    Polygon Rasterization (1988)
    """
    return huge_triangle.scene(length, side)


REACH = 24.1
SLOPE = 2.0 / 3.0
"""Not a power of two: a corner whose x and y are rounded alike would stay on the edge."""


def last_zoom(rounding: float, side: int) -> float:
    """Return the zoom at which rounding a corner moves the edge over the nearest sample.

    Steps are ``2 / (zoom W)``, and y - 2/3 x an odd multiple of a sixth of that at the samples.
    """
    return 1.0 / (3.0 * side * REACH * rounding)


@hard_case("coverage", "zoom of the window", octaves(0, 50, 2))
@variants(
    Variant("scanline-direct", lambda side: last_zoom(U64, side), "2^53 / (72 W)"),
    Variant("opengl", lambda side: last_zoom(U32, side), "2^24 / (72 W)"),
)
def tiny_grid(zoom: float, _: int) -> Scene:
    """Look at the point (1/2, 1/2) of a long edge of slope 2/3 through an ever smaller window.

    A window about one point of a long edge is zoomed, until its samples are neighbouring floats. The nearest
    samples lie a sixth of a step from the edge: the sign of the orientation of three points decides, and in
    floats that is noise as soon as the window is smaller than the rounding of what lies far outside.

    Truth: The triangle at the samples below its edge, the background above.

    Source: L. Kettner, K. Mehlhorn, S. Pion, S. Schirra, C. Yap, Classroom Examples of Robustness Problems in
    Geometric Computations (2008)
    """
    matrix = np.diag([zoom, zoom, -1.0, 1.0])
    matrix[:2, 3] = -0.5 * zoom
    left, right = ([0.5 + x, 0.5 + SLOPE * x, 0.0] for x in (-REACH, REACH))
    triangle = mesh([left, [REACH, -REACH, 0.0], right], [[0, 1, 2]])
    return scene_of({"type": "matrix", "matrix": matrix.tolist()}, triangle)


@hard_case("coverage", "height of the triangles, in pixels", (*octaves(-1, -19, 2), 0.0))
@variants(
    buffer(
        "inclusive", 0.5, "always: a triangle without area has no outside", inclusive=True, degenerate=True
    ),
    Variant("scanline-direct", None, "no area, no span"),
)
def degenerate_input(height: float, side: int) -> Scene:
    """Lay triangles so high upon lines of samples, and some that are a line or a point, before a wall.

    Triangles lie upon lines of samples and lose their height; others have two equal corners, or three, from
    the start. Without area there is nothing to see: all edge functions are 0, and whoever counts 0 as inside
    on every edge draws what is not there.

    Truth: The wall, and on the lower edges of triangles with a height either of the two.

    Source: J. Foley, A. van Dam, S. Feiner, J. Hughes, Computer Graphics: Principles and Practice, 3.6:
    slivers
    """
    y = samples(side, 2, side, 4)
    x = np.full_like(y, 0.25 * side)
    corners = np.stack([[-x, y], [x, y], [0.0 * x, y + height]]).transpose(2, 0, 1)
    triangles = 3 * np.arange(len(y))[:, None] + np.array([0, 1, 2, 0, 1, 1, 2, 2, 2])
    return scene_of(parallel(side), mesh(flat(corners), triangles.reshape(-1, 3)), wall(1.5, side))
