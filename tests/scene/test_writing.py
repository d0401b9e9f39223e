"""Scenes written as TOML: read back, every number is the same, bit by bit."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hsr.base.errors import SceneError
from hsr.problem.view import view
from hsr.scene.files import load
from hsr.scene.model import Scene
from hsr.scene.writing import to_toml, write_scene

BUILT_IN = sorted(path.name for path in (Path(__file__).parents[2] / "scenes").glob("*.toml"))
ODD = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e300, max_value=1e300)

AFFINE = [[1, 2, 3, 4], [0, 1, 0, 0.1], [0, 0, 1, 0], [0, 0, 0, 1]]
POINTS = [[0, 0, 0.1], [1e-300, 0, 0], [0, 1e22, 0]]
STREWN = {"count": 3, "x": [-1.0, 1.0], "z": [0, 2], "seed": 5}

EVERYTHING: dict[str, Any] = {
    "title": 'a "quoted" \\ title\twith\nlines, é, \x7f and ∞',
    "background": (0.1, 0.2, 0.3),
    "segments": 7,
    "camera": [
        {"type": "perspective", "name": "p", "eye": [1.0, 2.0, 3.0], "fov_axis": "min", "far": 9.5},
        {"type": "orthographic", "name": "o", "eye": [0.0, 0.0, 3.0], "height": 2.5, "near": -1.0, "far": 8},
        {
            "type": "matrix",
            "name": "m",
            "matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1.5, -2.0], [0.0, 0.0, -1.0, 0.0]],
        },
    ],
    "object": [
        {"shape": "square", "name": "s", "transform": [{"scale": 2}, {"rotate_x": 0.1}], "cull": "back"},
        {"shape": "sphere", "name": "ball", "transform": [{"matrix": AFFINE}]},
        {"shape": "cylinder", "name": "log", "scatter": STREWN},
        {
            "shape": "polyhedron",
            "name": "t",
            "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
            "faces": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        },
        {"shape": "mesh", "name": "m", "vertices": POINTS, "faces": [[0, 1, 2]]},
        {"shape": "teapot", "name": "pot", "detail": 2},
        {"shape": "torus-knot", "name": "knot", "segments": 8, "sides": 3, "thickness": 0.1},
        {"shape": "terrain", "name": "land", "detail": 1},
        {"shape": "menger", "name": "sponge", "level": 1},
        {"shape": "fir", "name": "fir", "tiers": 1},
    ],
    "light": [
        {"type": "ambient"},
        {"type": "directional", "direction": [0, -1, 0]},
        {"type": "point", "position": [1, 2, 3], "colour": [1, 0.5, 0]},
    ],
}


def reread(scene: Scene, folder: Path) -> Scene:
    write_scene(scene, folder / "written.toml")
    return load(folder / "written.toml")


@pytest.mark.parametrize("name", BUILT_IN)
def test_built_in_scenes_come_back_the_same(name: str, scenes: Path, tmp_path: Path) -> None:
    scene = load(scenes / name)
    again = reread(scene, tmp_path)
    assert again.model_dump() == scene.model_dump()
    for camera in scene.camera:
        assert view(again, (8, 8), camera.name).hashes == view(scene, (8, 8), camera.name).hashes


def test_everything_a_scene_may_hold_comes_back_the_same(tmp_path: Path) -> None:
    scene = Scene.model_validate(EVERYTHING)
    again = reread(scene, tmp_path)
    assert again.model_dump() == scene.model_dump()
    assert view(again, (8, 8)).hashes == view(scene, (8, 8)).hashes


@given(st.tuples(ODD, ODD, ODD))
def test_floats_come_back_bit_by_bit(point: tuple[float, float, float]) -> None:
    import tomllib

    corners = [point, (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)]
    mesh = {"shape": "mesh", "name": "m", "vertices": corners, "faces": [(0, 1, 2)]}
    camera = {"type": "perspective", "eye": (0.0, 0.0, 3.0), "target": (0.0, 0.0, -0.0)}
    scene = Scene.model_validate({"camera": [camera], "object": [mesh]})
    (written,) = Scene.model_validate(tomllib.loads(to_toml(scene))).object
    assert written.shape == "mesh" and written.vertices is not None
    assert struct.pack("3d", *written.vertices[0]) == struct.pack("3d", *point)


def test_zeros_keep_their_sign() -> None:
    camera = {"type": "perspective", "eye": [0.0, 0.0, 3.0], "target": [0.0, 0.0, -0.0]}
    scene = Scene.model_validate({"camera": [camera], "object": [{"shape": "cube", "name": "c"}]})
    assert "target = [0.0, 0.0, -0.0]" in to_toml(scene)


def test_only_what_was_given_is_written() -> None:
    camera = {"type": "perspective", "eye": [0.0, 0.0, 3.0]}
    scene = Scene.model_validate({"camera": [camera], "object": [{"shape": "cube", "name": "c"}]})
    assert to_toml(scene) == (
        'hsr = 1\n\n[[camera]]\neye = [0.0, 0.0, 3.0]\ntype = "perspective"\n\n'
        '[[object]]\nname = "c"\nshape = "cube"\n'
    )


def test_lists_of_points_and_of_steps_stand_one_to_a_line() -> None:
    text = to_toml(Scene.model_validate(EVERYTHING))
    assert "transform = [\n  { scale = [2.0, 2.0, 2.0] },\n  { rotate_x = 0.1 },\n]" in text
    assert "faces = [\n  [0, 2, 1],\n" in text


def test_a_file_that_cannot_be_written_is_one_line(tmp_path: Path) -> None:
    scene = Scene.model_validate(EVERYTHING)
    with pytest.raises(SceneError, match="cannot write the scene: No such file"):
        write_scene(scene, tmp_path / "no" / "scene.toml")
