"""Rays that graze extents and corners: rounded tests may lose them, or choose the wrong neighbour."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import central, crumpled, mesh, panel, parallel, rectangle, scene_of, wall
from hsr.lab.stability.family import Variant, also, hard_case, octaves, variants
from hsr.lab.stability.rounding import DRIVER, in_space
from hsr.lab.stability.theory import U64
from hsr.mistakes.renderers import naive_boxes
from hsr.scene.model import Scene


@hard_case("rays", "distance of the rays from the corners, in pixels", octaves(-1, -49, 2))
@variants(
    *in_space(),
    # Its two cross products are rounded besides, as those of float32.
    Variant("raycast-moller-trumbore", lambda side: U64 * side, "2^-53 W px: float64", 4.0),
    DRIVER,
)
def vertex_aimed_rays(past: float, side: int) -> Scene:
    """Surround the eye by a crumpled net whose corners lie right of and above samples, seen from the eye.

    A crumpled net closes off the view. Its corners come ever closer to the rays of samples, each at a depth
    of its own. A test that looks at the edge of two triangles in two different ways may deny it to both, and
    the ray escapes through a closed surface, in float64 as in float32; a watertight test loses no ray, but
    rounding can still choose the wrong neighbour.

    Truth: The triangle to the left of and below each corner; nowhere the background.

    Source: S. Woop, C. Benthin, I. Wald, Watertight Ray/Triangle Intersection (JCGT 2, 2013)
    """
    return scene_of(central(0.5), mesh(*crumpled(side, past, 2.0 * past)))


SIDES = 12


@hard_case("rays", "distance of rays from the apex, in pixels", octaves(-2, -36, 2))
@variants(*in_space(4.0), DRIVER)
def apex_of_half_spaces(past: float, side: int) -> Scene:
    """Point pyramids at samples, or ever closer past them.

    Twelve half-spaces meet in the apex of a pyramid, and a ray passes ever closer to it. It enters all of
    them at almost the same distance, and the greatest of those tells the face. Rounded, they are in any order
    as soon as they differ by less than the spacing of floats.

    Rays pass the apex by (1, 2) times the distance; the nearest edge of the pyramid is turned from there by
    5.6 degrees. So they pass that edge, on which two sides are equally far, at 0.22 of the distance.

    Truth: The side of the pyramid in whose direction the ray passes the apex.

    Source: M. Cyrus, J. Beck, Generalized Two- and Three-Dimensional Clipping (1978); Hill and Kelley, convex
    polyhedra
    """
    angle = (np.arange(SIDES) + 0.3) * (2.0 * np.pi / SIDES)
    ring = np.stack([np.cos(angle), np.sin(angle), np.full(SIDES, -3.0)], axis=1) * [0.2, 0.2, 1.0]
    k = range(SIDES)
    faces = [[i, (i + 1) % SIDES, SIDES] for i in k] + [list(reversed(k))]
    pyramids = []
    for row, column in np.mgrid[side // 8 : side : side // 4, side // 8 : side : side // 4].reshape(2, -1).T:
        x, y = (2 * column + 1 + 2 * past) / side - 1, 1 - (2 * row + 1 - 4 * past) / side
        vertices = [*(ring + np.array([3.0 * x, 3.0 * y, 0.0])).tolist(), [2.0 * x, 2.0 * y, -2.0]]
        pyramids.append({"shape": "polyhedron", "vertices": vertices, "faces": faces})
    return scene_of(central(0.5), *pyramids)


WIDTH = 64
"""Samples of a picture: its columns have directions of up to six bits, some of whose reciprocals round up."""


@hard_case("rays", "distance of rays from the seam, in pixels", (*octaves(-2, -50, 3), 0.0))
@also(size=lambda *_: (WIDTH, WIDTH))
@variants(
    Variant("raycast-naive-slabs", 0.5 * U64 * WIDTH, "2^-54 W px: one rounding, W / 2 from the middle"),
    Variant("raycast-single", None, "its slabs are padded by two units in the last place"),
)
def box_grazing(past: float, _: int) -> Scene:
    """Hang panels side by side, each at a depth of its own; they meet so far left of columns of samples.

    Panels hang side by side, and along their seams rays graze the flat extents of two of them. The slab test
    multiplies by a rounded reciprocal of the direction and may find that the ray leaves an extent before it
    has entered. Then the panel that owns the sample is never asked, and the other does not own it: the ray
    escapes. Two units in the last place of padding, or a division, lose none.

    Truth: A panel in every column from the first seam to the last.

    Source: T. Ize, Robust BVH Ray Traversal (JCGT 2, 2013)
    """
    panels, random = [], np.random.default_rng(0)
    for top in (1.0, 0.5, 0.0, -0.5):
        for column in range(3, WIDTH - 4, 4):
            depth = 1.0 + random.integers(1, 1024) / 1024.0
            left, right = ((2 * k + 1 - 2 * past - WIDTH) / WIDTH * depth for k in (column, column + 4))
            panels.append(rectangle((left, right), ((top - 0.5) * depth, top * depth), depth))
    return scene_of(central(0.5), *panels)


@hard_case("rays", "distance of rays from the sides, in pixels", (*octaves(-2, -44, 3), 0.0))
@variants(
    Variant("minimum of NaN", 0.0, "0: 0 times infinity is NaN, and no hit", mistake=naive_boxes),
    Variant("raycast-naive-slabs", None, "its order of operands is right for +0, and no direction has -0"),
    Variant("raycast-single", None, "a ray within a side is inside"),
)
def slab_degeneracies(past: float, side: int) -> Scene:
    """Hang panels before a wall; they meet so far left of columns of samples.

    Parallel rays run along the sides of extents, and exactly within them in the end: there the slab test
    multiplies 0 by infinity, and what becomes of the NaN depends on the order of operands and on the sign of
    the zero. No order is right for all: the case needs a rule of its own.

    Truth: A panel in every column from the first seam to the last.

    Source: A. Williams et al., An Efficient and Robust Ray-Box Intersection Algorithm (2005); T. Barnes,
    Fast, Branchless Ray/Bounding Box Intersections (2015)
    """
    left = np.arange(3.0, side - 4, 4) + 0.5 - past - 0.5 * side
    panels = [panel((x, x + 4.0), (-side, side), 1.0) for x in left.tolist()]
    return scene_of(parallel(side), *panels, wall(1.5, side))
