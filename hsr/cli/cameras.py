"""Where to look from: the options of every verb that takes a scene, declared once."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from typer import BadParameter, Option

from hsr.base.errors import HsrError
from hsr.cli.common import with_options

if TYPE_CHECKING:
    from hsr.scene.model import Camera, Scene

ALL = "all"
"""In place of the name of a camera: every one of the scene."""


def vector(text: str) -> tuple[float, float, float]:
    """Read X,Y,Z.

    Raises
    ------
    typer.BadParameter
        If it is written in another way.
    """
    try:
        x, y, z = map(float, text.split(","))
    except ValueError:
        raise BadParameter(f"{text!r}: write X,Y,Z, such as 2.5,2,4") from None
    return x, y, z


option = partial(Option, rich_help_panel="Camera")
triple = partial(option, parser=vector, metavar="X,Y,Z")
Number = float | None

OPTIONS: Mapping[str, Any] = {
    "camera": Annotated[list[str] | None, option(help="By its name, repeatable, or 'all'; else the first.")],
    "eye": Annotated[Any, triple(help="Where it stands; what is not said stays as the camera has it.")],
    "target": Annotated[Any, triple(help="What it looks at.")],
    "up": Annotated[Any, triple(help="What is up in the picture.")],
    "fov": Annotated[Number, option(metavar="DEG", help="Field of view, of a perspective camera.")],
    "height": Annotated[Number, option("--parallel", metavar="H", help="Height seen by a parallel camera.")],
    "near": Annotated[Number, option(help="Least depth that is seen; fits the scene if the camera moves.")],
    "far": Annotated[Number, option(help="Greatest depth that is seen.")],
    "orbit": Annotated[int | None, option(min=2, max=360, help="So many cameras around the target.")],
}


class Cameras(NamedTuple):
    """The cameras asked for: by their names, some of their keys replaced, in a circle around the target.

    Without any option that is the first of each scene.
    """

    names: list[str]
    orbit: int | None
    keys: dict[str, Any]

    def of(self, scene: Scene) -> tuple[Camera, ...]:
        """Return what is asked for of a scene.

        Raises
        ------
        HsrError
            If there is no such camera, or none can be made of what is given.
        """
        from hsr.scene.files import ball_of
        from hsr.scene.fitting import moved, turned

        chosen = self._named(scene)
        if self.keys:
            ball = ball_of(scene)
            chosen = tuple(moved(camera, ball, **self.keys) for camera in chosen)
        if self.orbit is None:
            return chosen
        angles = [360.0 * k / self.orbit for k in range(self.orbit)]
        around = ((camera, angle) for camera in chosen for angle in angles)
        return tuple(turned(c, math.radians(angle), f"{c.name}-{angle:.0f}") for c, angle in around)

    def scenes(self, name: str, scene: Scene) -> list[tuple[str, Scene]]:
        """Return the scene once a camera, with that camera alone, and what to call each."""
        seen = [(camera.name, scene.model_copy(update={"camera": (camera,)})) for camera in self.of(scene)]
        return [(name if len(seen) == 1 else f"{name}, {camera}", one) for camera, one in seen]

    def one(self, scene: Scene) -> Scene:
        """Return the scene with the one camera that is asked for.

        Raises
        ------
        HsrError
            If there are several.
        """
        ((_, seen), *others) = self.scenes("", scene)
        if others:
            raise HsrError(f"this needs one camera, not {1 + len(others)}; choose one by --camera")
        return seen

    def _named(self, scene: Scene) -> tuple[Camera, ...]:
        from hsr.problem.view import camera_named

        if self.names == [ALL] and all(camera.name != ALL for camera in scene.camera):
            return scene.camera
        return tuple(camera_named(scene, name) for name in dict.fromkeys(self.names)) or scene.camera[:1]


def _cameras(keys: dict[str, Any]) -> Cameras:
    return Cameras(keys.pop("camera", []), keys.pop("orbit", None), keys)


with_cameras = with_options("cameras", OPTIONS, _cameras)
"""Gives a verb the options of where to look from in place of its argument ``cameras``."""
