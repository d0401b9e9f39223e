"""Shrinking: what is left disagrees, nothing more can go, and the written scene says the same."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hsr.algorithms.registry import render
from hsr.base.errors import MethodError
from hsr.difference.shrink import minimised, shrink
from hsr.problem.view import view
from hsr.scene.files import load
from hsr.scene.writing import write_scene

SIZE = (48, 40)

CROWD: list[dict[str, Any]] = [
    {"shape": "cube", "name": "box", "transform": [{"rotate_y": 30.0}, {"translate": [-1.0, 0.0, 0.0]}]},
    {"shape": "sphere", "name": "ball", "transform": [{"translate": [0.7, 0.4, 0.3]}]},
    {"shape": "menger", "name": "sponge", "level": 1, "transform": [{"scale": 0.7}, {"rotate_x": 20.0}]},
    {"shape": "fir", "name": "tree", "scatter": {"count": 9, "x": [-2.0, 2.0], "z": [-2.0, 2.0]}},
]


@given(st.sets(st.integers(0, 40), min_size=1), st.integers(41, 60))
def test_exactly_what_is_needed_is_left(needed: set[int], count: int) -> None:
    assert minimised(range(count), lambda items: needed <= set(items)) == sorted(needed)


def test_no_single_item_can_go_and_nothing_is_asked_about_none() -> None:
    asked: list[Sequence[int]] = []

    def holds(items: Sequence[int]) -> bool:
        asked.append(items)
        return sum(items) % 7 == 1

    items = list(range(1, 30))
    assert holds(items)
    kept = minimised(items, holds)
    assert holds(kept) and all(asked)
    assert len(kept) == 1 or not any(holds(kept[:k] + kept[k + 1 :]) for k in range(len(kept)))


@pytest.mark.jit
@pytest.mark.parametrize(("a", "b"), [("zbuffer", "raycast"), ("backface", "zbuffer")])
def test_the_written_scene_disagrees_too(a: str, b: str, make_scene: Any, tmp_path: Path) -> None:
    scene = make_scene(CROWD)
    whole = view(scene, SIZE)
    shown = {method: render(whole, method) for method in (a, b)}
    different = np.argwhere(shown[a].face != shown[b].face)
    for row, column in different[:: len(different) // 4 + 1].tolist():
        found = shrink(scene, a, b, SIZE, x=column, y=row)
        assert len(found.faces) <= 7
        write_scene(found.scene, tmp_path / "small.toml")
        small = view(load(tmp_path / "small.toml"), SIZE)
        assert small.hashes == view(found.scene, SIZE).hashes
        assert np.array_equal(small.clip_from_world, whole.clip_from_world)
        names = [*found.faces, "background"]
        faces = [int(render(small, method).face[row, column]) for method in (a, b)]
        assert faces[0] != faces[1]
        assert tuple(names[face] for face in faces) == found.shown
        assert found.shown == tuple(shown[m].name_of(int(shown[m].face[row, column])) for m in (a, b))
        assert f"column {column}, row {row} of 48x40" in found.scene.title


def test_vertices_and_places_are_the_same_numbers(make_scene: Any) -> None:
    """Back-face detection alone paints the far one of two squares that face the eye."""
    near = {
        "shape": "square",
        "name": "near",
        "transform": [{"rotate_z": 10.0}, {"translate": [0.1, 0.0, 1.0]}],
    }
    scene = make_scene([near, {"shape": "square", "name": "far"}, {"shape": "cube", "name": "aside"}])
    aside = {"shape": "cube", "name": "aside", "transform": [{"translate": [9.0, 0.0, 0.0]}]}
    scene = make_scene([near, {"shape": "square", "name": "far"}, aside])
    found = shrink(scene, "backface", "zbuffer", SIZE, x=24, y=20)
    assert (found.shown, len(found.faces)) == (("far", "near"), 2)
    left, right = found.scene.object
    (step,) = left.transform
    whole = view(scene, SIZE).placements[0]
    assert np.array_equal(np.array(step.matrix), whole.world_from_object)
    assert right.transform == () and right.shape == "mesh"
    assert {*right.vertices} < {(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)}


def test_another_camera_is_kept_alone(make_scene: Any) -> None:
    scene = make_scene(CROWD)
    other = scene.camera[0].model_copy(update={"name": "other", "fov": 30.0})
    scene = scene.model_copy(update={"camera": (*scene.camera, other)})
    shown = [render(view(scene, SIZE, "other"), method).face for method in ("backface", "zbuffer")]
    row, column = np.argwhere(shown[0] != shown[1])[0].tolist()
    assert shrink(scene, "backface", "zbuffer", SIZE, "other", x=column, y=row).scene.camera == (other,)


def test_agreement_is_one_line(make_scene: Any) -> None:
    scene = make_scene([{"shape": "square", "name": "s"}])
    with pytest.raises(
        MethodError, match="backface and zbuffer agree at column 1, row 0: both show background"
    ):
        shrink(scene, "backface", "zbuffer", SIZE, x=1, y=0)
