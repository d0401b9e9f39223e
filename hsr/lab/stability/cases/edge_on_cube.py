"""A cube turned until one face is seen almost edge-on."""

from __future__ import annotations

import math

from hsr.lab.stability.building import parallel, powers_of_two, scene_of
from hsr.lab.stability.family import Family
from hsr.lab.stability.rounding import on_screen, snapped
from hsr.scene.model import Scene


def scene(width: float, side: int) -> Scene:
    """Turn a cube about the y axis until its right face is so many pixels wide; samples lie within it.

    The turn has the sine 2 t / (1 + t^2) and the cosine (1 - t^2) / (1 + t^2), rational as t is.
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


FAMILY = Family(
    name="edge-on-cube",
    group="coverage",
    story=(
        "A cube is turned, by Pythagorean angles, until its right face is seen almost edge-on; a column of "
        "samples stays in the middle of that face. Which side of the face is seen is the sign of the area "
        "of its projection. Where corners are rounded, to a grid or to float32, the area becomes 0 or "
        "changes its sign, and the face is culled."
    ),
    expected="The right face in its column of samples, the front face to the left of it.",
    source="D. Hearn, M. P. Baker, Computer Graphics, back-face detection",
    parameter="width of the right face on the screen, in pixels",
    sweep=powers_of_two(0, -32, 2),
    scene=scene,
    variants=(*snapped(2.0), *on_screen(2.0)),
)
