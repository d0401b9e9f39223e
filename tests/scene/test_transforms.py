"""Composed transforms are the true ones, rounded once."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hsr.base.errors import SceneError
from hsr.scene.model import Cube, Scatter, Step
from hsr.scene.transforms import compose, copies


def steps(*tables: dict[str, Any]) -> list[Step]:
    return [Step.model_validate(table) for table in tables]


def test_no_steps_are_the_identity() -> None:
    assert np.array_equal(compose([]), np.eye(4))


def test_the_first_step_applies_first() -> None:
    moved_then_scaled = compose(steps({"translate": [1, 0, 0]}, {"scale": 2}))
    scaled_then_moved = compose(steps({"scale": 2}, {"translate": [1, 0, 0]}))
    assert moved_then_scaled[0, 3] == 2.0 and scaled_then_moved[0, 3] == 1.0


@pytest.mark.parametrize(
    ("key", "before", "after"), [("rotate_x", 1, 2), ("rotate_y", 2, 0), ("rotate_z", 0, 1)]
)
def test_a_quarter_turn_is_exact_and_counter_clockwise(key: str, before: int, after: int) -> None:
    turned = compose(steps({key: 90}))[:3, :3] @ np.eye(3)[before]
    assert np.array_equal(turned, np.eye(3)[after])


def test_sines_are_rounded_once() -> None:
    matrix = compose(steps({"rotate_z": 30}))
    assert matrix[1, 0] == 0.5
    assert matrix[0, 0] == math.sqrt(3) / 2


def test_twelve_turns_of_thirty_degrees_are_the_identity() -> None:
    assert np.array_equal(compose(steps(*[{"rotate_y": 30}] * 12)), np.eye(4))


def test_products_are_not_rounded_on_the_way() -> None:
    matrix = compose(
        steps({"translate": [1e20, 0, 0]}, {"translate": [1, 0, 0]}, {"translate": [-1e20, 0, 0]})
    )
    assert matrix[0, 3] == 1.0


def test_a_matrix_is_taken_row_by_row() -> None:
    rows = [[1.0, 2.0, 3.0, 4.0], [0.0, 1.0, 5.0, 6.0], [0.0, 0.0, 1.0, 7.0], [0.0, 0.0, 0.0, 1.0]]
    assert compose(steps({"matrix": rows})).tolist() == rows


@given(st.floats(-1e6, 1e6))
def test_rotations_agree_with_the_library(degrees: float) -> None:
    matrix = compose(steps({"rotate_x": degrees}))
    angle = math.radians(math.fmod(degrees, 360.0))
    assert matrix[2, 1] == pytest.approx(math.sin(angle), abs=1e-14)
    assert matrix[2, 2] == pytest.approx(math.cos(angle), abs=1e-14)


@pytest.mark.parametrize("scale", [1e-200, 1e200])
def test_steps_that_leave_the_range_of_float64(scale: float) -> None:
    with pytest.raises(SceneError, match=r"^the steps together over- or underflow float64"):
        compose(steps({"scale": scale}, {"scale": scale}))


def cubes(**scatter: Any) -> Cube:
    return Cube(name="box", shape="cube", transform=tuple(steps({"scale": 2})), scatter=Scatter(**scatter))


def test_an_object_is_its_own_only_copy() -> None:
    ((name, matrix),) = copies(Cube(name="box", shape="cube"))
    assert name == "box" and np.array_equal(matrix, np.eye(4))


def test_scattered_copies_stand_on_the_ground_within_their_ranges() -> None:
    found = list(copies(cubes(count=50, x=(-1.0, 1.0), z=(5.0, 6.0), scale=(0.5, 1.0), seed=3)))
    assert [name for name, _ in found[:2]] == ["box.0", "box.1"] and len(found) == 50
    matrices = np.array([matrix for _, matrix in found])
    assert np.abs(matrices[:, 0, 3]).max() <= 1.0
    assert matrices[:, 2, 3].min() >= 5.0 and matrices[:, 2, 3].max() <= 6.0
    assert not matrices[:, 1, 3].any()
    size = np.cbrt(np.linalg.det(matrices[:, :3, :3]))
    assert size.min() >= 1.0 - 1e-12 and size.max() <= 2.0 + 1e-12


def test_the_seed_decides() -> None:
    one, same, other = (
        next(copies(cubes(count=1, x=(-1.0, 1.0), z=(-1.0, 1.0), seed=seed)))[1] for seed in (1, 1, 2)
    )
    assert np.array_equal(one, same) and not np.array_equal(one, other)


def test_copies_name_the_object_whose_transform_fails() -> None:
    thing = Cube(name="dust", shape="cube", transform=tuple(steps({"scale": 1e-200}, {"scale": 1e-200})))
    with pytest.raises(SceneError, match=r"^object 'dust': the steps together"):
        list(copies(thing))
