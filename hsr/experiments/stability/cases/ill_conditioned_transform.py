"""A sphere flattened ever more: transforms that are hard to invert."""

from __future__ import annotations

import math

from hsr.experiments.stability.building import central, powers_of_two, scene_of
from hsr.experiments.stability.family import Family, Variant
from hsr.experiments.stability.theory import U32
from hsr.scene.model import Scene

TURN = [[0.36, 0.48, -0.8, 0.0], [-0.8, 0.6, 0.0, 0.0], [0.48, 0.64, 0.6, 0.0], [0.0, 0.0, 0.0, 1.0]]
"""A rotation by decimal fractions."""


def scene(condition: float, _: int) -> Scene:
    """Flatten a unit sphere along an axis that is seen at a slant, and fill the picture with it."""
    place = [{"scale": [1.0, 1.0, 1.0 / condition]}, {"matrix": TURN}, {"translate": [0.0, 0.0, -5.0]}]
    return scene_of(central(1.0, None, 4.0), {"shape": "sphere", "transform": place})


def first_wrong(side: int) -> float:
    """Return the condition number at which the band about the outline holds a sample.

    Rays in object space are off by ``u k``, and so is the outline, of R = 0.4 W pixels, ``2 pi R`` samples.
    """
    return 1.0 / (2.0 * math.pi * (0.4 * side) ** 2 * U32)


FAMILY = Family(
    name="ill-conditioned-transform",
    group="rays",
    story=(
        "A sphere is flattened to a disc, and turned. Rays are carried into its frame by the inverse "
        "transform, which stretches what was flattened, and the rounding of the ray with it: the outline is "
        "off by the unit roundoff times the condition number."
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
        Variant("raycast-woop-float32", first_wrong, "2^24 / (2 pi (0.4 W)^2)", 16.0),
        Variant("raycast-single", lambda side: 2.0**29 * first_wrong(side), "2^53 / (2 pi (0.4 W)^2)", 16.0),
    ),
)
