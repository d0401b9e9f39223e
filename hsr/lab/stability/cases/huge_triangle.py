"""An edge through the picture whose ends are ever farther away."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import mesh, parallel, powers_of_two, scene_of, wall
from hsr.lab.stability.family import Family, Variant
from hsr.lab.stability.theory import U32
from hsr.mistakes.renderers import Buffer
from hsr.scene.model import Scene

OFF = 2.0**-6
"""How far from samples the edge passes, in pixels along y."""


def scene(length: float, side: int) -> Scene:
    """Lay an edge of slope 1/3 just below samples; its triangle reaches as far down."""
    left, right = ([0.5 + 3.0 * s * length, 0.5 + s * length - OFF, -1.0] for s in (-1.0, 1.0))
    return scene_of(
        parallel(side), mesh([left, [0.0, -4.0 * length, -1.0], right], [[0, 1, 2]]), wall(1.5, side)
    )


FAMILY = Family(
    name="huge-triangle",
    group="coverage",
    story=(
        "The edge of a triangle passes close to samples, and its ends move away along it, to where the "
        "picture is but a point. Rounding an end moves it by half the spacing of floats out there, and the "
        "edge in the picture moves with it. Clipping to the picture before anything is rounded keeps the "
        "numbers small."
    ),
    expected="The triangle at the samples below its edge, the wall at those above.",
    source=(
        "M. Olano, T. Greer, Triangle Scan Conversion Using 2D Homogeneous Coordinates (1997), external "
        "triangles"
    ),
    parameter="distance of the corners, in pixels",
    sweep=powers_of_two(4, 40, 3),
    scene=scene,
    variants=(
        Variant("float32 corners", OFF / U32, "2^24 off", mistake=Buffer(real=np.float32)),
        Variant("opengl", OFF / U32, "2^24 off: its corners are float32"),
        Variant("scanline-direct", None, "2^53 off, beyond the sweep"),
    ),
)
