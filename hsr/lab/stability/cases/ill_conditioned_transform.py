"""A sphere flattened ever more: transforms that are hard to invert."""

from __future__ import annotations

import math

from hsr.lab.stability.building import central, powers_of_two, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.lab.stability.theory import U32, U64
from hsr.scene.model import Scene

TURN = [[0.36, 0.48, -0.8, 0.0], [-0.8, 0.6, 0.0, 0.0], [0.48, 0.64, 0.6, 0.0], [0.0, 0.0, 0.0, 1.0]]
"""A rotation by decimal fractions."""


def scene(condition: float, _: int) -> Scene:
    """Flatten a unit sphere along an axis that is seen at a slant, and fill the picture with it."""
    place = [{"scale": [1.0, 1.0, 1.0 / condition]}, {"matrix": TURN}, {"translate": [0.0, 0.0, -5.0]}]
    return scene_of(central(1.0, None, 4.0), {"shape": "sphere", "transform": place})


def first_wrong(rounding: float, side: int) -> float:
    """Return the condition number k at which the outline loses its first sample.

    Along the flattened axis the eye is ``h k`` away, and rounding the place of the ray's point nearest to
    the centre leaves that point ``e = u h k / 2`` outside the disc on average. Its distance grows by
    ``e^2 / 2``, and the outline of R pixels shrinks by ``R e^2 / 2``, over ``2 pi R`` samples.
    """
    eye, radius = 5.0 * TURN[2][2], 0.4 * side
    return 2.0 / (rounding * eye * radius * math.sqrt(math.pi))


FAMILY = Family(
    name="ill-conditioned-transform",
    group="rays",
    story=(
        "A sphere is flattened to a disc, and turned. Rays are carried into its frame by the inverse "
        "transform, which stretches what was flattened, and with it the rounding of the point that is "
        "nearest to the centre: the outline shrinks by the square of roundoff times condition number."
    ),
    expected="The ellipsoid inside its outline.",
    source=(
        "F. S. Hill, S. M. Kelley, Computer Graphics Using OpenGL, rays in the generic frame; G. Golub, C. "
        "Van Loan, Matrix Computations, 2.6"
    ),
    parameter="condition number of the transform",
    sweep=powers_of_two(2, 40, 2),
    scene=scene,
    variants=(
        Variant("raycast-woop-float32", lambda side: first_wrong(U32, side), "2^25 / (h R sqrt(pi))"),
        Variant("raycast-single", lambda side: first_wrong(U64, side), "2^54 / (h R sqrt(pi))"),
    ),
)
