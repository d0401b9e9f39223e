"""The long run: every sample of every method against the truth, and why each wrong one is wrong.

    python -m tests.proof [--meshes DIR] [-o reports/proof.md]

For every built-in scene (each of its cameras) and every mesh of DIR (three cameras, three sizes), each
method is judged by exact arithmetic. Samples that several faces may own are never wrong. What must hold:

* certified methods show the true face at every sample, ties included (the z-buffer, which knows no curved
  shapes, that of the tessellated view); so they do on thousands of adversarial views;
* their answers are the same, bit for bit, for every number of threads, instruction set, and without the JIT;
* no wrong sample of a method of this package, nor of an OpenGL driver whose model is known, is left
  unexplained, and the last model of each shows the method's whole map, faces and depths, bit for bit;
* both OpenGL backends show the same.

Ends with exit code 1 if something of this does not hold.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import subprocess
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
from hsr.algorithms.registry import certified_methods, method_named
from hsr.base.errors import UnavailableError
from hsr.difference.cause import Causes, causes
from hsr.problem.view import View
from hsr.scene.model import Perspective
from tests.exact.adversarial import adversarial

SCENES = Path(__file__).parent.parent / "scenes"
MESHES = (".obj", ".ply", ".stl", ".off", ".glb")

CERTIFIED = certified_methods()
METHODS = (*CERTIFIED, "scanline", "scanline-float32", "opengl", "embree")
NOT_OURS = "embree"
"""Its model follows what is published of it; what remains unexplained is reported."""

SIZES = (512, 1024, 2048)
LARGE = 2048
"""From this size on only certified methods are looked at."""

SETTINGS = (
    {"NUMBA_NUM_THREADS": "1"},
    {"NUMBA_CPU_NAME": "x86-64-v3"},
    {"NUMBA_CPU_NAME": "x86-64-v2"},
    {"NUMBA_DISABLE_JIT": "1"},
)
"""Environments in which certified methods must give the same bits: without AVX-512, without AVX, ..."""

TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
"""A rotation with rational entries."""


@dataclass(frozen=True)
class Row:
    """One view: its ties, and the causes of every method's wrong samples.

    Attributes
    ----------
    found : dict of str to Causes
        By method; without those that this machine lacks.
    inexact : dict of str to int
        By certified method, the samples that do not show the true face.
    backends_differ : int
        Samples at which the two OpenGL backends show different faces or depths.
    """

    name: str
    view: View
    ties: int
    found: dict[str, Causes]
    inexact: dict[str, int]
    backends_differ: int

    @property
    def broken(self) -> list[str]:
        """What does not hold on this view."""
        said = []
        for method, count in self.inexact.items():
            if count:
                said.append(f"{self.name}: {method} shows another face than the true one at {count} samples")
        for method, why in self.found.items():
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
    flat = hsr.render(view.tessellated(), "exact") if view.curved else truth
    found, inexact = {}, {}
    for method in CERTIFIED if view.width >= LARGE else METHODS:
        try:
            seen = hsr.render(view, method)
        except UnavailableError:
            continue
        if method in CERTIFIED:
            exact = truth if method_named(method).curved else flat
            inexact[method] = int(np.count_nonzero(seen.face != exact.face))
        if view.width < LARGE:
            found[method] = causes(view, seen, truth)
    return Row(name, view, truth.work["ties"], found, inexact, backends_differ(view))


SOME = {"planar": {}, "with spheres and cylinders": {"curved": True}, "with cones": {"cones": True}}
"""Kinds of adversarial views."""


def adversarial_rows(seeds: range) -> Iterator[tuple[str, int, int, int]]:
    """Yield (what, views, samples, samples of certified methods that do not show the true face)."""
    for kind, what in SOME.items():
        inexact, samples = Counter[str](), 0
        for seed in seeds:
            view = adversarial(seed, **what)
            samples += view.width * view.height
            for method in CERTIFIED:
                seen = view if method_named(method).curved else view.tessellated()
                inexact[method] += int(
                    np.count_nonzero(hsr.render(seen, method).face != hsr.render(seen, "exact").face)
                )
        for method in CERTIFIED:
            yield f"{method}, {kind}", len(seeds), samples, inexact[method]


def digest() -> str:
    """Return a hash of what certified methods show of some views, faces, depths and counts."""
    told = hashlib.sha256()
    for seed in range(1, 12):
        for method in CERTIFIED:
            seen = hsr.render(adversarial(seed, method_named(method).curved), method)
            told.update(seen.face.tobytes() + seen.depth.tobytes() + repr(sorted(seen.work.items())).encode())
    return told.hexdigest()


def digest_in(setting: dict[str, str]) -> str:
    """Return the hash as a process of its own finds it in an environment."""
    code = "from tests.proof import digest; print(digest())"
    environment = {**os.environ, **setting}
    run = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    return run.stdout.strip()


def backends_differ(view: View) -> int:
    """Count the samples at which OSMesa and EGL differ; 0 where one of them is missing."""
    if view.width >= LARGE:
        return 0
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
                for side in SIZES:
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


def report(rows: Sequence[Row], hard: Sequence[tuple[str, int, int, int]], bits: dict[str, bool]) -> str:
    """Return the result as Markdown."""
    broken = [line for row in rows for line in row.broken]
    broken += [f"{what}: {wrong} samples do not show the true face" for what, _, _, wrong in hard if wrong]
    broken += [f"{setting}: other bits" for setting, same in bits.items() if not same]
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
            "Certified methods on adversarial views, against the true face, ties included:",
            "",
            *table(
                ["method", "views", "samples", "not the true face"],
                [[what, f"{views:,}", f"{samples:,}", f"{wrong:,}"] for what, views, samples, wrong in hard],
            ),
            "",
            "The same bits as here (faces, depths, counts):",
            "",
            *table(["environment", "same"], [[name, "yes" if same else "no"] for name, same in bits.items()]),
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
    """Return the number of wrong samples by every method; of certified ones, those without the true face."""
    counts = {method: why.wrong for method, why in row.found.items()} | row.inexact
    return [f"{counts[method]:,}" if method in counts else "-" for method in METHODS]


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
    parser.add_argument("--views", type=int, default=2000, help="adversarial views of each kind")
    arguments = parser.parse_args()
    todo = list(views(arguments.meshes))
    rows = []
    with Progress(console=Console(stderr=True)) as bar:
        task = bar.add_task("", total=len(todo))
        for name, make in todo:
            bar.update(task, description=name)
            rows.append(judge(name, make()))
            bar.advance(task)
        bar.update(task, description="adversarial views")
        hard = list(adversarial_rows(range(arguments.views)))
    here = digest()
    bits = {
        " ".join(f"{k}={v}" for k, v in setting.items()): digest_in(setting) == here for setting in SETTINGS
    }
    text = report(rows, hard, bits)
    arguments.output.write_text(text, encoding="utf-8")
    print(text, f"\nwrote {arguments.output}", sep="")
    return int("All that must hold holds." not in text)


if __name__ == "__main__":
    sys.exit(main())
