"""The gallery: scenes as pictures, what they show, and which methods are right on them, as measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from hsr.algorithms.registry import methods, render
from hsr.base.arrays import Pixels
from hsr.base.errors import HsrError
from hsr.base.files import write_whole
from hsr.difference.classes import OTHER_OWNER, compare
from hsr.difference.study import Progress, Study, explained, study
from hsr.models.stages import Cause
from hsr.pages.frame import page, style
from hsr.pages.shading import shade
from hsr.pictures.maps import depth_picture, face_picture
from hsr.pictures.palette import CLASS_COLOURS
from hsr.pictures.png import save_picture
from hsr.problem.view import view
from hsr.scene.fitting import turned
from hsr.scene.model import Scene

TURN = 36
"""Pictures of a full turn."""

PAUSE = 80
"""Milliseconds from one to the next."""

SIDE, GAP = 224, 6
"""Of the pictures of the overview, in pixels."""


def write_gallery(
    scenes: Mapping[str, Scene],
    folder: Path,
    size: tuple[int, int],
    turning: Sequence[str],
    progress: Progress,
) -> None:
    """Write ``index.html``, a picture of every scene, those that turn, and ``overview.png`` of all.

    Parameters
    ----------
    folder : Path
        There already; files in it are replaced.
    size : (width, height)
        At which methods are compared, in pixels.
    turning : sequence of str
        Names of the scenes to show turning too, as ``NAME.webp``.
    progress : callable
        Called before each method answers for a scene, with what is done.

    Raises
    ------
    HsrError
        If a file cannot be written, the truth about a scene cannot be had, or one that is to turn has no
        camera with a place.
    """
    shown = []
    for name, scene in scenes.items():
        if name in turning:
            write_whole(folder / f"{name}.webp", turntable(scene), "the turning picture")
        found = explained(study(scene, list(methods()), "exact", size, name=name, progress=progress))
        if found.reference is None:
            raise HsrError(f"{name}: {found.skipped['exact']}")
        save_picture(shade(found.maps["exact"], found.view), folder / f"{name}.png")
        shown.append((found, _wrong(found)))
    save_picture(overview(list(scenes.values())), folder / "overview.png")
    sheet, own = style("gallery.css"), "'self' file:"
    told: dict[str, Any] = {"shown": shown, "size": size, "turning": turning}
    path = folder / "index.html"
    write_whole(path, page("gallery", path, "The scenes", sheet, images=own, **told), "the gallery")


def _wrong(found: Study) -> dict[str, int]:
    """Count the samples at which each method shows a face that is not admissible, the least first.

    What comes of flat faces in place of curved ones is not counted: it was asked for.
    """
    flat = Cause.TESSELLATION.label
    rightly = {name: why.counts.get(flat, 0) for name, why in found.causes.items()}
    counts = {name: shown.different - rightly[name] for name, shown in found.differences.items()}
    return dict(sorted(counts.items(), key=lambda item: item[1]))


# ---------------------------------------------------------------- turning


def turntable(scene: Scene) -> bytes:
    """Return a scene that turns once about the vertical through what its camera looks at, as animated WebP.

    Raises
    ------
    HsrError
        If its first camera is given by a matrix.
    """
    cameras = (turned(scene.camera[0], 2.0 * np.pi * k / TURN) for k in range(TURN))
    views = (view(scene, (SIDE, SIDE), camera) for camera in cameras)
    first, *others = (Image.fromarray(shade(render(seen, "raycast"), seen)) for seen in views)
    file = BytesIO()
    first.save(file, "WEBP", save_all=True, append_images=others, duration=PAUSE, loop=0, lossless=True)
    return file.getvalue()


# ---------------------------------------------------------------- the overview


def overview(scenes: Sequence[Scene]) -> Pixels:
    """Paint scenes beside each other, each from top to bottom in four pictures.

    They are the shaded picture, the faces, the depths, and where painting what back-face culling leaves
    shows the wrong face.

    Returns
    -------
    (H, W, 3) uint8
    """
    columns = np.array([_column(scene) for scene in scenes])  # (n, 4, SIDE, SIDE, 3)
    margin = (GAP, GAP)
    padded = np.pad(columns, ((0, 0), (0, 0), margin, margin, (0, 0)), constant_values=255)
    return np.hstack([np.vstack(column) for column in padded])


def _column(scene: Scene) -> list[Pixels]:
    from skimage.color import gray2rgb

    seen = view(scene, (SIDE, SIDE))
    answer, culled = render(seen, "raycast"), render(seen, "backface")
    shaded = shade(answer, seen)
    wrong: Pixels = 255 - (255 - shaded) // 4
    differs = np.isin(compare(culled, render(seen, "zbuffer")).classes, OTHER_OWNER)
    wrong[differs] = CLASS_COLOURS["wrong face"]
    return [shaded, face_picture(answer.face), gray2rgb(depth_picture(answer.depth)), wrong]
