"""The long run: every sample of every method against the truth, and why each wrong one is wrong.

    python -m tests.proof [--meshes DIR] [-o reports/proof.md]

For every built-in scene (each of its cameras) and every mesh of DIR (three cameras, two sizes), each
method is judged by exact arithmetic. Samples that several faces may own are never wrong. What must hold:

* z-buffer and ray caster, two unlike algorithms in float64, are right at every sample; the z-buffer, which
  knows no curved shapes, but for its tessellation;
* no wrong sample of a method of this package, nor of an OpenGL driver whose model is known, is left
  unexplained, and the last model of each shows the method's whole map, faces and depths, bit for bit;
* both OpenGL backends show the same.

Ends with exit code 1 if something of this does not hold.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import Progress

import hsr
from hsr.difference.cause import Causes, causes
from hsr.errors import UnavailableError
from hsr.scene.model import Perspective
from hsr.viewing import View

SCENES = Path(__file__).parent.parent / "scenes"
MESHES = (".obj", ".ply", ".stl", ".off", ".glb")

EXACT_BUT_FOR_TESSELLATION = ("scanline", "zbuffer", "raycast")
METHODS = (*EXACT_BUT_FOR_TESSELLATION, "scanline-float32", "opengl", "embree")
NOT_OURS = "embree"
"""Its model follows what is published of it; what remains unexplained is reported."""

TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
"""A rotation with rational entries."""


@dataclass(frozen=True)
class Row:
    """One view: its ties, and the causes of every method's wrong samples.

    Attributes
    ----------
    found : dict of str to Causes
        By method; without those that this machine lacks.
    backends_differ : int
        Samples at which the two OpenGL backends show different faces or depths.
    """

    name: str
    view: View
    ties: int
    found: dict[str, Causes]
    backends_differ: int

    @property
    def broken(self) -> list[str]:
        """What does not hold on this view."""
        said = []
        for method, why in self.found.items():
            others = {cause: count for cause, count in why.counts.items() if cause != "tessellation"}
            if method in EXACT_BUT_FOR_TESSELLATION and others:
                said.append(f"{self.name}: {method} is wrong: {dict(others)}")
            if method != NOT_OURS and why.unexplained:
                said.append(f"{self.name}: {why.unexplained} samples of {method} are unexplained")
            if why.reproduced is False:
                said.append(f"{self.name}: the last model of {method} shows another map than the method")
        if self.backends_differ:
            said.append(f"{self.name}: OSMesa and EGL differ at {self.backends_differ} samples")
        return said


def judge(name: str, view: View) -> Row:
    """Render a view by every method and account for every wrong sample."""
    truth = hsr.render(view, "exact")
    found = {}
    for method in METHODS:
        try:
            found[method] = causes(view, hsr.render(view, method), truth)
        except UnavailableError:
            continue
    return Row(name, view, truth.work["ties"], found, backends_differ(view))


def backends_differ(view: View) -> int:
    """Count the samples at which OSMesa and EGL differ; 0 where one of them is missing."""
    try:
        a, b = (hsr.render(view, "opengl", backend=backend) for backend in ("osmesa", "egl"))
    except UnavailableError:
        return 0
    return int(np.count_nonzero((a.face != b.face) | (a.depth != b.depth)))


# ---------------------------------------------------------------- what is looked at


def views(meshes: Path | None) -> Iterator[tuple[str, Any]]:
    """Yield (name, function that makes the view) for all scenes, meshes, cameras and sizes."""
    for path in sorted(SCENES.glob("*.toml")):
        scene = hsr.load(path)
        for camera in scene.camera:
            label = path.stem if len(scene.camera) == 1 else f"{path.stem}, {camera.name}"
            yield label, lambda s=scene, c=camera.name: hsr.view(s, (512, 512), c)
    for path in sorted(meshes.iterdir()) if meshes else []:
        if path.suffix in MESHES:
            for name, scene in with_cameras(path):
                for side in (512, 1024):
                    yield name, lambda s=scene, n=side: hsr.view(s, (n, n))


def with_cameras(path: Path) -> Iterator[tuple[str, hsr.Scene]]:
    """Yield a mesh seen by its fitted camera, from close by, and in parallel projection."""
    scene = hsr.load(path)
    fitted = scene.camera[0]
    assert isinstance(fitted, Perspective)
    eye, target = np.array(fitted.eye), np.array(fitted.target)
    distance = float(np.linalg.norm(eye - target))
    pose = {"target": fitted.target, "up": fitted.up}
    close = {"type": "perspective", "eye": tuple(target + 0.35 * (eye - target)), "near": 1e-3 * distance}
    parallel = {"type": "orthographic", "eye": tuple(target + (eye - target) @ TURN.T), "near": 0.0}
    size = {"height": 0.8 * distance, "far": 2.0 * distance}
    for name, camera in (("fitted", None), ("close", close | pose), ("parallel", parallel | pose | size)):
        cameras = scene.camera if camera is None else (camera,)
        other = hsr.Scene.model_validate({**dict(scene), "camera": cameras})
        yield f"{path.stem}, {name}", other.located(path.parent)


# ---------------------------------------------------------------- what is said of it


def report(rows: Sequence[Row]) -> str:
    """Return the result as Markdown."""
    broken = [line for row in rows for line in row.broken]
    return "\n".join(
        [
            "# Proof",
            "",
            "Written by `make proof`: the samples at which each method shows a face that may not own them,",
            "judged by exact arithmetic. Tied samples may have several owners, and none of those is wrong.",
            f"OpenGL: {driver()}.",
            "",
            *table(
                ["view", "faces", "size", "tied", *METHODS],
                [
                    [row.name, f"{row.view.faces:,}", size(row.view), f"{row.ties:,}", *wrong(row)]
                    for row in rows
                ],
            ),
            "",
            "Why they are wrong, over all views:",
            "",
            *table(["method", "wrong", "causes"], [cause_row(rows, method) for method in METHODS]),
            "",
            f"{len(rows)} views. " + ("All that must hold holds." if not broken else "What does not hold:"),
            *(f"- {line}" for line in broken),
            "",
        ]
    )


def table(head: Sequence[str], lines: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield the lines of a Markdown table; all columns but the first are numbers."""
    yield f"| {' | '.join(head)} |"
    yield f"|---|{'---:|' * (len(head) - 1)}"
    for line in lines:
        yield f"| {' | '.join(line)} |"


def wrong(row: Row) -> list[str]:
    """Return the number of wrong samples by every method."""
    return [f"{row.found[method].wrong:,}" if method in row.found else "-" for method in METHODS]


def cause_row(rows: Sequence[Row], method: str) -> list[str]:
    """Return a method, its wrong samples and their causes, the commonest first."""
    total: Counter[str] = Counter()
    for row in rows:
        total.update(row.found[method].counts if method in row.found else {})
    named = ", ".join(f"{cause} {count:,}" for cause, count in total.most_common())
    return [method, f"{total.total():,}", named]


def size(view: View) -> str:
    """Return the size of a view as people write it."""
    return f"{view.width}x{view.height}"


def driver() -> str:
    """Return the name of the driver that stands for OpenGL here."""
    try:
        scene = hsr.load(SCENES / "cube.toml")
        return str(hsr.render(scene, "opengl", size=(8, 8)).notes["driver"])
    except UnavailableError as error:
        return f"not available ({error})"


def main() -> int:
    """Run the proof; return the exit code."""
    parser = argparse.ArgumentParser(description="Account for every wrong sample of every method.")
    parser.add_argument("--meshes", type=Path, help="folder of mesh files to include")
    parser.add_argument("-o", "--output", type=Path, default=Path("reports/proof.md"))
    arguments = parser.parse_args()
    todo = list(views(arguments.meshes))
    rows = []
    with Progress(console=Console(stderr=True)) as bar:
        task = bar.add_task("", total=len(todo))
        for name, make in todo:
            bar.update(task, description=name)
            rows.append(judge(name, make()))
            bar.advance(task)
    text = report(rows)
    arguments.output.write_text(text, encoding="utf-8")
    print(text, f"\nwrote {arguments.output}", sep="")
    return int(any(row.broken for row in rows))


if __name__ == "__main__":
    sys.exit(main())
