"""Cameras that fit a scene: the whole of it in view, moved by some of their keys, or walking around it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from hsr.base.arrays import Floats
from hsr.base.errors import ViewError
from hsr.scene.model import Camera, MatrixCamera, Orthographic, Perspective, Placed
from hsr.scene.values import unit

OBLIQUE = (0.48, 0.36, 0.8)
"""Unit vector from the centre of a fitted view to its eye: from the right, above and in front."""

MARGIN = 1.05
"""How much farther away a fitted camera stands than it must."""

FITTED_FOV = 40.0
"""Narrower field of view of a fitted camera, in degrees."""

CLOSE = 1e-3
"""Near plane of a camera inside a scene, in radii of the scene."""


KEYS = ("eye", "target", "up", "fov", "height", "near", "far")
"""What options say of a camera: what places it, then near and far, which follow from that."""


class Ball(NamedTuple):
    """A sphere around a scene, in world space: centre (3,) float64 and radius, in scene units."""

    centre: Floats
    radius: float


def ball_around(points: Floats) -> Ball:
    """Return a sphere around points (n, 3), about the centre of their box."""
    centre = (points.min(axis=0) + points.max(axis=0)) / 2.0
    return Ball(centre, float(np.linalg.norm(points - centre, axis=1).max()) or 1.0)


def fitted(ball: Ball, name: str = "fitted") -> Perspective:
    """Look at the centre from so far that the ball is inside the narrower field of view."""
    distance = MARGIN * ball.radius / math.sin(math.radians(FITTED_FOV / 2.0))
    eye = ball.centre + distance * np.array(OBLIQUE)
    place: Any = {"eye": eye, "target": ball.centre, "near": (distance - ball.radius) / 2.0}
    return Perspective(type="perspective", name=name, fov=FITTED_FOV, fov_axis="min", **place)


def moved(camera: Camera, ball: Ball, **keys: Any) -> Perspective | Orthographic:
    """Return a camera with some of its keys replaced: what is not given stays as the camera has it.

    Where it has another place, or another projection, near and far are fitted to the scene unless given.

    Parameters
    ----------
    camera : Camera
        Not given by a matrix.
    ball : Ball
        Around the scene.
    **keys
        ``eye``, ``target``, ``up``, ``near``, ``far``; ``fov`` in degrees makes a perspective camera,
        ``height`` in scene units a parallel one.

    Raises
    ------
    ViewError
        If no picture can be taken with it.
    """
    if isinstance(camera, MatrixCamera):
        raise ViewError(f"camera {camera.name!r} is a matrix; only one with an eye and a target can move")
    if {"fov", "height"} <= keys.keys():
        raise ViewError("a perspective camera has fov, a parallel one height: leave one out")
    kind = Perspective if "fov" in keys else Orthographic if "height" in keys else type(camera)
    kept = {key: value for key, value in camera if key in kind.model_fields and key != "type"}
    if kind is not type(camera) or {"eye", "target"} & keys.keys():
        kept |= _near_and_far(kind, ball, kept | keys)
    return kind(**{**kept, **keys})


def _near_and_far(kind: type[Placed], ball: Ball, keys: Mapping[str, Any]) -> dict[str, Any]:
    """Return near and far of a camera that is to see all of a ball that lies before it."""
    sight = np.subtract(keys["target"], keys["eye"])
    middle = float(np.subtract(ball.centre, keys["eye"]) @ unit(sight))
    if kind is Orthographic:
        return {"near": 0.0, "far": MARGIN * max(middle + ball.radius, ball.radius)}
    front = (middle - ball.radius) / 2.0
    return {"near": max(front, CLOSE * ball.radius), "far": None}


def words(camera: Camera, base: Camera, ball: Ball) -> list[str] | None:
    """Return the options that make a camera of another, as every verb takes them; None if none do."""
    wanted = camera.model_copy(update={"name": base.name})
    if wanted == base:
        return []
    own = {key: value for key, value in camera if key in KEYS and value is not None}
    new = {key: value for key, value in own.items() if value != getattr(base, key, None)}
    placed = {key: value for key, value in new.items() if key in KEYS[:5]}
    for keys in (placed, new, own):
        with suppress(ViewError, ValueError):
            if moved(base, ball, **keys) == wanted:
                named = ((key.replace("height", "parallel"), value) for key, value in keys.items())
                return [word for name, value in named for word in (f"--{name}", _spelt(value))]
    return None


def _spelt(value: float | Sequence[float]) -> str:
    """Write a number or a vector so that it is read as the same."""
    return ",".join(np.format_float_positional(x, trim="-") for x in np.atleast_1d(value))


def turned(camera: Camera, angle: float, name: str | None = None) -> Camera:
    """Return a camera that has walked by an angle, in radians, around what it looks at, about its ``up``.

    Counter-clockwise as seen from above (Rodrigues' formula).

    Raises
    ------
    ViewError
        If it is given by a matrix.
    """
    if isinstance(camera, MatrixCamera):
        raise ViewError(f"camera {camera.name!r} is a matrix; only one with an eye and a target can turn")
    away, axis = np.subtract(camera.eye, camera.target), np.array(unit(camera.up))
    c, s = math.cos(angle), math.sin(angle)
    walked = c * away + s * np.cross(axis, away) + (1.0 - c) * (axis @ away) * axis
    eye = tuple(map(float, np.add(camera.target, walked)))
    return camera.model_copy(update={"eye": eye, "name": name or camera.name})
