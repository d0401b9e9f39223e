"""Paint the picture of the README: python benchmarks/picture.py reports/overview.png

Four scenes from left to right. From top to bottom: the shaded picture, the faces, the depths, and
where painting what back-face culling leaves would show the wrong face.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

import hsr
from hsr.arrays import Pixels
from hsr.difference.classes import OTHER_OWNER, compare
from hsr.shading import depth_picture, face_picture, save_picture, shade

SCENES = ("solids", "cyclic", "engineering", "teapot")
SIDE, GAP = 224, 6
WRONG = (204, 32, 38)


def column(name: str) -> list[Pixels]:
    """Return the four pictures of one scene, from top to bottom."""
    view = hsr.view(hsr.load(Path(__file__).parent.parent / "scenes" / f"{name}.toml"), (SIDE, SIDE))
    answer, culled = hsr.render(view, "raycast"), hsr.render(view, "backface")
    shaded = shade(answer, view)
    wrong = 255 - (255 - shaded) // 4
    seen = hsr.render(view, "zbuffer")
    wrong[np.isin(compare(culled, seen).classes, OTHER_OWNER)] = WRONG
    return [shaded, face_picture(answer), depth_picture(answer), wrong]


def padded(picture: Pixels) -> Pixels:
    """Put a white margin around a picture; a grey one becomes RGB."""
    colour = picture if picture.ndim == 3 else np.repeat(picture[..., None], 3, axis=2)
    return np.pad(colour[..., :3], ((GAP, GAP), (GAP, GAP), (0, 0)), constant_values=255)


def main(path: Annotated[Path, typer.Argument(help="PNG file to write.")]) -> None:
    """Write the picture."""
    columns = [np.vstack([padded(picture) for picture in column(name)]) for name in SCENES]
    save_picture(np.hstack(columns), path)


if __name__ == "__main__":
    typer.run(main)
