"""The camera of a view in the conventions of other programs; their words stand in ``conventions.json``."""

from __future__ import annotations

import json
import math
from importlib.resources import files
from typing import Any

import numpy as np

from hsr.base.arrays import Floats
from hsr.base.errors import ViewError
from hsr.problem.view import View
from hsr.scene.camera import OBLIQUE

SHEARED = (
    "the camera mirrors or shears what it sees, which those of other programs do not; "
    "take one with an eye and a target: --eye 2,2,4"
)


def frame_from_world(view: View) -> Floats:
    """Return the matrix (4, 4) from world space to right, up and depth of the camera.

    Raises
    ------
    ViewError
        If the camera mirrors or shears what it sees.
    """
    rows, depth = view.clip_from_world[:2], view.depth_row
    if view.perspective:  # the centre of the picture may lie beside the axis: it moves with the depth
        rows = rows - np.outer(rows[:, :3] @ depth[:3], depth)
    right, up = (row / math.hypot(*row[:3]) for row in rows)
    frame = np.stack([right, up, depth, [0.0, 0.0, 0.0, 1.0]])
    axes = frame[:3, :3]
    if np.abs(axes @ axes.T - np.eye(3)).max() > OBLIQUE or np.linalg.det(axes) > 0:
        raise ViewError(SHEARED)
    return frame


def conventions(view: View) -> dict[str, Any]:
    """Describe the camera of a view: its planes, its size, and its matrices as four programs have them.

    Parameters
    ----------
    view : View

    Returns
    -------
    dict
        JSON values. ``clip_from_world`` is that of the view, exactly; the others are made of it.

    Raises
    ------
    ViewError
        If the camera mirrors or shears what it sees.
    """
    frame, size = frame_from_world(view), np.array([view.width, view.height])
    clip_from_frame = view.clip_from_world @ np.linalg.inv(frame)
    focal, centre = clip_from_frame[[0, 1], [0, 1]], clip_from_frame[:2, 2]
    scale = clip_from_frame[3, 2 if view.perspective else 3]
    (x, y), (centre_x, centre_y) = focal / scale * size, centre / scale * size
    left_up, square = np.array([-1.0, 1.0, 1.0])[:, None] * frame[:3], size.min()
    clip = {"clip_from_world": view.clip_from_world.tolist()}
    middle_x, middle_y = (view.width + centre_x - 1.0) / 2.0, (view.height - centre_y - 1.0) / 2.0
    numbers: dict[str, dict[str, Any]] = {
        "opengl": {
            "camera_from_world": (np.diag([1.0, 1.0, -1.0, 1.0]) @ frame).tolist(),
            "clip_from_camera": (clip_from_frame * [1.0, 1.0, -1.0, 1.0]).tolist(),
            **clip,
        },
        "opencv": {
            "camera_from_world": (np.diag([1.0, -1.0, 1.0, 1.0]) @ frame).tolist(),
            "K": [[x / 2.0, 0.0, middle_x], [0.0, y / 2.0, middle_y], [0.0, 0.0, 1.0]],
        },
        "pytorch3d": {
            "camera": "PerspectiveCameras" if view.perspective else "OrthographicCameras",
            "R": left_up[:, :3].T.tolist(),
            "T": left_up[:, 3].tolist(),
            "focal_length": [x / square, y / square],
            "principal_point": [-centre_x / square, centre_y / square],
            "in_ndc": True,
            "image_size": [view.height, view.width],
        },
        "nvdiffrast": clip | {"resolution": [view.height, view.width]},
    }
    words = json.loads(files(__package__).joinpath("conventions.json").read_text(encoding="utf-8"))
    planes = {"near": view.near, "far": view.far if math.isfinite(view.far) else None}
    seen = {"size": [view.width, view.height], **planes, "perspective": view.perspective}
    return seen | {name: words[name] | numbers[name] for name in words}
