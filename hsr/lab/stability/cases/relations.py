"""Changes of a scene that must not change its picture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.lab.stability.building import mesh, parallel, scene_of
from hsr.lab.stability.family import Trial, Variant, also, hard_case, variants
from hsr.scene.model import Scene

Soup = tuple[Floats, Ints]
"""Vertices (V, 3) and triangles (n, 3)."""

COUNT = 24
RIGHT, UP = 3, -2
"""By how many pixels the soup is shifted."""


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


def unreversed(face: Array) -> Array:
    """Name faces in order that were named in reverse."""
    return np.where(face < 0, face, COUNT - 1 - face)


CHANGES: tuple[tuple[Callable[[Floats, Ints], Soup], Callable[[Array], Array]], ...] = (
    (lambda v, t: (v, np.roll(t, 1, axis=1)), lambda face: face),
    (lambda v, t: (v, t[::-1]), unreversed),
    (lambda v, t: (np.add(v, [RIGHT, UP, 0.0]), t), lambda face: np.roll(face, (UP, -RIGHT), axis=(0, 1))),
    (lambda v, t: (v * [-1.0, 1.0, 1.0], t), lambda face: face[:, ::-1]),
    (lambda v, t: (v[:, [1, 0, 2]], t), lambda face: face[::-1, ::-1].T),
    (lambda v, t: (v * [1.0, 1.0, 0.5], t), lambda face: face),
    (halves, lambda face: face // 2),
)
"""What is done to the soup (vertices, triangles), in the order of the story below, and how its picture goes
back to that of the first."""


def changed(trial: Trial) -> Bools:
    """Count the samples that change, away from the border that a shift brings in."""
    unchanged = trial.family.view(0.0, trial.view.width).placements
    first = trial.variant.render(replace(trial.view, placements=unchanged))
    back = CHANGES[int(trial.value) - 1][1](trial.answer.face)
    differs = np.asarray(back != first.face)
    differs[:4] = differs[-4:] = differs[:, :4] = differs[:, -4:] = False
    return differs


NUMBERS = tuple(map(float, range(1, len(CHANGES) + 1)))


@hard_case("relations", "number of the change", NUMBERS, continuous=False)
@also(wrong=changed, figure_name="samples that change")
@variants(
    Variant("backface", 2.0, "2: what is painted last stays", 1.0),
    Variant("painter", 7.0, "7: halves have farthest corners of their own", 1.0),
    Variant("scanline-snap-4", 7.0, "7: the new corner is snapped by itself", 1.0),
    Variant("scanline-direct", None, "its rounding is far from deciding here"),
)
def relations(number: float, side: int) -> Scene:
    """Change the soup; 0 leaves it as it is.

    Triangles go through each other, and the scene is changed in ways that leave its picture as it is: (1)
    corners of each triangle named in turn; (2) triangles in reverse order; (3) moved by whole pixels; (4)
    mirrored left and right; (5) x and y exchanged; (6) all depths halved; (7) each triangle cut in two. No
    truth is needed to judge: a method that shows another picture contradicts itself.

    Truth: The same picture, moved or mirrored as the scene was.

    Source: T. Chen, S. Cheung, S. Yiu, Metamorphic Testing (1998); The OpenGL Graphics System, appendix on
    invariance
    """
    change = CHANGES[int(number) - 1][0] if number else lambda v, t: (v, t)
    return scene_of(parallel(side), mesh(*change(*soup(side))))
