"""The command ``hsr demo``: the shortest way to a picture."""

from __future__ import annotations

import math
import os
import sys
import time
import webbrowser
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Option

import hsr
from hsr.cli import common as cli
from hsr.cli.cameras import Cameras, with_cameras

if TYPE_CHECKING:
    from hsr.difference.cause import Causes
    from hsr.difference.study import Study

FIRST = ("exact", "opengl", "embree-packets", "embree")
"""What draws soonest after installation, when nothing is compiled."""

EVERY = 2.0
"""Seconds between two versions of the page: writing one takes some of them from the methods."""


@with_cameras
def demo(
    scene: cli.SceneFile = Path("solids"),
    output: Annotated[Path, cli.output("Page to write.", ".html")] = Path("hsr-demo.html"),
    size: cli.Size = "384x384",
    browse: Annotated[bool, Option(help="Open the page in a browser, where there is a desktop.")] = True,
    quiet: cli.Quiet = False,
    *,
    cameras: Cameras,
) -> None:
    """Show one scene by every method, on a page that opens at once and fills as methods are compiled.

    What starts fast comes first. While a method is still to come, the page loads itself again.

    For example:

        hsr demo
        hsr demo bunny.obj --eye 2,2,4
    """
    from hsr.algorithms.ahead import Ahead
    from hsr.difference.study import explained, study
    from hsr.pages.report import write_report

    loaded, names = cameras.one(hsr.load(scene)), cli.names(None)
    names.sort(key=lambda name: FIRST.index(name) if name in FIRST else len(FIRST))
    write_report([], output, pending=names)
    if not quiet:
        cli.say(f"{output.resolve().as_uri()} fills as methods answer")
    if browse and _has_desktop():
        webbrowser.open(output.resolve().as_uri())

    written = -math.inf
    causes: dict[str, Causes] = {}

    def show(found: Study) -> None:
        nonlocal written, causes
        pending = [name for name in names if name not in found.maps and name not in found.skipped]
        if not pending or time.monotonic() - written > EVERY:
            found = explained(replace(found, causes=causes))
            write_report([found], output, pending=pending)
            written, causes = time.monotonic(), found.causes

    with cli.progress(quiet, len(names)) as step, Ahead(scene, names) as ahead:
        how = partial(study, name=scene.stem, progress=step, ahead=ahead, each=show)
        how(loaded, names, "exact", cli.parse_size(size))


def _has_desktop() -> bool:
    """Tell whether a browser would have a screen to show itself on."""
    screen = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    return sys.stdout.isatty() and bool(screen or sys.platform in ("win32", "darwin"))
