"""Views in which the classic mistakes of renderers show."""

from __future__ import annotations

import numpy as np

from hsr.problem.view import View, view
from hsr.scene.model import Scene


def prism() -> View:
    """A bar with a front and a back left and right, its upright edges through samples at +-2.5.

    The faces are numbered so that of the two that meet at an upright edge the front is first on the
    left, and the back on the right.
    """
    x, z = (-2.5, 0.0, 2.5, 0.0), (0.0, 1.0, 0.0, -1.0)
    vertices = [[x[k], y, z[k]] for y in (-2.0, 2.0) for k in range(4)]
    left_front, left_back, right_back, right_front = (0, 1), (3, 0), (2, 3), (1, 2)
    faces = []
    for a, b in (left_front, left_back, right_back, right_front):
        faces += [[a, b, b + 4], [a, b + 4, a + 4]]
    camera = {"type": "orthographic", "eye": [0.0, 0.0, 10.0], "height": 8.0, "far": 16.0}
    thing = {"name": "bar", "shape": "mesh", "vertices": vertices, "faces": faces}
    return view(Scene.model_validate({"camera": [camera], "object": [thing]}), (8, 8))


def soup(seed: int = 0, size: int = 48) -> View:
    """Triangles strewn before the eye: some cross the near plane, some turn their backs and are culled."""
    random = np.random.default_rng(seed)
    things = []
    for name, cull, scale in (("a", "none", 1.0), ("b", "back", 4.0)):
        centre = random.uniform([-1.0, -1.0, 0.0], [1.0, 1.0, 3.4], (24, 1, 3))
        corners = centre + random.uniform(-0.9, 0.9, (24, 3, 3))
        faces = np.arange(72).reshape(-1, 3).tolist()
        mesh = {"shape": "mesh", "vertices": (corners.reshape(-1, 3) / scale).tolist(), "faces": faces}
        things.append({"name": name, "cull": cull, "transform": [{"scale": scale}], **mesh})
    camera = {"type": "perspective", "eye": [0.1, 0.2, 5.0], "near": 1.3, "far": 10000.0}
    return view(Scene.model_validate({"camera": [camera], "object": things}), (size, size))


def close_pair(gap: float = 0.1) -> View:
    """Two squares at a distance at which 16 bits cannot tell them apart, the nearer one last."""
    squares = [
        {"name": name, "shape": "square", "transform": [{"scale": size}, {"translate": [0.0, 0.0, z]}]}
        for name, size, z in (("back", 40.0, -100.0), ("front", 30.0, -100.0 + gap))
    ]
    camera = {"type": "perspective", "eye": [0.013, 0.007, 1.0], "near": 0.1}
    return view(Scene.model_validate({"camera": [camera | {"far": 1000.0}], "object": squares}), (24, 24))


VIEWS = {"prism": prism, "soup": soup, "close pair": close_pair}
