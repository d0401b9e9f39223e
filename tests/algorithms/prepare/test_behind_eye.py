"""Triangles set up from exact edges: their depths are within their bounds."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from hsr.algorithms.prepare.behind_eye import crossing_tables
from hsr.algorithms.zbuffer import clusters_of, eye_of
from hsr.certify import facets_at
from hsr.certify.facets import Facet
from hsr.kernels.projection import clip_rows, to_clip
from hsr.kernels.zbuffer import setup
from hsr.problem.view import View, view
from tests.conftest import JIT
from tests.exact.hard import scene

SEEDS = 60 if JIT else 20


def around(seed: int) -> View:
    """Triangles around the eye of a matrix camera far from the origin, whose rows have any length."""
    random = np.random.default_rng(seed)
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    eye = random.normal(size=3) * 10.0 ** random.integers(0, 7)
    right, up, depth = (np.append(axis, -axis @ eye) for axis in axes)
    matrix = np.stack([right, up, depth - [0.0, 0.0, 0.0, 0.2], depth]) * 10.0 ** random.uniform(-3.0, 3.0)
    vertices = eye + 3.0 * random.normal(size=(9, 3))
    thing = {"shape": "mesh", "vertices": vertices.tolist(), "faces": np.arange(9).reshape(3, 3).tolist()}
    return view(scene([thing], {"type": "matrix", "matrix": matrix.tolist()}), (5, 5))


def entries(seen: View) -> Iterator[tuple[setup.Eye, int, dict[str, float]]]:
    """Yield the eye, the number and the table entry of every triangle of certain depth."""
    clusters, every = clusters_of(seen), np.arange(3)
    rows = clip_rows(seen.clip_from_world, seen.depth_row)
    eye = eye_of(seen, clusters, rows)
    clip = to_clip(clusters.vertices.T[clusters.corner.ravel()], rows).reshape(-1, 3, 3)
    names = ("NUMBER", "LEFT", "RIGHT", "TOP", "BOTTOM", "Z", "Z_X", "Z_Y", "Z_ERROR")
    for table in crossing_tables(seen, clip, clusters.number, every, eye):
        for i in range(setup.CLUSTER):
            entry = {name: float(table[getattr(setup, name) + i]) for name in names}
            if entry["BOTTOM"] > entry["TOP"] and entry["Z_ERROR"] <= eye.tie:
                yield eye, int(clusters.number[int(entry["NUMBER"])]), entry


def test_key_depths_are_within_their_bound() -> None:
    asked = 0
    for seed in range(SEEDS):
        seen = around(seed)
        for eye, number, entry in entries(seen):
            _, (facet,) = facets_at(seen, np.array([number], np.int32))
            asked += sum(is_within(seen, eye, facet, entry, *place) for place in np.ndindex(5, 5))
    assert asked > 3 * SEEDS


def is_within(
    seen: View, eye: setup.Eye, facet: Facet, entry: dict[str, float], row: int, column: int
) -> bool:
    """Check a sample of a triangle, if it covers it."""
    p = [2 * column + 1 - seen.width, seen.height - 1 - 2 * row, 1]
    if min(np.array(facet.inside, object) @ p) < 0:
        return False
    above, below = np.array(facet.depth, object) @ p
    exact = setup.CLOSEST + (Fraction(float(eye.closest)) - Fraction(int(below), int(above))) * Fraction(
        float(eye.scale)
    )
    right, down = column - entry["LEFT"], row - entry["TOP"]
    value = entry["Z"] + down * entry["Z_Y"] + right * entry["Z_X"]
    assert abs(exact - Fraction(value)) <= entry["Z_ERROR"]
    return True
