"""Projection: from the description of a camera to the matrix that projects its world.

Clip space is OpenGL's: a world point p becomes ``(x, y, z, w) = clip_from_world @ (p, 1)``, and
``(x / w, y / w)`` are its normalised device coordinates, x to the right, y up, each from -1 to 1
over the image; z runs from -w at the near plane to w at the far plane. The camera looks along -z
of its own frame (Foley, van Dam et al., Computer Graphics, section 6.5).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hsr.base.arrays import Floats
from hsr.base.errors import ViewError
from hsr.scene.model import Camera, MatrixCamera, Orthographic, Perspective
from hsr.scene.values import exact_determinant, unit

OBLIQUE = 2.0**-22
"""How far a z row may lean from the w row, relative to its largest entry.

The entries of a matrix that went through float32 are off by up to 2^-24 of themselves, so two
rows that should be parallel lean by up to 2^-23; twice that is allowed.
"""


class Projection(NamedTuple):
    """What a camera amounts to for an image of some shape.

    Attributes
    ----------
    clip_from_world : (4, 4) float64
    depth_row : (4,) float64
        The depth of a world point p is ``depth_row @ (p, 1)``, in scene units.
    near, far : float
        Depths of the clipping planes; far may be infinite.
    """

    clip_from_world: Floats
    depth_row: Floats
    near: float
    far: float

    @property
    def perspective(self) -> bool:
        """Whether lines of sight meet in an eye (else they are parallel)."""
        return bool(self.clip_from_world[3, :3].any())

    @property
    def mirrored(self) -> bool:
        """Whether a figure that is counter-clockwise to the eye is clockwise on the screen.

        Right, up and the direction of sight form a left-handed frame, so the determinant of the
        rows x, y and depth is negative for a camera that does not mirror.
        """
        rows = [self.clip_from_world[0, :3], self.clip_from_world[1, :3], self.depth_row[:3]]
        return exact_determinant(rows) > 0


def projection_of(camera: Camera, aspect: float) -> Projection:
    """Return the projection of a camera.

    Parameters
    ----------
    camera : Perspective, Orthographic or MatrixCamera
    aspect : float
        Width of the image / its height. A matrix camera has its own.

    Returns
    -------
    Projection

    Raises
    ------
    ViewError
        If a matrix has no usable near and far plane, or numbers overflow. The message does not
        name the camera.
    """
    with np.errstate(all="ignore"):
        projection = _projection(camera, aspect)
    rows = np.vstack([projection.clip_from_world, projection.depth_row])
    if not np.isfinite(rows).all() or exact_determinant(projection.clip_from_world) == 0:
        raise ViewError("its numbers are too extreme: the projection over- or underflows float64")
    return projection


def named_projection(camera: Camera, aspect: float) -> Projection:
    """Return the projection of a camera as :func:`projection_of`; a problem names the camera."""
    try:
        return projection_of(camera, aspect)
    except ViewError as error:
        raise ViewError(f"camera {camera.name!r}: {error}") from None


def _projection(camera: Camera, aspect: float) -> Projection:
    if not isinstance(camera, MatrixCamera):
        return _placed(camera, aspect)
    clip = np.array(camera.matrix)
    return _perspective_matrix(clip) if clip[3, :3].any() else _parallel_matrix(clip)


def half_tangents(camera: Perspective, aspect: float) -> tuple[float, float]:
    """Return tan(fov / 2) along x and along y for an image of this width / height."""
    tangent = math.tan(math.radians(camera.fov) / 2.0)
    along_x = camera.fov_axis == "x" or (camera.fov_axis == "min" and aspect < 1.0)
    return (tangent, tangent / aspect) if along_x else (tangent * aspect, tangent)


def eye_of(projection: Projection) -> Floats:
    """Return the eye (3,) of a perspective projection, in world space: there x, y and w vanish."""
    rows = projection.clip_from_world[[0, 1, 3]]
    return np.asarray(np.linalg.solve(rows[:, :3], -rows[:, 3]), dtype=np.float64)


# ---------------------------------------------------------------- perspective and orthographic


def _camera_from_world(camera: Perspective | Orthographic) -> Floats:
    """Rows: right, up, backward; the camera looks along -z of its own frame."""
    eye = np.array(camera.eye)
    backward = np.array(unit(eye - np.array(camera.target)))
    right = np.array(unit(np.cross(unit(camera.up), backward)))
    axes = np.stack([right, np.cross(backward, right), backward])
    # Adding zero turns -0 into 0.
    return np.block([[axes, -(axes @ eye)[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]]) + 0.0


def _placed(camera: Perspective | Orthographic, aspect: float) -> Projection:
    pose = _camera_from_world(camera)
    depth_row, near = -pose[2], camera.near
    far = math.inf if camera.far is None else camera.far
    if isinstance(camera, Perspective):
        (half_x, half_y), ratio = half_tangents(camera, aspect), near / far
        z_scale, z_offset = (1.0 + ratio) / (1.0 - ratio), -2.0 * near / (1.0 - ratio)
        z_row, w_row = z_scale * depth_row + [0.0, 0.0, 0.0, z_offset], depth_row
    else:
        half_x, half_y = camera.height / 2.0 * aspect, camera.height / 2.0
        z_row = (2.0 * depth_row - [0.0, 0.0, 0.0, far + near]) / (far - near)
        w_row = np.array([0.0, 0.0, 0.0, 1.0])
    return Projection(np.stack([pose[0] / half_x, pose[1] / half_y, z_row, w_row]), depth_row, near, far)


# ---------------------------------------------------------------- matrices


def _perspective_matrix(clip: Floats) -> Projection:
    """Read depth, near and far off a matrix whose depth is w, in units of length."""
    z_row, w_row = clip[2], clip[3]
    scale = math.hypot(*w_row[:3])
    depth_row = w_row / scale
    # Along the view axis z = a depth + b: z = -w at depth -b / (a + scale), z = w at b / (scale - a).
    a = float(z_row[:3] @ depth_row[:3])
    b = float(z_row[3] - a * depth_row[3])
    if np.abs(z_row[:3] - a * depth_row[:3]).max() > OBLIQUE * np.abs(z_row[:3]).max():
        raise ViewError("its near plane is oblique; the third row must be parallel to the fourth")
    near = -b / (a + scale) if a != -scale else math.inf
    far = b / (scale - a) if a != scale else math.inf
    # Rounding may push an infinite far plane beyond infinity, where it comes back from behind.
    far = far if far > 0.0 else math.inf
    if not 0.0 < near < far:
        raise ViewError(f"its near plane is at {near:g} and its far plane at {far:g}; needed 0 < near < far")
    return Projection(clip, depth_row, near, far)


def _parallel_matrix(clip: Floats) -> Projection:
    """Count depth from the near plane, along the z row."""
    z_row, w = clip[2], float(clip[3, 3])
    if w <= 0.0:
        raise ViewError(f"the last entry of a parallel matrix must be positive, got {w:g}")
    scale = math.hypot(*z_row[:3])
    depth_row = (z_row + np.array([0.0, 0.0, 0.0, w])) / scale
    return Projection(clip, depth_row, 0.0, 2.0 * w / scale)
