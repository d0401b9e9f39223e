"""Changes of a scene that must not change its picture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.lab.stability.building import mesh, parallel, scene_of
from hsr.lab.stability.family import Case, Family, Variant
from hsr.scene.model import Scene

Soup = tuple[Floats, Ints]
"""Vertices (V, 3) and triangles (n, 3)."""

COUNT = 24
SHIFT = (3, -2)
"""Pixels to the right, and up."""


def soup(side: int) -> Soup:
    """Return triangles anywhere in the picture, through each other; no corner lies on a line of samples."""
    random = np.random.default_rng(7)
    across = random.integers(-1800, 1800, (3 * COUNT, 2)) * (side / 4096.0) + 0.01
    depth = 0.25 + random.permutation(3 * COUNT) / 64.0
    return np.column_stack([across, -depth]), np.arange(3 * COUNT, dtype=np.int32).reshape(COUNT, 3)


def halves(vertices: Floats, triangles: Ints) -> Soup:
    """Cut every triangle in two by the middle of its first side; both halves follow each other."""
    a, b, c = triangles.T
    middle = 0.5 * (vertices[a] + vertices[b])
    m = np.arange(len(a), dtype=np.int32) + len(vertices)
    return np.concatenate([vertices, middle]), np.stack([a, m, c, m, b, c], axis=1).reshape(-1, 3)


CHANGES: tuple[tuple[str, Callable[[Floats, Ints], Soup], Callable[[Array], Array]], ...] = (
    ("corners of each triangle named in turn", lambda v, t: (v, np.roll(t, 1, axis=1)), lambda face: face),
    (
        "triangles in reverse order",
        lambda v, t: (v, t[::-1]),
        lambda face: np.where(face < 0, face, COUNT - 1 - face),
    ),
    (
        "moved by whole pixels",
        lambda v, t: (v + np.array([*SHIFT, 0.0]), t),
        lambda face: np.roll(face, (SHIFT[1], -SHIFT[0]), axis=(0, 1)),
    ),
    ("mirrored left and right", lambda v, t: (v * [-1.0, 1.0, 1.0], t), lambda face: face[:, ::-1]),
    ("x and y exchanged", lambda v, t: (v[:, [1, 0, 2]], t), lambda face: face[::-1, ::-1].T),
    ("all depths halved", lambda v, t: (v * [1.0, 1.0, 0.5], t), lambda face: face),
    ("each triangle cut in two", halves, lambda face: face // 2),
)
"""What is changed: the soup (vertices, triangles), and how its picture goes back to that of the first."""


def scene(number: float, side: int) -> Scene:
    """Change the soup; 0 leaves it as it is."""
    vertices, triangles = soup(side)
    if number:
        vertices, triangles = CHANGES[int(number) - 1][1](vertices, triangles)
    return scene_of(parallel(side), mesh(vertices, triangles))


def changed(case: Case) -> Bools:
    """Count the samples that change, away from the border that a shift brings in."""
    side = case.view.width
    first = case.variant.render(replace(case.view, placements=case.family.view(0.0, side).placements))
    back = CHANGES[int(case.value) - 1][2](case.answer.face)
    differs = np.asarray(back != first.face)
    differs[:4] = differs[-4:] = differs[:, :4] = differs[:, -4:] = False
    return differs


FAMILY = Family(
    name="relations",
    group="relations",
    story=(
        "Triangles go through each other, and the scene is changed in ways that leave its picture as it is: "
        + "; ".join(f"({k}) {what}" for k, (what, _, _) in enumerate(CHANGES, 1))
        + ". No truth is needed to judge: a method that shows another picture contradicts itself."
    ),
    expected="The same picture, moved or mirrored as the scene was.",
    source=(
        "T. Chen, S. Cheung, S. Yiu, Metamorphic Testing (1998); The OpenGL Graphics System, appendix on "
        "invariance"
    ),
    parameter="number of the change",
    sweep=tuple(float(k + 1) for k in range(len(CHANGES))),
    continuous=False,
    scene=scene,
    wrong=changed,
    figure_name="samples that change",
    variants=(
        Variant("backface", 2.0, "2: what is painted last stays", 1.0),
        Variant("painter", 7.0, "7: halves have farthest corners of their own", 1.0),
        Variant("scanline-snap-4", 7.0, "7: the new corner is snapped by itself", 1.0),
        Variant("scanline-direct", None, "its rounding is far from deciding here"),
    ),
)
