"""Projected vertices, edge functions and depths: every error is within its bound."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from hsr.algorithms.zbuffer import along_the_curve, clusters_of, eye_of
from hsr.kernels.projection import clip_rows
from hsr.kernels.zbuffer import setup
from hsr.problem.view import View
from tests.conftest import JIT
from tests.exact.adversarial import adversarial

Point = tuple[Fraction, Fraction, Fraction]

SEEDS = range(0, 120 if JIT else 24)


def exact_vertices(view: View) -> list[Point | None]:
    """Pixel x and y and nearness of the vertices of clusters in fractions; None at or behind the eye."""
    rows = [[Fraction(float(x)) for x in row] for row in [*view.clip_from_world[[0, 1, 3]], view.depth_row]]
    found: list[Point | None] = []
    for placement in view.placements:
        matrix = [[Fraction(float(x)) for x in row] for row in placement.world_from_object[:3]]
        polygons: Any = placement.shape.polygons
        for vertex in polygons.vertices:
            p = [Fraction(float(x)) for x in vertex]
            world = [sum(m * q for m, q in zip(row, [*p, 1], strict=True)) for row in matrix]
            x, y, w, d = (sum(c * q for c, q in zip(row, [*world, 1], strict=True)) for row in rows)
            column, row = (1 + x / w) * view.width / 2 if w else 0, (1 - y / w) * view.height / 2 if w else 0
            nearness = (1 / d if d else 0) if view.perspective else -d
            found.append((column, row, nearness) if w > 0 else None)
    return [found[k] for k in along_the_curve(view.polygons.vertices, view.polygons.vertices)[0]]


def projected(view: View) -> tuple[Any, setup.Eye, Any]:
    clusters = clusters_of(view)
    rows, screen = clip_rows(view.clip_from_world, view.depth_row), np.empty((clusters.vertices.shape[1], 4))
    eye = eye_of(view, clusters, rows)
    extent = np.empty((clusters.low.shape[1], 5))
    setup.lay_out(clusters.vertices, clusters.low, clusters.high, rows, eye, screen, extent)
    return clusters, eye, screen


@pytest.mark.parametrize("share", range(4))
def test_projected_vertices_are_within_their_error(share: int) -> None:
    for seed in SEEDS[share::4]:
        view = adversarial(seed)
        _, eye, screen = projected(view)
        for exact, (x, y, nearness, error) in zip(exact_vertices(view), screen.tolist(), strict=True):
            if error > setup.PRECISE:
                continue
            assert exact is not None, f"seed {seed}: behind the eye, and certain"
            assert abs(Fraction(x) - exact[0]) <= error and abs(Fraction(y) - exact[1]) <= error
            assert abs(Fraction(nearness) - exact[2]) <= setup.nearness_error(nearness, eye)


@pytest.mark.parametrize("perspective", [True, False])
@pytest.mark.parametrize("row", [0, 1, 2])
def test_what_overflows_may_be_anywhere(perspective: bool, row: int) -> None:
    rows = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0]])
    rows[row, :2] = 1e300, -1e300
    eye = setup.eye_between(perspective, (64.0, 64.0), (np.inf,) * 3, (0.5, 9.0), (0.0, 1.0))
    with np.errstate(all="ignore"):
        assert setup.projected(1e300, 1e300, 0.0, setup.entries(rows), eye)[setup.ERROR] == setup.ANYWHERE


def set_up(view: View) -> Iterator[tuple[list[Point], dict[str, float], setup.Eye]]:
    """Yield the exact corners and the table entry of every triangle that is set up."""
    clusters, eye, screen = projected(view)
    exact, table = exact_vertices(view), np.empty(setup.TABLE)
    names = [name for name in vars(setup) if name.isupper() and isinstance(getattr(setup, name), int)]
    parts = {
        name: getattr(setup, name)
        for name in names
        if getattr(setup, name) in range(0, setup.GATHERED, setup.CLUSTER)
    }
    for first in range(0, len(clusters.corner), setup.CLUSTER):
        count = setup.gather(screen, clusters.corner, clusters.cull, first, table)
        setup.set_up(table, count, eye)
        for i in range(count):
            entry = {name: float(table[part + i]) for name, part in parts.items()}
            if entry["BOTTOM"] > entry["TOP"]:
                corners = [exact[v] for v in clusters.corner[int(entry["NUMBER"])]]
                yield [corner for corner in corners if corner is not None], entry, eye


def test_edge_functions_and_depths_are_within_their_bounds() -> None:
    asked = 0
    for seed in SEEDS:
        for (a, b, c), entry, eye in set_up(adversarial(seed)):
            asked += check(seed, a, b, c, entry, eye)
    assert asked > (1000 if JIT else 100)


def check(seed: int, a: Point, b: Point, c: Point, entry: dict[str, float], eye: setup.Eye) -> int:
    """Compare at the corners of the bounding box."""
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    assert abs(abs(area) - Fraction(entry["AREA"])) <= entry["BOUND"], f"seed {seed}"
    if entry["AREA"] <= entry["BOUND"]:
        return 0
    turn, asked = (1 if area > 0 else -1), 0
    for down in {0.0, entry["BOTTOM"] - entry["TOP"] - 1}:
        for right in {
            0.0,
            entry["RIGHT"] - entry["LEFT"] - 1,
            entry["RIGHT"] - entry["LEFT"] + setup.LANES - 2,
        }:
            x, y = Fraction(entry["LEFT"] + right + 0.5), Fraction(entry["TOP"] + down + 0.5)
            inside = []
            for edge, (p, q) in enumerate(((a, b), (b, c), (c, a))):
                exact = turn * ((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]))
                value = entry[f"E{edge}"] + down * entry[f"BELOW{edge}"] + right * entry[f"ACROSS{edge}"]
                assert abs(exact - Fraction(value)) <= entry["BOUND"], f"seed {seed}"
                inside.append(exact / abs(area))
            if min(inside) >= 0:
                nearness = inside[1] * a[2] + inside[2] * b[2] + inside[0] * c[2]
                exact = setup.CLOSEST + (Fraction(float(eye.closest)) - nearness) * Fraction(float(eye.scale))
                value = entry["Z"] + down * entry["Z_Y"] + right * entry["Z_X"]
                assert abs(exact - Fraction(value)) <= entry["Z_ERROR"], f"seed {seed}"
            asked += 1
    return asked
