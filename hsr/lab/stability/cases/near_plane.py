"""What reaches behind the eye, or lies at the near plane."""

from __future__ import annotations

import numpy as np

from hsr.lab.stability.building import central, closed_fan, mesh, rectangle, scene_of, wall
from hsr.lab.stability.family import Variant, buffer, hard_case, octaves, variants
from hsr.scene.model import Scene

BEHIND = (-2.0, -1.0, -0.5, -0.25, -0.125, -0.0625, 0.0, 0.0625, 0.125, 0.25, 0.5, 1.0, 2.0)


@hard_case("coverage", "distance of the corner behind the plane of the eye", BEHIND)
@variants(
    buffer("no clipping", 0.0, "0: the divide by w < 0 mirrors the corner"),
    Variant("scanline-direct", None, "clipped before the divide"),
)
def behind_the_eye(behind: float, _: int) -> Scene:
    """Let six triangles before a wall share a corner that lies so far behind the plane of the eye.

    Six triangles share a corner that moves through the plane of the eye. There its projection goes to
    infinity, and comes back from the other side: a divide without clipping turns the triangle inside out.
    Clipped, or tested by edges that need no divide, it runs off the picture in the right direction.

    Truth: The part of each triangle that lies before the near plane.

    Source: M. Olano, T. Greer, Triangle Scan Conversion Using 2D Homogeneous Coordinates (1997)
    """
    angle = np.arange(6) * (np.pi / 3.0) + 0.1
    rim = np.stack([3.0 * np.cos(angle), 3.0 * np.sin(angle), np.full(6, -4.0)], axis=1)
    star = mesh([[0.3, -1.2, behind], *rim], closed_fan(6))
    return scene_of(central(2.0**-6, None), star, wall(8.0, 16.0))


@hard_case("rays", "distance from the near plane, over the near distance", (*octaves(-2, -50, 2), 0.0))
@variants(
    buffer("float32 corners", 2.0**-25, "2^-25: half the spacing below 1", real=np.float32),
    Variant("opengl", 2.0**-25, "2^-25: half the spacing below 1"),
    Variant("embree", 2.0**-25, "2^-25: half the spacing below 1"),
    buffer("after near", 0.0, "0: near < depth in place of near <= depth", after_near=True),
)
def eye_on_surface(off: float, _: int) -> Scene:
    """Put the left of two panels behind the near plane, the right one before it, both before a wall.

    Two panels lie at the near plane, one a little behind it, one a little before it. What lies at the near
    distance exactly is seen, and what lies nearer is not. In float32 the panel in front is rounded onto the
    plane, and appears; who asks for more than the near distance loses both in the end.

    Truth: The left panel; the right one only where it touches the near plane.

    Source: J. Foley, A. van Dam, S. Feiner, J. Hughes, Computer Graphics: Principles and Practice, 6.5: the
    view volume is closed
    """
    panels = []
    for left, depth in ((-0.75, 1.0 + off), (0.125, 1.0 - off)):
        x, y = (left * depth, (left + 0.625) * depth), (-0.75 * depth, 0.75 * depth)
        panels.append(rectangle(x, y, depth))
    return scene_of(central(1.0), *panels, wall(2.0, 4.0))
