"""Cameras that fit a scene."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np
import pytest

from hsr.base.errors import ViewError
from hsr.scene.camera import projection_of
from hsr.scene.fitting import Ball, ball_around, fitted, moved, turned
from hsr.scene.model import MatrixCamera, Orthographic, Perspective

BALL = Ball(np.array([1.0, 2.0, 3.0]), 2.0)
MAIN = Perspective(name="main", eye=(4.0, 2.0, 3.0), target=(1.0, 2.0, 3.0), fov=30.0, near=0.5, far=9.0)
MATRIX = MatrixCamera(name="m", matrix=np.eye(4))


def test_a_ball_holds_all_points_and_has_a_size() -> None:
    corners = np.array(list(product((-1.0, 3.0), (0.0, 1.0), (2.0, 2.0))))
    centre, radius = ball_around(corners)
    assert centre.tolist() == [1.0, 0.5, 2.0] and radius == pytest.approx(math.hypot(2.0, 0.5))
    assert ball_around(corners[:1]).radius == 1.0


@pytest.mark.parametrize("aspect", [0.3, 1.0, 3.0])
def test_a_fitted_camera_has_all_of_a_ball_in_view(aspect: float) -> None:
    points = np.random.default_rng(1).normal(size=(500, 3))
    points = BALL.centre + BALL.radius * points / np.linalg.norm(points, axis=1)[:, None]
    projection = projection_of(fitted(BALL), aspect)
    x, y, _, w = projection.clip_from_world @ np.column_stack([points, np.ones(500)]).T
    assert w.min() > projection.near and max(np.abs(x / w).max(), np.abs(y / w).max()) < 1.0


def test_what_is_not_given_stays() -> None:
    assert moved(MAIN, BALL, fov=50.0) == MAIN.model_copy(update={"fov": 50.0})
    there = moved(MAIN, BALL, eye=(1.0, 2.0, 13.0))
    assert (there.name, there.target, there.fov) == ("main", MAIN.target, 30.0)
    assert (there.near, there.far) == (4.0, None)
    assert moved(MAIN, BALL, eye=(1.0, 2.0, 13.0), near=1.0, far=5.0).far == 5.0


def test_near_of_a_camera_inside_is_close() -> None:
    assert moved(MAIN, BALL, eye=(1.5, 2.0, 3.0)).near == pytest.approx(2e-3)


def test_cameras_change_their_projection() -> None:
    parallel = moved(MAIN, BALL, height=4.0)
    assert isinstance(parallel, Orthographic)
    assert (parallel.eye, parallel.height, parallel.near) == (MAIN.eye, 4.0, 0.0)
    assert parallel.far == pytest.approx(1.05 * 5.0)
    back = moved(parallel, BALL, fov=30.0)
    assert isinstance(back, Perspective) and (back.near, back.far) == (0.5, None)


@pytest.mark.parametrize(
    "keys", [{"eye": MAIN.target}, {"fov": 180.0}, {"far": 0.1}, {"up": (1.0, 0.0, 0.0)}]
)
def test_what_makes_no_camera_is_refused(keys: dict[str, Any]) -> None:
    with pytest.raises(ViewError, match="camera 'main': "):
        moved(MAIN, BALL, **keys)


def test_a_turn_ends_where_it_began() -> None:
    camera = Perspective(eye=(3.0, 4.0, 5.0), target=(1.0, 1.0, 1.0))
    np.testing.assert_allclose(turned(camera, 2.0 * np.pi).eye, camera.eye, atol=1e-12)
    quarter = turned(camera, 0.5 * np.pi, "side")
    x, y, z = np.subtract(camera.eye, camera.target)
    np.testing.assert_allclose(np.subtract(quarter.eye, quarter.target), (z, y, -x), atol=1e-12)
    assert (turned(camera, 1.0).name, quarter.name) == ("main", "side")


@pytest.mark.parametrize("how", [lambda: turned(MATRIX, 1.0), lambda: moved(MATRIX, BALL, fov=30.0)])
def test_a_camera_without_a_place_stays_where_it_is(how: Any) -> None:
    with pytest.raises(ViewError, match="camera 'm' is a matrix"):
        how()
