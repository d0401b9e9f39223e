"""From world space to the screen: the camera's frame, the divide, the viewport, and back to depths.

Clip space here is the camera's own frame, its axes scaled to the view: a point is (x, y, d), x right,
y up, d its depth along the view axis in scene units. With w = d under perspective and w = 1 for a
parallel view, a point projects to ``(x / w, y / w)`` in normalised device coordinates, and the sides
of the view are ``|x| = w`` and ``|y| = w``.

On the screen, x runs right and y *down*, in pixels from the top left corner of the image, so that the
sample of row r, column c is ``(c + 0.5, r + 0.5)``. The third coordinate is window depth z, 0 at the
near plane and 1 at the far plane, the one depth that is affine on the screen:

    perspective   z = (1 - near / d) / (1 - near / far)       parallel   z = (d - near) / (far - near)

(Foley, van Dam, Feiner & Hughes, *Computer Graphics: Principles and Practice*, chapter 6: the canonical
view volumes and the perspective transformation of depth.)
"""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array, Floats
from hsr.base.jit import jit, parallel_jit, prange


@jit
def clip_rows(clip_from_world: Floats, depth_row: Floats) -> Floats:
    """Return the matrix that carries world points (x, y, z, 1) to clip space (x, y, d).

    Parameters
    ----------
    clip_from_world : (4, 4) float64
        OpenGL's clip space; its row for z is not read.
    depth_row : (4,) float64

    Returns
    -------
    (3, 4) float64
        The rows for x and y divided by what w is in units of d (perspective) or of 1 (parallel): by
        exactly 1 for the cameras that are placed by an eye and a target.
    """
    largest = 0
    for axis in range(1, 3):
        if abs(clip_from_world[3, axis]) > abs(clip_from_world[3, largest]):
            largest = axis
    along = clip_from_world[3, largest]
    scale = along / depth_row[largest] if along != 0.0 else clip_from_world[3, 3]
    rows = np.empty((3, 4))
    for k in range(4):
        rows[0, k], rows[1, k] = clip_from_world[0, k] / scale, clip_from_world[1, k] / scale
        rows[2, k] = depth_row[k]
    return rows


@parallel_jit
def to_clip(vertices: Floats, rows: Floats) -> Floats:
    """Carry world points (V, 3) to clip space (V, 3) by the matrix of :func:`clip_rows`."""
    clip = np.empty(vertices.shape)
    for i in prange(len(vertices)):
        x, y, z = vertices[i, 0], vertices[i, 1], vertices[i, 2]
        for k in range(3):
            clip[i, k] = rows[k, 0] * x + rows[k, 1] * y + rows[k, 2] * z + rows[k, 3]
    return clip


@parallel_jit
def to_screen(clip: Floats, perspective: bool, size: tuple[int, int], depths: tuple[float, float]) -> Floats:
    """Divide by w, map to the viewport, and replace depth by window depth.

    Parameters
    ----------
    clip : (V, 3) float64, clip space
        What lies behind the eye gives nonsense: clip first.
    perspective : bool
    size : (width, height) in pixels
    depths : (near, far)
        In scene units; far may be infinite.

    Returns
    -------
    (V, 3) float64
        x right, y down, in pixels; window depth z.
    """
    (width, height), (near, far), screen = size, depths, np.empty_like(clip)
    for i in prange(len(clip)):
        x, y, d = clip[i, 0], clip[i, 1], clip[i, 2]
        w = d if perspective else 1.0
        screen[i, 0] = (1.0 + x / w) * 0.5 * width
        screen[i, 1] = (1.0 - y / w) * 0.5 * height
        screen[i, 2] = (1.0 - near / d) / (1.0 - near / far) if perspective else (d - near) / (far - near)
    return screen


def to_depth(window: Array, perspective: bool, depths: tuple[float, float]) -> Floats:
    """Carry window depths back to depths along the view axis.

    Parameters
    ----------
    window : (H, W) float64 or float32
        Window depth of each sample, ``+inf`` where there is none. Overwritten if float64.
    perspective : bool
    depths : (near, far)
        In scene units; far may be infinite.

    Returns
    -------
    (H, W) float64
        Depths in scene units, ``+inf`` where there is none. Window depths that rounding has carried
        out of [0, 1] are clamped to it, as OpenGL does; if far is infinite, to the greatest number
        below 1, the farthest depth that can be told from infinity.
    """
    near, far = depths
    depth = window if window.dtype == np.float64 else np.empty(window.shape)
    last = 1.0 if far < np.inf else 1.0 - float(np.finfo(window.dtype).epsneg)
    _to_depth(window, perspective, near, far, last, depth)
    return depth


@parallel_jit
def _to_depth(window: Array, perspective: bool, near: float, far: float, last: float, depth: Floats) -> None:
    for row in prange(window.shape[0]):
        for column in range(window.shape[1]):
            z = float(window[row, column])
            inside = min(max(z, 0.0), last)
            seen = near / (1.0 - inside * (1.0 - near / far)) if perspective else near + inside * (far - near)
            depth[row, column] = seen if z < np.inf else np.inf


@jit
def nearness_of(depth: float, perspective: bool) -> float:
    """Return what grows as depth shrinks and is affine on the screen for the points of a plane.

    It is 1 / depth under perspective, infinite for what is not in front of the eye; -depth in a
    parallel view.
    """
    if not perspective:
        return -depth
    return 1.0 / depth if depth > 0.0 else np.inf
