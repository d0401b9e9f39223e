"""What the maps of a check show, as far as the test says so."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from hsr.algorithms.registry import render
from hsr.base.errors import CheckError
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View, view
from hsr.scene.files import load
from hsr.scene.model import Scene

Showing = Scene | View | str | Path | None
"""What a test may give as its scene: a scene, its file, the view itself, or nothing."""


Maps = Mapping[str, VisibilityMap]
"""Maps by the name under which a message speaks of them."""


@dataclass(frozen=True, eq=False)
class Subject:
    """What the maps of a check show, where the test says so: it makes the truth known.

    Attributes
    ----------
    view : View
    file : str
        The scene file, empty if the test names none.
    scene : Scene or None
        The scene, None if the test gives a view alone.
    camera : str
        Name of the camera in it, empty for the first.
    """

    view: View
    file: str = ""
    scene: Scene | None = None
    camera: str = ""

    @cached_property
    def truth(self) -> VisibilityMap:
        """The exact map, with its ties."""
        return render(self.view, "exact")


def subject_of(scene: Showing, camera: str | None, shown: VisibilityMap) -> Subject | None:
    """Return what a map shows, from what a test says of it; nothing if it says nothing.

    Parameters
    ----------
    scene : Scene, View, str, Path or None
    camera : str or None
        Name of the camera; the scene's first by default.
    shown : VisibilityMap
        Gives the size of the image.

    Raises
    ------
    HsrError
        If the scene cannot be read, has no such camera, or the map is not one of its faces.
    """
    if scene is None:
        return None
    file = str(scene) if isinstance(scene, str | Path) else ""
    given = load(file) if file else scene
    if isinstance(given, Scene):
        found = Subject(view(given, (shown.width, shown.height), camera), file, given, camera or "")
    elif isinstance(given, View):
        found = Subject(given)
    else:
        raise CheckError(f"scene must be a scene, its file or a view, not {type(scene).__name__}")
    if (found.view.width, found.view.height) != (shown.width, shown.height):
        raise CheckError(
            f"the map of {shown.method} has {shown.width}x{shown.height} samples and the view "
            f"{found.view.width}x{found.view.height}; render it at that size"
        )
    if shown.manifest and shown.manifest != found.view.manifest:
        raise CheckError(f"the map of {shown.method} has other faces than the scene; leave 'scene' out")
    return found
