"""The depth buffer against OpenGL on one mesh: interleaved medians, no culling on either side.

    python benchmarks/zbuffer_speed.py FILE [--size N] [--rounds N]

Both see the same mesh from the same eye. Compared are the times from arrays in place to finished buffers
of ids and depths: the ``render`` stage here, draw and finish there. The two take turns, so that whatever
else the machine does meets both alike. Nothing is timed before the two agree on what is seen.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

import hsr
from hsr.algorithms.registry import method_named
from hsr.errors import HsrError
from hsr.opengl.contexts import shared_context
from hsr.opengl.drawing import Drawing
from hsr.scene.model import Scene
from hsr.viewing import View

VARIANTS = ("zbuffer", "zbuffer-direct", "zbuffer-float32", "zbuffer-float32-direct")
AGREE = 0.01
"""Greatest part of the samples in which they may differ: along edges, and between near ties."""


def view_of_mesh(path: str, size: int) -> View:
    """See a mesh from the front, the side and above, filling the image."""
    mesh = {"name": "mesh", "shape": "mesh", "file": path}

    def seen(**keys: Any) -> View:
        scene = {"hsr": 1, "camera": [{"type": "perspective", **keys}], "object": [mesh]}
        return hsr.view(Scene.model_validate(scene), (size, size))

    corners = seen(eye=[0.0, 0.0, 1.0]).polygons.vertices
    low, high = corners.min(axis=0), corners.max(axis=0)
    centre, diagonal = (low + high) / 2, float(np.linalg.norm(high - low))
    eye = centre + 0.85 * diagonal * np.array([0.3, 0.4, 0.87])
    return seen(eye=eye.tolist(), target=centre.tolist(), near=diagonal / 20)


def rendering(name: str, view: View) -> Callable[[], float]:
    """Return a function that renders once and returns the seconds of the ``render`` stage."""
    method = method_named(name)
    return lambda: method.render(view).seconds["render"]


def drawing(view: View) -> tuple[Drawing, Callable[[], float]]:
    """Upload a view, and return a function that draws once and returns the seconds."""
    uploaded = Drawing(shared_context("auto"), view)

    def draw() -> float:
        start = perf_counter()
        uploaded.draw()
        return perf_counter() - start

    return uploaded, draw


def check_agreement(view: View, uploaded: Drawing) -> None:
    """Refuse to time two pictures that are not of the same thing."""
    uploaded.draw()
    theirs, _ = uploaded.read()
    for name in VARIANTS:
        differ = float((method_named(name).render(view).face != theirs).mean())
        if differ > AGREE:
            raise SystemExit(f"{name} and OpenGL differ in {differ:.1%} of the samples; nothing timed")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("file", help="a mesh: OBJ, PLY, STL, OFF or GLB")
    parser.add_argument("--size", type=int, default=1024, help="width and height in pixels")
    parser.add_argument("--rounds", type=int, default=30)
    arguments = parser.parse_args()
    try:
        view = view_of_mesh(arguments.file, arguments.size)
        uploaded, draw = drawing(view)
    except HsrError as error:
        sys.exit(str(error))
    check_agreement(view, uploaded)
    runs = {"opengl": draw} | {name: rendering(name, view) for name in VARIANTS}
    rounds = [{name: run() for name, run in runs.items()} for _ in range(arguments.rounds)]
    print(f"{view.faces:,} triangles, {arguments.size} x {arguments.size}, medians of {len(rounds)} rounds")
    for name in runs:
        milliseconds = 1e3 * median(times[name] for times in rounds)
        ratio = median(times["opengl"] / times[name] for times in rounds)
        print(f"{name:24} {milliseconds:8.2f} ms   {ratio:5.2f} x opengl")


if __name__ == "__main__":
    main()
