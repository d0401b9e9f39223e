"""Spheres and cylinders: quadratic equations whose terms cancel."""

from __future__ import annotations

import math

from hsr.lab.stability.building import central, parallel, placed, scene_of, wall
from hsr.lab.stability.family import Variant, hard_case, octaves, variants
from hsr.lab.stability.rounding import first_drafts
from hsr.lab.stability.theory import U32, U64
from hsr.mistakes.renderers import general_cylinders, naive_spheres
from hsr.scene.model import Scene

SHARE = 0.8
"""Radius of the distant sphere in the picture, over half the picture."""


def outline(side: int) -> float:
    """Return how many samples a band about the outline holds, of a width of one radius: ``2 pi R^2``."""
    return 2.0 * math.pi * (0.5 * SHARE * side) ** 2


@hard_case("rays", "distance, in radii", octaves(2, 36, 2))
@variants(
    *first_drafts(
        "naive",
        naive_spheres,
        lambda unit, side: (outline(side) * unit) ** -0.5,
        "sqrt(2^24 / (2 pi R^2)): a band of u D^2 about the outline",
        "sqrt(2^53 / (2 pi R^2))",
    ),
    Variant(
        "raycast-woop-float32",
        lambda side: 4.0 / (outline(side) * U32),
        "2^26 / (2 pi R^2): a band of u D / 4, half a spacing on average",
    ),
)
def distant_sphere(away: float, _: int) -> Scene:
    """Look at a unit sphere from so far away, aslant, and fill the picture with it.

    A unit sphere stands D away and fills the view. The discriminant b^2 - a c is the difference of two
    numbers like D^2, so its rounding decides in a band about the outline that grows with D^2, and beyond
    D^2 = 2^24, in float32, the sphere is gone. Measuring from the point of the ray nearest to the centre
    leaves a band that grows with D alone.

    Truth: The sphere inside its outline, the background outside.

    Source: E. Haines, J. Guenther, T. Akenine-Moeller, Precision Improvements for Ray/Sphere Intersection
    (Ray Tracing Gems, 2019)
    """
    camera = {"type": "perspective", "eye": [0.48 * away, 0.64 * away, 0.6 * away], "near": 0.5 * away}
    fov = math.degrees(2.0 * math.atan(1.0 / (SHARE * away)))
    return scene_of(camera | {"fov": fov}, {"shape": "sphere"})


RADIUS = 6.4e6


def lowest(unit: float, side: int) -> float:
    """Return the height at which rounding the eye's place costs the first sample on the horizon.

    The eye's distance from the centre is rounded by ``u r``. A height h off by that moves the horizon, a
    quarter of the picture below eye level, by ``u r / (2 h)`` of that. Samples lie at fifths of a pixel from
    a line turned by 3, 4 and 5, so the nearest is off by a tenth at most.
    """
    return 10.0 * unit * RADIUS * side / 8.0


# Powers themselves are not rounded.
@hard_case("rays", "height above the ground, in metres", tuple(0.7 * h for h in octaves(16, -28, 2)))
@variants(
    Variant("raycast-woop-float32", lambda side: lowest(U32, side), "2^-24 r W 10 / 8"),
    # At most heights the eye's place is off by less than the whole of u r.
    *first_drafts("naive", naive_spheres, lowest, "2^-24 r W 10 / 8", "2^-53 r W 10 / 8", factor=4.0),
)
def planet(height: float, _: int) -> Scene:
    """Look at the horizon of a planet from the origin, turned by the angle of the triangle of 3, 4 and 5.

    The eye looks at the horizon of a planet, from ever lower above the ground. All there is to tell height by
    is the difference of two numbers of the size of the planet: in float32 they are half a metre apart, and
    the horizon is anywhere; float64 knows nanometres.

    Truth: The planet below the horizon, the sky above.

    Source: E. Haines, J. Guenther, T. Akenine-Moeller, Precision Improvements for Ray/Sphere Intersection
    (Ray Tracing Gems, 2019)
    """
    dip = math.sqrt(2.0 * height / RADIUS)
    zoom, near = 0.5 / dip, 0.125 * height
    matrix = [
        [0.8 * zoom, -0.6 * zoom, 0.0, 0.0],
        [0.6 * zoom, 0.8 * zoom, -0.5, 0.0],  # the horizon runs through the middle
        [0.0, 0.0, -1.0, -2.0 * near],
        [0.0, 0.0, -1.0, 0.0],
    ]
    ball = placed("sphere", RADIUS, [0.0, -(RADIUS + height), 0.0])
    return scene_of({"type": "matrix", "matrix": matrix}, ball)


RADII = 64.0
"""Distance of touched spheres, in radii."""


def touched(side: int) -> float:
    """Return the radius of touched spheres, in pixels, such that they touch samples on the right alone."""
    return side / 16.0 + 0.3


@hard_case("rays", "how far rays enter or miss, in pixels", octaves(-1, -47, 2))
@variants(
    *first_drafts(
        "naive",
        naive_spheres,
        lambda unit, side: unit * RADII**2 * touched(side),
        "2^-24 k^2 r, at k radii",
        "2^-53 k^2 r, at k radii",
    ),
    Variant("raycast-woop-float32", lambda side: U32 * touched(side), "2^-24 r"),
)
def tangent_rays(depth: float, side: int) -> Scene:
    """Let rays enter the right borders of 4 x 4 spheres by so many pixels, and miss others by as many.

    Rays run past spheres at almost their radius: half of them enter by a little, half miss by as much. The
    sign of the discriminant is all that tells, and it is as small as that little. Computed as b^2 - a c it
    carries the rounding of the squared distance; from the nearest point of the ray, that of the radius.

    Truth: A sphere at every other of the tangent samples.

    Source: F. S. Hill, S. M. Kelley, Computer Graphics Using OpenGL, intersecting rays with a sphere; Haines,
    Guenther, Akenine-Moeller (2019)
    """
    r, spheres = touched(side), []
    for row in range(4):
        for column in range(4):
            inside = depth if (row + column) % 2 else -depth
            x, y = ((k + 0.5) * side / 4 + 0.5 - 0.5 * side for k in (column, row))
            spheres.append(placed("sphere", r, [x + inside - r, y, -RADII * r]))
    return scene_of(parallel(side, 0.0, 2.0 * RADII * r), *spheres, segments=8)


TURN = [[0.36, 0.48, -0.8, 0.0], [-0.8, 0.6, 0.0, 0.0], [0.48, 0.64, 0.6, 0.0], [0.0, 0.0, 0.0, 1.0]]
"""A rotation by decimal fractions."""


def worst_condition(unit: float, side: int) -> float:
    """Return the condition number k at which the outline loses its first sample.

    Along the flattened axis the eye is ``h k`` away, and rounding the place of the ray's point nearest to
    the centre leaves that point ``e = u h k / 2`` outside the disc on average. Its distance grows by
    ``e^2 / 2``, and the outline of R pixels shrinks by ``R e^2 / 2``, over ``2 pi R`` samples.
    """
    eye, radius = 5.0 * TURN[2][2], 0.4 * side
    return 2.0 / (unit * eye * radius * math.sqrt(math.pi))


@hard_case("rays", "condition number of the transform", octaves(2, 40, 2))
@variants(
    Variant("raycast-woop-float32", lambda side: worst_condition(U32, side), "2^25 / (h R sqrt(pi))"),
    Variant("raycast-single", lambda side: worst_condition(U64, side), "2^54 / (h R sqrt(pi))"),
)
def ill_conditioned_transform(condition: float, _: int) -> Scene:
    """Flatten a unit sphere along an axis that is seen at a slant, and fill the picture with it.

    A sphere is flattened to a disc, and turned. Rays are carried into its frame by the inverse transform,
    which stretches what was flattened, and with it the rounding of the point that is nearest to the centre:
    the outline shrinks by the square of roundoff times condition number.

    Truth: The ellipsoid inside its outline.

    Source: F. S. Hill, S. M. Kelley, Computer Graphics Using OpenGL, rays in the generic frame; G. Golub, C.
    Van Loan, Matrix Computations, 2.6
    """
    place = [{"scale": [1.0, 1.0, 1.0 / condition]}, {"matrix": TURN}, {"translate": [0.0, 0.0, -5.0]}]
    return scene_of(central(1.0, None, 4.0), {"shape": "sphere", "transform": place})


SEGMENTS = 24


def flattest(step: float, side: int) -> float:
    """Return the thickness at which the samples next to the contact are within a step.

    At x pixels from it the sphere is ``t x^2 / (2 r^2)`` behind the wall, and those samples have x^2 = 1/2.
    """
    return 4.0 * step * (0.4 * side) ** 2


def touching_polygons(method: str, bits: int) -> Variant:
    """Return the theory for a tessellated sphere, which touches with a corner.

    Its sides fall off by ``t x tan(a / 2) / r``, a being the angle from the pole to the first ring.
    """
    told, slope = "sqrt(2) q r / tan(pi / 24): polygons touch with a corner", math.tan(math.pi / SEGMENTS)
    return Variant(method, lambda side: math.sqrt(2.0) * 2.0**-bits * (0.4 * side) / slope, told)


@hard_case("order", "thickness of the sphere, in depth ranges", octaves(-2, -34, 2))
@variants(
    touching_polygons("scanline-d16", 16),
    touching_polygons("scanline-d24", 24),
    # Less than a step apart depths are equal or not, by where they lie between floats.
    Variant("raycast-woop-float32", lambda side: flattest(2.0**-25, side), "4 r^2 2^-25", 4.0),
    touching_polygons("opengl", 24),
)
def touching_solids(thickness: float, side: int) -> Scene:
    """Let a flattened sphere touch a wall from behind, in the middle of the picture.

    A sphere touches a wall from behind. In exact arithmetic it touches in one point, which no sample sees; in
    a depth buffer it shines through within a disc about that point, whose radius is the root of 2 r dz. The
    flatter the sphere the wider the disc.

    Truth: The wall everywhere.

    Source: Derived: sqrt(2 r dz), the sagitta of a sphere of radius r
    """
    r = 0.4 * side
    ball = placed("sphere", [r, r, thickness], [0.0, 0.0, -0.4 - thickness])
    return scene_of(parallel(side, 0.0, 1.0), ball, wall(0.4, side), segments=SEGMENTS)


@hard_case("rays", "greatest tilt of a ray against the axis", octaves(-2, -36, 2))
@variants(
    *first_drafts(
        "general axis,",
        general_cylinders,
        lambda unit, _: unit**0.5,
        "2^-12: tilt^2 = 2^-24",
        "2^-26.5: tilt^2 = 2^-53",
    ),
    Variant(
        "raycast-single", lambda side: 0.5 * side * side * U64, "2^-53 W^2 / 2: the distance to the wall"
    ),
)
def cylinder_along_axis(tilt: float, _: int) -> Scene:
    """Look along a tube from within, close to its wall, by a view no wider than the tilt.

    The eye is in a tube, close to the wall, and looks along it through an ever narrower view. For an axis of
    any direction textbooks have a = d.d - (d.axis)^2 in the quadratic equation of the wall: of two numbers
    near 1 a difference of the size of the squared tilt is left. In the cylinder's own frame it is
    dx^2 + dy^2, and nothing cancels.

    Truth: The wall where the ray leaves through it, the cap at the end elsewhere.

    Source: F. S. Hill, S. M. Kelley, Computer Graphics Using OpenGL, intersecting rays with a cylinder
    """
    tube = placed("cylinder", [1.0, 1.0, -1.0], [0.5 * tilt - 1.0, 0.0, 0.25])
    return scene_of(central(0.125, None, 1.0 / tilt), tube)
