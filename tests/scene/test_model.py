"""The model of a scene: what it accepts, and the one line it has for everything else."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from hsr.scene.model import Perspective, Scene, Step
from hsr.scene.validation import lines_of
from hsr.scene.values import exact_determinant

CAMERA = {"type": "perspective", "eye": [0.0, 0.0, 5.0]}
CUBE = {"name": "a", "shape": "cube"}
IDENTITY = [[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 1.0, 0], [0, 0, 0, 1.0]]
TETRAHEDRON = {
    "name": "t",
    "shape": "polyhedron",
    "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
}


def scene(camera: Any = None, thing: Any = None, **keys: Any) -> dict[str, Any]:
    return {"camera": [camera or CAMERA], "object": [thing or CUBE], **keys}


def step(**keys: Any) -> dict[str, Any]:
    return scene(thing={**CUBE, "transform": [keys]})


def matrix(*rows: list[float]) -> list[list[float]]:
    return [*rows, *IDENTITY[len(rows) :]]


SHAPES = "square, cube, sphere, cylinder, polyhedron, mesh, teapot, torus-knot, terrain, menger, fir"
STEPS = "translate, scale, rotate_x, rotate_y, rotate_z, matrix"

PROBLEMS = [
    ([], "expected a table, got []"),
    (scene(hsr=2), "hsr: expected 1, got 2"),
    (scene(titel="x"), "titel: unknown key; did you mean 'title'? the keys here are hsr, title, about, "),
    (scene(folder="x"), "folder: unknown key; the keys here are hsr, "),
    (scene(title=3), "title: expected a string, got 3"),
    (scene(segments=2), "segments: must be at least 3, got 2"),
    (scene(segments=9.5), "segments: expected a whole number, got 9.5"),
    (scene(background=[0, 0, 1.5]), "background[2]: must be at most 1, got 1.5"),
    (scene(background=[0, 0, -1]), "background[2]: must be at least 0, got -1"),
    (scene(background=[0, 0]), "background: expected 3 numbers, got 2"),
    (scene(background="red"), "background: expected a list, got 'red'"),
    ({"camera": [CAMERA]}, "object: this key is missing"),
    ({"camera": [], "object": []}, "object: needs at least 1, got []"),
    ({"camera": CAMERA, "object": [CUBE]}, "camera: expected a list, got a table"),
    (
        {"camera": [CAMERA, CAMERA], "object": [CUBE]},
        "camera: names must differ; more than one is called 'main'",
    ),
    ({"camera": [CAMERA], "object": [CUBE, CUBE]}, "object: names must differ; more than one is called 'a'"),
    ({"camera": [CAMERA], "object": [7]}, "object[0]: expected a table, got 7"),
    (scene(thing={**CUBE, "name": "a\0"}), "object[0].name: expected printable characters"),
    (scene({**CAMERA, "fov": 180}), "camera[0].fov: must be less than 180, got 180"),
    (scene({**CAMERA, "near": 0}), "camera[0].near: must be greater than 0, got 0"),
    (scene({**CAMERA, "far": 0.05}), "camera[0]: far (0.05) must be greater than near (0.1)"),
    (scene({**CAMERA, "fov_axis": "z"}), "camera[0].fov_axis: expected 'y', 'x' or 'min', got 'z'"),
    (scene({**CAMERA, "target": [0, 0, 5]}), "camera[0]: eye and target must differ"),
    (scene({**CAMERA, "up": [0, 0, 2]}), "camera[0]: up must not be zero nor point along the view axis"),
    (scene({**CAMERA, "up": [0, 0, 0]}), "camera[0]: up must not be zero nor point along the view axis"),
    (scene({**CAMERA, "up": [0, 1e-17, 1]}), "camera[0]: up must not be zero nor point along the view axis"),
    (scene({**CAMERA, "eye": [1e308, 0, 0], "target": [-1e308, 0, 0]}), "camera[0]: up must not be zero"),
    (scene({**CAMERA, "eye": [0, 0, float("nan")]}), "camera[0].eye[2]: expected a finite number, got nan"),
    (scene({**CAMERA, "eye": [0, 0, 10**400]}), "camera[0].eye[2]: expected a number, got 1000"),
    (
        scene({"type": "ortographic"}),
        "camera[0].type: there is no type 'ortographic'; did you mean 'orthographic'? ",
    ),
    (
        scene({"eye": [0, 0, 1]}),
        "camera[0]: the key 'type' is missing; known are perspective, orthographic, matrix",
    ),
    (
        scene({"type": "orthographic", "eye": [0, 0, 5], "height": 2, "far": -1}),
        "camera[0]: far (-1.0) must be greater than near (0.0)",
    ),
    (
        scene({"type": "matrix", "matrix": matrix([0.0] * 4)}),
        "camera[0].matrix: the matrix is singular: it flattens the world",
    ),
    (
        scene(thing={"name": "a", "shape": "cub"}),
        "object[0].shape: there is no shape 'cub'; did you mean 'cube'? ",
    ),
    (
        scene(thing={"name": "a", "shape": "blob"}),
        f"object[0].shape: there is no shape 'blob'; known are {SHAPES}",
    ),
    (scene(thing={"shape": "cube"}), "object[0].name: this key is missing"),
    (scene(thing={**CUBE, "name": ""}), "object[0].name: must have at least 1 character, got ''"),
    (scene(thing={**CUBE, "name": "x" * 81}), "object[0].name: must have at most 80 characters, got 'xxx"),
    (scene(thing={**CUBE, "shape": "cylinder", "top": -0.5}), "object[0].top: must be at least 0, got -0.5"),
    (scene(thing={**CUBE, "color": 1}), "object[0].color: unknown key; did you mean 'colour'? "),
    (scene(thing={**CUBE, "transform": {}}), "object[0].transform: expected a list, got a table"),
    (step(scale=0), "object[0].transform[0].scale: a scale of 0 makes the transform singular"),
    (step(scale=[1, 0, 1]), "object[0].transform[0].scale: a scale of 0 makes the transform singular"),
    (step(scale="big"), "object[0].transform[0].scale: expected a list, got 'big'"),
    (step(translate=[1, 2, True]), "object[0].transform[0].translate[2]: expected a number, got True"),
    (
        step(rotate_w=1),
        f"object[0].transform[0].rotate_w: unknown key; did you mean 'rotate_z'? the keys here are {STEPS}",
    ),
    (step(), f"object[0].transform[0]: a step has exactly one key of {STEPS}"),
    (step(scale=None), f"object[0].transform[0]: a step has exactly one key of {STEPS}"),
    (step(scale=1, rotate_x=2), f"object[0].transform[0]: a step has exactly one key of {STEPS}"),
    (step(matrix=IDENTITY[:3]), "object[0].transform[0].matrix: expected 4 rows, got 3"),
    (
        step(matrix=[*IDENTITY[:3], [0, 0, 0, 2]]),
        "object[0].transform[0].matrix: the last row of an affine matrix is",
    ),
    (
        step(matrix=matrix([0.0] * 4)),
        "object[0].transform[0].matrix: the matrix is singular: it flattens the object",
    ),
    (
        scene(thing={**CUBE, "scatter": {"count": 0, "x": [0, 1], "z": [0, 1]}}),
        "object[0].scatter.count: must be at",
    ),
    (
        scene(thing={**CUBE, "scatter": {"count": 1, "x": [1, 0], "z": [0, 1]}}),
        "object[0].scatter: x and z are ranges",
    ),
    (
        scene(thing={**CUBE, "scatter": {"count": 1, "x": [0, 1], "z": [0, 1], "scale": [0, 1]}}),
        "object[0].scatter: scale is a range [low, high] with 0 < low <= high",
    ),
    (
        scene(thing={**CUBE, "scatter": {"count": 1, "x": [0, 1], "z": [0, 1], "sede": 1}}),
        "object[0].scatter.sede: unknown key; did you mean 'seed'? ",
    ),
    (
        scene(thing={**TETRAHEDRON, "faces": [[0, 2, 1], [0, 1, 3], [1, 2, 4], [0, 3, 2]]}),
        "object[0]: faces[2] names vertex 4; there are 4, numbered from 0",
    ),
    (
        scene(thing={"name": "m", "shape": "mesh"}),
        "object[0]: a mesh has either file, or both vertices and faces",
    ),
    (
        scene(thing={"name": "m", "shape": "mesh", "vertices": [[0, 0, 0]], "faces": [], "part": "x"}),
        "object[0]: part names a part of a file; leave it out",
    ),
    (
        scene(thing={"name": "m", "shape": "mesh", "vertices": [[0, 0, 0]], "faces": [[0, 0]]}),
        "object[0].faces[0]: needs at least 3, got [0, 0]",
    ),
    (
        scene(light=[{"type": "directional", "direction": [0, 0, 0]}]),
        "light[0].direction: a direction of length 0",
    ),
    (
        scene(light=[{"type": "sun"}]),
        "light[0].type: there is no type 'sun'; known are ambient, directional, point",
    ),
]


@pytest.mark.parametrize(
    ("tables", "expected"), PROBLEMS, ids=lambda value: value if isinstance(value, str) else ""
)
def test_one_line_for_every_mistake(tables: Any, expected: str) -> None:
    with pytest.raises(ValidationError) as caught:
        Scene.model_validate(tables)
    (line,) = lines_of(caught.value)
    assert line.startswith(expected)
    assert "\n" not in line


def test_all_mistakes_at_once() -> None:
    tables = {"camera": [{**CAMERA, "fov": 0}], "object": [{**CUBE, "cull": "bak", "colour": [2, 0, "x"]}]}
    with pytest.raises(ValidationError) as caught:
        Scene.model_validate(tables)
    assert lines_of(caught.value) == [
        "camera[0].fov: must be greater than 0, got 0",
        "object[0].cull: expected 'none', 'back' or 'front', got 'bak'",
        "object[0].colour[0]: must be at most 1, got 2",
        "object[0].colour[2]: expected a number, got 'x'",
    ]


def test_defaults() -> None:
    made = Scene.model_validate(scene())
    camera = made.camera[0]
    assert isinstance(camera, Perspective)
    assert (camera.fov, camera.fov_axis, camera.near, camera.far) == (45.0, "y", 0.1, None)
    assert (made.segments, made.light, made.object[0].cull) == (48, (), "none")
    assert made.folder == Path()


def test_a_located_scene_is_another_one() -> None:
    made = Scene.model_validate(scene())
    assert made.located(Path("there")).folder == Path("there")
    assert made.folder == Path()


def test_a_number_scales_alike_along_all_axes() -> None:
    assert Step(scale=2).given == {"scale": (2.0, 2.0, 2.0)}  # type: ignore[arg-type]


def test_scenes_are_frozen() -> None:
    with pytest.raises(ValidationError):
        Scene.model_validate(scene()).title = "other"  # type: ignore[misc]


def test_tiny_and_huge_directions_are_directions() -> None:
    for up in ([0, 1e-200, 0], [0, 1e200, 0], [0, 1e-3, 1]):
        Scene.model_validate(scene({**CAMERA, "up": up}))


def test_determinants_do_not_round() -> None:
    assert exact_determinant([[1.0, 1.0], [1.0, 1.0 + 2.0**-52]]) == Fraction(1, 2**52)
    assert exact_determinant([[0.0, 1.0], [1.0, 0.0]]) == -1
    assert exact_determinant([[0.1, 0.3], [0.3, 0.9]]) != 0
    assert exact_determinant([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]) == 0


@given(st.lists(st.lists(st.integers(-9, 9), min_size=3, max_size=3), min_size=3, max_size=3))
def test_determinants_follow_the_rule_of_sarrus(rows: list[list[int]]) -> None:
    (a, b, c), (d, e, f), (g, h, i) = rows
    assert (
        exact_determinant(np.array(rows, dtype=float))
        == a * e * i + b * f * g + c * d * h - c * e * g - b * d * i - a * f * h
    )
