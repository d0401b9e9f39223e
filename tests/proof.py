"""The long run: do the methods agree, and is every difference to OpenGL where it may be?

    python -m tests.proof [--meshes DIR] [-o reports/proof.md]

For every built-in scene (curved shapes tessellated) and every mesh of DIR, from several cameras:

* z-buffer against ray caster: two unlike algorithms in float64 must own every sample alike but for
  exact ties. A difference is a tie if, in rational arithmetic on the view's numbers, the sample lies
  exactly on an edge of one of the two faces, or both are equally deep there.
* OpenGL against z-buffer: the share of differing samples, and whether each lies within a pixel of
  a projected edge of the faces involved, or where moving by one step of the 1/256 pixel grid, or of
  the depth buffer, changes which face is nearer.

Ends with exit code 1 if anything is left unexplained.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import Progress

import hsr
from hsr.arrays import Floats, Ints
from hsr.errors import UnavailableError
from hsr.scene.model import Perspective
from hsr.viewing import View
from hsr.visibility import BACKGROUND, VisibilityMap

SCENES = Path(__file__).parent.parent / "scenes"
SUBPIXEL = 1.0 / 256.0
"""Grid to which OpenGL drivers of today snap vertices, in pixels."""


@dataclass(frozen=True)
class Row:
    """One view and what was counted on it; None where OpenGL is missing."""

    name: str
    faces: int
    size: str
    differ: int
    ties: int
    opengl: int | None
    near_edge: int
    near_tie: int

    @property
    def unexplained(self) -> int:
        """Differences that are neither ties nor where OpenGL's grid and depth format explain them."""
        beyond = 0 if self.opengl is None else self.opengl - self.near_edge - self.near_tie
        return self.differ - self.ties + beyond


# ---------------------------------------------------------------- exact ties


def is_tie(view: View, row: int, column: int, faces: Sequence[int]) -> bool:
    """Whether the sample lies exactly on an edge of one of the faces, or they are equally deep."""
    x = Fraction(2 * column + 1, view.width) - 1
    y = 1 - Fraction(2 * row + 1, view.height)
    depths = []
    for face in faces:
        for corners in exact_triangles(view, face):
            edges = [a[0] * x + a[1] * y + a[2] for a in edge_functions(corners)]
            if min(edges) < 0 < max(edges):
                continue
            if 0 in edges:
                return True
            weights = [edge / sum(edges) for edge in edges]
            depths.append(sum(w * corner[3] for w, corner in zip(weights, corners, strict=True)))
    return len(depths) > 1 and len(set(depths)) < len(depths)


def exact_triangles(view: View, face: int) -> Iterator[list[tuple[Fraction, ...]]]:
    """Yield the fan triangles of a face as exact corners (x_c, y_c, w_c, depth)."""
    placement = view.placements[int(view.object_of(np.array([face]))[0])]
    polygons = placement.shape.polygons
    assert polygons is not None
    matrix = exact(placement.world_from_object)
    rows = [exact(view.clip_from_world)[k] for k in (0, 1, 3)] + [exact(view.depth_row[None])[0]]
    for triangle in polygons.triangle_vertex[polygons.triangle_face == face - placement.first]:
        corners = []
        for vertex in polygons.vertices[triangle]:
            world = [dot(line, [*map(Fraction, vertex), Fraction(1)]) for line in matrix]
            corners.append(tuple(dot(line, world) for line in rows))
        yield corners


def edge_functions(corners: Sequence[tuple[Fraction, ...]]) -> list[tuple[Fraction, ...]]:
    """Return the three homogeneous edge functions, each a cross product of two corners (x, y, w)."""
    pairs = [(corners[1], corners[2]), (corners[2], corners[0]), (corners[0], corners[1])]
    return [
        (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]) for a, b in pairs
    ]


def exact(matrix: Floats) -> list[list[Fraction]]:
    return [[Fraction(float(value)) for value in line] for line in matrix]


def dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


# ---------------------------------------------------------------- where OpenGL may differ


class Screen:
    """The projected triangles of a view, to ask how near a sample is to their edges."""

    def __init__(self, view: View) -> None:
        self.view = view
        world = view.triangles
        clip = world @ view.clip_from_world[:, :3].T + view.clip_from_world[:, 3]
        self.depth = world @ view.depth_row[:3] + view.depth_row[3]
        self.x = (clip[..., 0] / clip[..., 3] + 1.0) * view.width / 2.0 - 0.5
        self.y = (1.0 - clip[..., 1] / clip[..., 3]) * view.height / 2.0 - 0.5
        order = np.argsort(view.triangle_face, kind="stable")
        self.order, self.sorted_faces = order, view.triangle_face[order]

    def triangles_of(self, face: int) -> Ints:
        """Return the indices of the triangles of one face."""
        low, high = np.searchsorted(self.sorted_faces, [face, face + 1])
        return self.order[low:high].astype(np.int32)

    def near_edge(self, row: int, column: int, faces: Sequence[int]) -> bool:
        """Whether the sample is within a pixel of an edge of one of the faces.

        A triangle that reaches behind the near plane has an edge where that plane cuts it; such a
        triangle counts as near, for OpenGL clips it before it snaps.
        """
        for face in faces:
            for t in self.triangles_of(face):
                if self.depth[t].min() < self.view.near:
                    return True
                if any(self._distance(t, k, row, column) <= 1.0 for k in range(3)):
                    return True
        return False

    def _distance(self, t: int, k: int, row: int, column: int) -> float:
        a = np.array([self.x[t, k], self.y[t, k]])
        b = np.array([self.x[t, (k + 1) % 3], self.y[t, (k + 1) % 3]])
        p, along = np.array([column, row]), b - a
        length = along @ along
        s = 0.0 if length == 0.0 else min(max((p - a) @ along / length, 0.0), 1.0)
        return float(np.linalg.norm(p - a - s * along))

    def near_tie(self, row: int, column: int, faces: Sequence[int], step: float) -> bool:
        """Whether a snap step, or two steps of the depth buffer, change which face is nearer."""
        offsets = [(0.0, 0.0), *((dx, dy) for dx in (-SUBPIXEL, SUBPIXEL) for dy in (-SUBPIXEL, SUBPIXEL))]
        gaps = []
        for dx, dy in offsets:
            a, b = (self._window_depth(face, row + dy, column + dx) for face in faces)
            gaps.append(a - b)
        return min(gaps) - 2.0 * step <= 0.0 <= max(gaps) + 2.0 * step

    def _window_depth(self, face: int, row: float, column: float) -> float:
        """Window depth, 0 at near and 1 at far, of the plane of a face at a point of the screen."""
        t = self.triangles_of(face)[0]
        z = self._to_window(self.depth[t])
        plane = np.stack([self.x[t], self.y[t], np.ones(3)], axis=1)
        return float(np.linalg.lstsq(plane, z, rcond=None)[0] @ [column, row, 1.0])

    def _to_window(self, depth: Floats) -> Floats:
        near, far = self.view.near, self.view.far
        if not self.view.perspective:
            return (depth - near) / (far - near)
        return (1.0 - near / depth) / (1.0 - near / far)


# ---------------------------------------------------------------- the run


def judge(name: str, view: View) -> Row:
    """Render one planar view by three methods and account for every difference."""
    zbuffer, raycast = hsr.render(view, "zbuffer"), hsr.render(view, "raycast")
    differ = np.argwhere(zbuffer.face != raycast.face).tolist()
    ties = sum(is_tie(view, r, c, shown(zbuffer, raycast, r, c)) for r, c in differ)
    opengl, near_edge, near_tie = against_opengl(view, zbuffer)
    size = f"{view.width}x{view.height}"
    return Row(name, view.faces, size, len(differ), ties, opengl, near_edge, near_tie)


def shown(a: VisibilityMap, b: VisibilityMap, row: int, column: int) -> list[int]:
    """Return the faces that the two maps show at a sample, the background left out."""
    return [int(m.face[row, column]) for m in (a, b) if m.face[row, column] != BACKGROUND]


def against_opengl(view: View, zbuffer: VisibilityMap) -> tuple[int | None, int, int]:
    """Count the samples that OpenGL shows otherwise, and which edges or near ties explain."""
    try:
        opengl = hsr.render(view, "opengl")
    except UnavailableError:
        return None, 0, 0
    screen, step = Screen(view), float(opengl.notes["depth_format"]["step"])
    differ = np.argwhere(opengl.face != zbuffer.face).tolist()
    near_edge = near_tie = 0
    for row, column in differ:
        faces = shown(zbuffer, opengl, row, column)
        if screen.near_edge(row, column, faces):
            near_edge += 1
        elif len(faces) == 2 and screen.near_tie(row, column, faces, step):
            near_tie += 1
    return len(differ), near_edge, near_tie


def views(meshes: Path | None) -> Iterator[tuple[str, Any]]:
    """Yield (name, function that makes the view) for all scenes, meshes, cameras and sizes."""
    for path in sorted(SCENES.glob("*.toml")):
        scene = hsr.load(path)
        for camera in scene.camera:
            label = path.stem if len(scene.camera) == 1 else f"{path.stem}, {camera.name}"
            yield label, lambda s=scene, c=camera.name: hsr.view(s, (512, 512), c).tessellated()
    for path in sorted(meshes.iterdir()) if meshes else []:
        if path.suffix in (".obj", ".ply", ".stl", ".off", ".glb"):
            for name, scene in with_cameras(path):
                yield name, lambda s=scene: hsr.view(s, (1024, 1024))


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


TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
"""A rotation with rational entries."""


def report(rows: Sequence[Row], driver: str) -> str:
    """Return the result as Markdown."""
    lines = [
        "# Proof",
        "",
        "Written by `make proof`. Samples that the z-buffer and the ray caster (float64) own differently,",
        "how many of these are exact ties (rational arithmetic); samples that OpenGL shows otherwise than",
        "the z-buffer, how many lie within a pixel of a projected edge, how many are depth near-ties.",
        f"OpenGL: {driver}.",
        "",
        "| view | faces | size | z-buffer / ray caster | exact ties | OpenGL | share | near an edge "
        "| near tie | unexplained |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in rows:
        width, height = map(int, row.size.split("x"))
        opengl = "-" if row.opengl is None else f"{row.opengl:,}"
        share = "-" if row.opengl is None else f"{row.opengl / (width * height):.4%}"
        lines.append(
            f"| {row.name} | {row.faces:,} | {row.size} | {row.differ:,} | {row.ties:,} | {opengl} "
            f"| {share} | {row.near_edge:,} | {row.near_tie:,} | {row.unexplained:,} |"
        )
    total = sum(row.unexplained for row in rows)
    return "\n".join([*lines, "", f"{len(rows)} views, {total} samples unexplained.", ""])


def driver_name() -> str:
    """Return the renderer that stands for OpenGL here."""
    try:
        scene = hsr.load(SCENES / "cube.toml")
        return str(hsr.render(scene, "opengl", size=(8, 8)).notes["renderer"])
    except UnavailableError as error:
        return f"not available ({error})"


def main() -> int:
    """Run the proof; return the exit code."""
    parser = argparse.ArgumentParser(description="Account for every difference between the methods.")
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
    text = report(rows, driver_name())
    arguments.output.write_text(text, encoding="utf-8")
    print(text, f"\nwrote {arguments.output}", sep="")
    return int(any(row.unexplained for row in rows))


if __name__ == "__main__":
    sys.exit(main())
