"""One matrix for everything: the near distance drowns in the translation of the camera."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import central, moved, powers_of_two, scene_of
from hsr.lab.stability.family import Family, Variant
from hsr.mistakes.renderers import Buffer
from hsr.scene.model import Scene

NEAR = 2.0**-10
DEPTHS = (8.0, 2.0, 4.0)


def scene(away: float, _: int) -> Scene:
    """Put three walls before an eye, all moved along the view axis; they cover parts of each other."""
    walls = []
    for k, depth in enumerate(DEPTHS):
        place = {"translate": [0.4 * (k - 1) * depth, 0.0, away - depth]}
        walls.append({"shape": "square", "transform": [{"scale": 0.5 * depth}, place]})
    return scene_of(moved(central(NEAR, None), 0.0, 0.0, away), *walls)


FAMILY = Family(
    name="composed-matrix",
    group="depth",
    story=(
        "Scene and camera move away from the origin together. A single float32 matrix has the camera's "
        "position T in its rows for z and w, and in the one for z twice the near distance on top: once that "
        "is less than the spacing of float32 at T it is gone, z equals w for every depth, and the order is "
        "lost. Depth first and window depth after it keeps the near distance out of such company."
    ),
    expected="The nearest of three walls, as without the translation.",
    source=(
        "P. Upchurch, M. Desbrun, Tightening the Precision of Perspective Rendering (Journal of Graphics "
        "Tools 16, 2012)"
    ),
    parameter="distance of eye and scene from the origin, in scene units",
    sweep=powers_of_two(4, 30, 2),
    scene=scene,
    variants=(
        Variant("opengl", 2.0**25 * NEAR, "2 near 2^24: the constants of z and w become one number"),
        Variant(
            "composed",
            2.0**25 * NEAR,
            "2 near 2^24: the constants of z and w become one number",
            mistake=Buffer(real=np.float32, composed=True),
        ),
        Variant(
            "separate",
            2.0**25,
            "2^25: float32 no longer tells depths apart that differ by 2",
            mistake=Buffer(real=np.float32),
        ),
    ),
)
