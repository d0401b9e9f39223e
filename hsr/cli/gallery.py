"""The command ``hsr gallery``: scenes as a page of pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Option

import hsr
from hsr.base.errors import HsrError
from hsr.base.files import make_folder
from hsr.cli import common as cli
from hsr.cli.cameras import Cameras, with_cameras


@with_cameras
def gallery(
    scenes: cli.SceneFiles,
    output: Annotated[Path, cli.output("Folder to write.")],
    size: cli.Size = "256x256",
    turn: Annotated[cli.Texts, Option(help="Scene, by its name, to show turning; repeatable.")] = None,
    quiet: cli.Quiet = False,
    *,
    cameras: Cameras,
) -> None:
    """Write a page of scenes: what each looks like, what it shows, which methods are right on it.

    For example:

        hsr gallery solids cyclic teapot --turn solids -o gallery
    """
    from hsr.pages.gallery import write_gallery

    loaded = dict(pair for path in scenes for pair in cameras.scenes(path.stem, hsr.load(path)))
    for name in turn or ():
        if name not in loaded:
            raise HsrError(f"--turn {name}: no such scene is given; there are {', '.join(loaded)}")
    with cli.progress(quiet, len(loaded) * len(hsr.methods())) as step:
        write_gallery(loaded, make_folder(output), cli.parse_size(size), turn or (), step)
    cli.say(f"wrote {output}")
