"""The gallery: scenes as pictures, what they show, and which methods are right on them, as measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image

from hsr.algorithms.registry import methods, render
from hsr.base.arrays import Array, Pixels
from hsr.base.errors import HsrError
from hsr.base.files import write_whole
from hsr.difference.classes import OTHER_OWNER, compare
from hsr.difference.study import Study, study
from hsr.models.stages import Cause
from hsr.pages.frame import page, style
from hsr.pages.shading import shade
from hsr.pictures.maps import depth_picture, face_picture
from hsr.pictures.png import save_picture
from hsr.problem.view import view
from hsr.scene.model import MatrixCamera, Scene

FRAMES = 36
"""Pictures of a full turn."""

FRAME_MS = 80

SIDE, GAP = 224, 6
"""Of the pictures of the overview, in pixels."""

WRONG = (204, 32, 38)
"""Colour of samples that show the wrong face."""


class Shown(NamedTuple):
    """A scene of the gallery, and what was measured on it.

    Attributes
    ----------
    name : str
    study : Study
    turns : bool
        Whether there is a file in which it turns.
    """

    name: str
    study: Study
    turns: bool

    @property
    def wrong(self) -> dict[str, int]:
        """At how many samples each method shows a face that is not admissible, the least first.

        What comes of flat faces in place of curved ones is not counted: it was asked for.
        """
        flat = Cause.TESSELLATION.label
        counts = {
            name: found.different - self.study.causes[name].counts.get(flat, 0)
            for name, found in self.study.differences.items()
        }
        return dict(sorted(counts.items(), key=lambda item: item[1]))


def write_gallery(
    scenes: Mapping[str, Scene],
    folder: Path,
    size: tuple[int, int],
    turning: Sequence[str],
    progress: Callable[[str], None],
) -> None:
    """Write ``index.html``, a picture of every scene, those that turn, and ``overview.png`` of all.

    Parameters
    ----------
    scenes : mapping of str to Scene
    folder : Path
        There already; files in it are replaced.
    size : (width, height)
        At which methods are compared, in pixels.
    turning : sequence of str
        Names of the scenes to show turning too, as ``NAME.webp``.
    progress : callable
        Called with each name before its scene is measured.

    Raises
    ------
    HsrError
        If a file cannot be written, the truth about a scene cannot be had, or one that is to turn has no
        camera with a place.
    """
    shown = []
    for name, scene in scenes.items():
        progress(name)
        if name in turning:
            write_whole(folder / f"{name}.webp", turntable(scene), "the turning picture")
        measured = study(scene, list(methods()), "exact", size, name=name)
        if measured.reference is None:
            raise HsrError(f"{name}: {measured.skipped['exact']}")
        save_picture(shade(measured.maps["exact"], measured.view), folder / f"{name}.png")
        shown.append(Shown(name, measured, name in turning))
    save_picture(overview(list(scenes.values())), folder / "overview.png")
    sheet = style("gallery.css")
    text = page("gallery", "The scenes", sheet, images="'self' file:", shown=shown, size=size)
    write_whole(folder / "index.html", text, "the gallery")


# ---------------------------------------------------------------- turning


def turntable(scene: Scene) -> bytes:
    """Return a scene that turns once about the vertical through what its camera looks at, as animated WebP.

    Raises
    ------
    HsrError
        If its first camera is given by a matrix.
    """
    frames = [
        Image.fromarray(shade(render(seen, "raycast"), seen))
        for seen in (view(turned(scene, 2.0 * np.pi * k / FRAMES), (SIDE, SIDE)) for k in range(FRAMES))
    ]
    file = BytesIO()
    frames[0].save(
        file, "WEBP", save_all=True, append_images=frames[1:], duration=FRAME_MS, loop=0, lossless=True
    )
    return file.getvalue()


def turned(scene: Scene, angle: float) -> Scene:
    """Return a scene whose first camera has walked by an angle, in radians, around its target."""
    camera = scene.camera[0]
    if isinstance(camera, MatrixCamera):
        raise HsrError(f"camera {camera.name!r} is a matrix; only one with an eye and a target can turn")
    x, y, z = np.subtract(camera.eye, camera.target)
    c, s = np.cos(angle), np.sin(angle)
    eye = tuple(map(float, np.add(camera.target, (c * x + s * z, y, c * z - s * x))))
    return scene.model_copy(update={"camera": (camera.model_copy(update={"eye": eye}),)})


# ---------------------------------------------------------------- the overview


def overview(scenes: Sequence[Scene]) -> Pixels:
    """Paint scenes beside each other, each from top to bottom in four pictures.

    They are the shaded picture, the faces, the depths, and where painting what back-face culling leaves
    shows the wrong face.

    Returns
    -------
    (H, W, 3) uint8
    """
    return np.hstack([np.vstack([_padded(picture) for picture in _column(scene)]) for scene in scenes])


def _column(scene: Scene) -> list[Pixels]:
    seen = view(scene, (SIDE, SIDE))
    answer, culled = render(seen, "raycast"), render(seen, "backface")
    shaded = shade(answer, seen)
    wrong: Pixels = 255 - (255 - shaded) // 4
    wrong[np.isin(compare(culled, render(seen, "zbuffer")).classes, OTHER_OWNER)] = WRONG
    return [shaded, face_picture(answer.face), depth_picture(answer.depth), wrong]


def _padded(picture: Array) -> Pixels:
    """Put a white margin around a picture; a grey one becomes RGB."""
    colour = picture if picture.ndim == 3 else np.repeat(picture[..., None], 3, axis=2)
    return np.pad(colour[..., :3], ((GAP, GAP), (GAP, GAP), (0, 0)), constant_values=255)
