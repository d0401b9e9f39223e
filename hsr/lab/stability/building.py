"""Cameras and things from which hard cases are built: small whole numbers, so that ties are exact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hsr.base.arrays import Floats, Ints
from hsr.scene.model import Scene

Thing = dict[str, Any]

PITCH = 8
"""Pixels from one line of a net to the next."""


# ---------------------------------------------------------------- cameras


def parallel(height: float, near: float = 0.0, far: float = 2.0) -> Thing:
    """Return a camera at the origin that looks along -z; one unit is a pixel if it is as high as the picture.

    The sample of row r, column c lies at ``x = c + 1/2 - width / 2``, ``y = height / 2 - r - 1/2``.
    """
    placed = {"type": "orthographic", "eye": [0.0, 0.0, 0.0], "target": [0.0, 0.0, -1.0]}
    return {**placed, "height": float(height), "near": near, "far": far}


def central(near: float = 1.0, far: float | None = None, zoom: float = 1.0) -> Thing:
    """Return an eye at the origin that looks along -z; at depth d the picture is ``2 d / zoom`` units wide.

    Near and far are read off the matrix exactly if there is no far plane, or ``far - near`` is a power of
    two.
    """
    a, b = -1.0, -2.0 * near
    if far is not None:
        a, b = -(far + near) / (far - near), b * far / (far - near)
    matrix = [[zoom, 0.0, 0.0, 0.0], [0.0, zoom, 0.0, 0.0], [0.0, 0.0, a, b], [0.0, 0.0, -1.0, 0.0]]
    return {"type": "matrix", "matrix": matrix}


def moved(camera: Thing, x: float, y: float, z: float) -> Thing:
    """Return a matrix camera moved by a vector; its constants are rounded once."""
    matrix = np.array(camera["matrix"])
    matrix[:, 3] -= matrix[:, :3] @ [x, y, z]
    return camera | {"matrix": matrix.tolist()}


# ---------------------------------------------------------------- corners


def samples(side: int, first: int, last: int, step: int) -> Floats:
    """Return x or y of some samples of a parallel view: of columns or rows from ``first`` to ``last``."""
    return np.arange(first, last, step, dtype=np.float64) + 0.5 - 0.5 * side


def flat(corners: ArrayLike) -> Floats:
    """Put corners (..., 2) across the view axis, at depth 1."""
    return np.insert(np.asarray(corners, np.float64).reshape(-1, 2), 2, -1.0, axis=1)


def seen(corners: ArrayLike, side: int) -> Floats:
    """Put corners (..., 2), in pixels from the middle, before an eye at the origin, at depth 1."""
    return flat(np.asarray(corners, np.float64) * (2.0 / side))


def grid(rows: int, columns: int) -> Ints:
    """Return the triangles of a grid of so many corners, two a square, cut from its first to its last."""
    a = (columns * np.arange(rows - 1)[:, None] + np.arange(columns - 1)).ravel()
    up, across = np.stack([a, a + 1, a + columns + 1], 1), np.stack([a, a + columns + 1, a + columns], 1)
    return np.concatenate([up, across])


def closed_fan(spokes: int) -> Ints:
    """Return the triangles of a closed fan about corner 0."""
    k = np.arange(spokes)
    return np.stack([0 * k, k + 1, (k + 1) % spokes + 1], axis=1)


def net(side: int, x: float, y: float) -> tuple[Floats, Ints]:
    """Return vertices (V, 2), in pixels, and triangles (n, 3) of a net that covers the picture.

    Every corner lies at a sample, but for the offset (x, y).
    """
    count = side // PITCH + 3
    line = (np.arange(count) - 1) * PITCH + 0.5 - 0.5 * side
    across, up = np.meshgrid(line + x, line + y)
    return np.stack([across.ravel(), up.ravel()], 1), grid(count, count)


def crumpled(side: int, x: float, y: float) -> tuple[Floats, Ints]:
    """Return a net before an eye at the origin, each of its corners (V, 3) at a depth of its own."""
    corners, triangles = net(side, x, y)
    depth = 2.0 + np.random.default_rng(0).integers(0, 65, len(corners)) / 64.0
    return depth[:, None] * seen(corners, side), triangles


# ---------------------------------------------------------------- things


def mesh(vertices: ArrayLike, faces: ArrayLike, **keys: Any) -> Thing:
    """Return a mesh of vertices (V, 3) and triangles (n, 3)."""
    corners, triangles = np.asarray(vertices, np.float64), np.asarray(faces)
    return {"shape": "mesh", "vertices": corners.tolist(), "faces": triangles.tolist(), **keys}


def loose(corners: ArrayLike) -> Thing:
    """Return a mesh of triangles (n, 3, 3) that share no corner."""
    vertices = np.asarray(corners, np.float64).reshape(-1, 3)
    return mesh(vertices, np.arange(len(vertices)).reshape(-1, 3))


def quads(corners: ArrayLike) -> Thing:
    """Return a mesh of quadrangles (n, 4, 3), each two triangles along its first diagonal."""
    vertices = np.asarray(corners, np.float64).reshape(-1, 3)
    first = np.arange(0, len(vertices), 4)[:, None]
    return mesh(vertices, (first + np.array([[0, 1, 2, 0, 2, 3]])).reshape(-1, 3))


def rectangle(x: Sequence[float], y: Sequence[float], depth: float) -> Thing:
    """Return a mesh of one rectangle ``[x0, x1] x [y0, y1]`` across the view axis."""
    (x0, x1), (y0, y1), z = x, y, -depth
    return quads([[[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]]])


def panel(x: Sequence[float], y: Sequence[float], depth: float) -> Thing:
    """Return a rectangle ``[x0, x1] x [y0, y1]`` across the view axis as a single face."""
    half = [0.5 * (x[1] - x[0]), 0.5 * (y[1] - y[0]), 1.0]
    middle = [0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]), -depth]
    return placed("square", half, middle)


def wall(depth: float, reach: float) -> Thing:
    """Return a square face across the view axis, so large that it fills the picture."""
    return placed("square", reach, [0.0, 0.0, -depth])


def placed(shape: str, scale: float | Sequence[float], at: Sequence[float]) -> Thing:
    """Return a generic shape, scaled, then moved."""
    return {"shape": shape, "transform": [{"scale": scale}, {"translate": at}]}


def scene_of(camera: Thing, *things: Mapping[str, Any], segments: int = 24) -> Scene:
    """Return a scene of these things, named in turn."""
    named = [{"name": f"{thing['shape']} {k}", **thing} for k, thing in enumerate(things)]
    return Scene.model_validate({"camera": [camera], "object": named, "segments": segments})
