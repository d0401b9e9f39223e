"""The renderers in the open: right without a mistake, wrong by the one that is planted."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.arrays import Ints
from hsr.lab.stability.building import central, mesh, parallel, rectangle, scene_of, wall
from hsr.lab.stability.family import Mistake, Variant
from hsr.mistakes.renderers import (
    Buffer,
    general_cylinders,
    minifloat,
    naive_boxes,
    naive_spheres,
)
from hsr.problem.view import View


def shown(mistake: Mistake, view: View) -> Ints:
    return Variant("planted", mistake=mistake).render(view).face


def soup(perspective: bool) -> View:
    random = np.random.default_rng(4)
    vertices = random.uniform([-6.0, -6.0, -6.0], [6.0, 6.0, -2.0], (30, 3))
    thing = mesh(vertices, np.arange(30).reshape(10, 3))
    return hsr.view(scene_of(central(0.5) if perspective else parallel(12, 0.0, 8.0), thing), (20, 20))


@pytest.mark.parametrize("perspective", [False, True])
def test_without_a_mistake_the_buffer_is_right(perspective: bool) -> None:
    view = soup(perspective)
    truth = hsr.render(view, "exact")
    assert truth.admits(shown(Buffer(), view)).all() and (truth.face >= 0).mean() > 0.3


def test_top_and_left_edges_own_their_samples() -> None:
    """Two triangles share the diagonal of a square whose sides lie on samples."""
    square = rectangle((-1.5, 1.5), (-1.5, 1.5), 1.0)
    view = hsr.view(scene_of(parallel(6), square), (6, 6))
    assert shown(Buffer(), view).tolist() == [
        [-1, -1, -1, -1, -1, -1],
        [-1, 1, 1, 1, -1, -1],
        [-1, 1, 1, 0, -1, -1],
        [-1, 1, 0, 0, -1, -1],
        [-1, -1, -1, -1, -1, -1],
        [-1, -1, -1, -1, -1, -1],
    ]


@pytest.mark.parametrize(
    "mistake",
    [Buffer(epsilon=0.5), Buffer(inclusive=True), Buffer(whole=np.int16)],
    ids=["epsilon", "inclusive", "int16"],
)
def test_mistakes_of_coverage_show(mistake: Buffer) -> None:
    square = rectangle((-1.5, 1.5), (-1.5, 1.5), 1.0)
    view = hsr.view(scene_of(parallel(6), square), (6, 6))
    assert not np.array_equal(shown(mistake, view), shown(Buffer(), view))


def test_long_integers_are_right_on_the_grid() -> None:
    square = rectangle((-1.5, 1.5), (-1.5, 1.5), 1.0)
    view = hsr.view(scene_of(parallel(6), square), (6, 6))
    assert np.array_equal(shown(Buffer(whole=np.int64), view), shown(Buffer(), view))


def test_what_lies_on_near_is_seen_unless_the_test_is_strict() -> None:
    view = hsr.view(scene_of(central(1.0), wall(1.0, 4.0)), (4, 4))
    assert (shown(Buffer(), view) == 0).all() and (shown(Buffer(after_near=True), view) == -1).all()


def test_a_minifloat_of_5_and_10_bits_is_half_float() -> None:
    view = hsr.view(scene_of(central(1.0), wall(2.0, 4.0)), (4, 4))
    d = np.geomspace(1.0, 1e7, 400)
    assert np.array_equal(-minifloat(5, 10)(view, d), (1.0 / d).astype(np.float16).astype(np.float64))


@pytest.mark.parametrize(
    ("shape", "mistake"),
    [
        ("sphere", naive_spheres(np.float64)),
        ("cylinder", general_cylinders(np.float64)),
        ("square", naive_boxes),
    ],
)
def test_rays_are_right_where_nothing_is_hard(shape: str, mistake: Any) -> None:
    turn = [] if shape == "square" else [{"rotate_x": 20.0}, {"rotate_y": 30.0}]
    thing = {"shape": shape, "transform": [*turn, {"translate": [0.013, 0.017, -3.0]}]}
    view = hsr.view(scene_of(central(0.5), thing), (16, 16))
    assert np.array_equal(shown(mistake, view), hsr.render(view, "exact").face)
