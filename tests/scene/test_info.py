"""What a scene is said to hold, and where culling is said to be lossless."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hsr.base.errors import ViewError
from hsr.scene.files import load
from hsr.scene.info import describe, lines, schema
from hsr.scene.model import Scene

CUBE = {"name": "box", "shape": "cube"}


def culling(scene: Scene) -> list[str]:
    """Of the only camera, for every object."""
    return [next(iter(entry["culling"].values())) for entry in describe(scene)["objects"]]


def test_objects_totals_and_bounds(make_scene: Any) -> None:
    scatter = {"count": 3, "x": [2, 2], "z": [0, 0]}
    ball = {"name": "ball", "shape": "sphere", "transform": [{"scale": [1, 2, 3]}, {"translate": [0, 0, 10]}]}
    found = describe(make_scene([{**CUBE, "scatter": scatter, "cull": "back"}, ball]))
    box, sphere = found["objects"]
    assert found["totals"] == {"objects": 2, "copies": 4, "faces": 19}
    assert (box["name"], box["shape"], box["copies"], box["faces"], box["cull"]) == (
        "box",
        "cube",
        3,
        6,
        "back",
    )
    assert sphere["bounds"] == {"low": [-1, -2, 7], "high": [1, 2, 13]}
    assert found["bounds"]["low"][1] == -2.0 and found["bounds"]["high"][2] == 13.0
    json.dumps(found, allow_nan=False)


def test_bounds_of_a_turned_cylinder(make_scene: Any) -> None:
    drum = {"name": "drum", "shape": "cylinder", "transform": [{"scale": [1, 1, 4]}, {"rotate_y": 90}]}
    (entry,) = describe(make_scene([drum]))["objects"]
    assert entry["bounds"] == {"low": [0, -1, -1], "high": [4, 1, 1]}


def test_bounds_of_a_turned_cone(make_scene: Any) -> None:
    for top, x in ((0.0, 1.0), (0.5, 1.0), (3.0, 3.0)):
        cone = {"name": "cone", "shape": "cylinder", "top": top, "transform": [{"rotate_y": 90}]}
        (entry,) = describe(make_scene([cone]))["objects"]
        assert entry["bounds"] == {"low": [0, -x, -x], "high": [1, x, x]}
    leaning = {"name": "cone", "shape": "cylinder", "top": 0.0, "transform": [{"rotate_x": 45}]}
    (entry,) = describe(make_scene([leaning]))["objects"]
    assert entry["bounds"]["low"][1] == pytest.approx(-math.sqrt(0.5))
    assert entry["bounds"]["high"][2] == pytest.approx(math.sqrt(0.5))


@pytest.mark.parametrize(("height", "inside"), [(0.45, True), (0.55, False)])
def test_an_eye_is_inside_a_cone_up_to_its_side(make_scene: Any, height: float, inside: bool) -> None:
    cone = {"name": "cone", "shape": "cylinder", "top": 0.0}
    scene = make_scene([cone], eye=[0.5, 0.0, height], target=[0.0, 0.0, height])
    assert culling(scene) == ["the eye is inside it" if inside else "the near plane cuts it"]


def test_a_vertex_without_a_face_has_no_part_in_the_bounds(make_scene: Any) -> None:
    vertices = [[9, 9, 9], [0, 0, 0], [1, 0, 0], [0, 1, 0]]
    (entry,) = describe(
        make_scene([{"name": "m", "shape": "mesh", "vertices": vertices, "faces": [[1, 2, 3]]}])
    )["objects"]
    assert entry["bounds"] == {"low": [0, 0, 0], "high": [1, 1, 0]}


@pytest.mark.parametrize(
    ("axis", "x", "y"), [("y", 126.869897646, 90.0), ("x", 90.0, 53.130102354), ("min", 126.869897646, 90.0)]
)
def test_both_fields_of_view(make_scene: Any, axis: str, x: float, y: float) -> None:
    (camera,) = describe(make_scene([CUBE], fov=90.0, fov_axis=axis, far=50), (200, 100))["cameras"]
    assert camera == {"name": "main", "type": "perspective", "near": 0.1, "far": 50.0, "fov_x": x, "fov_y": y}


def test_size_of_a_parallel_view(make_scene: Any) -> None:
    (camera,) = describe(make_scene([CUBE], type="orthographic", height=4, far=9), (200, 100))["cameras"]
    assert camera == {
        "name": "main",
        "type": "orthographic",
        "near": 0.0,
        "far": 9.0,
        "width": 8.0,
        "height": 4.0,
    }


# ---------------------------------------------------------------- culling


@pytest.mark.parametrize("shape", ["cube", "sphere", "cylinder"])
def test_solids_lose_nothing(make_scene: Any, shape: str) -> None:
    mirrored = {"name": "b", "shape": shape, "transform": [{"scale": [-1, 1, 1]}]}
    assert culling(make_scene([{"name": "a", "shape": shape}, mirrored])) == ["", ""]


def test_what_is_not_closed_shows_its_back(make_scene: Any) -> None:
    teapot = {"name": "pot", "shape": "teapot", "detail": 2}
    square, pot = culling(make_scene([{"name": "sheet", "shape": "square"}, teapot]))
    assert square == "not closed: a square has no inside" and pot.startswith("not closed: ")


@pytest.mark.parametrize("shape", ["cube", "sphere", "cylinder"])
def test_an_eye_inside_sees_the_back(make_scene: Any, shape: str) -> None:
    scene = make_scene([{"name": "a", "shape": shape}], eye=[0.1, 0.2, 0.5])
    assert culling(scene) == ["the eye is inside it"]


@pytest.mark.parametrize("shape", ["cube", "sphere", "cylinder"])
def test_a_near_plane_through_a_solid_shows_its_back(make_scene: Any, shape: str) -> None:
    cut = make_scene([{"name": "a", "shape": shape}], eye=[0.0, 0.0, 5.0], near=4.5)
    assert culling(cut) == ["the near plane cuts it"]
    beyond = make_scene([{"name": "a", "shape": shape}], eye=[0.0, 0.0, 5.0], near=7.0)
    assert culling(beyond) == [""]


def test_a_near_plane_through_a_solid_of_a_parallel_view(make_scene: Any) -> None:
    parallel = {
        "type": "orthographic",
        "eye": [0.0, 0.0, 0.0],
        "target": [0.0, 0.0, -1.0],
        "height": 4,
        "far": 9,
    }
    assert culling(make_scene([CUBE], **parallel)) == ["the near plane cuts it"]
    assert culling(make_scene([CUBE], **parallel, near=-1)) == [""]


def test_the_copy_that_is_cut_is_named(make_scene: Any) -> None:
    scatter = {"count": 200, "x": [-9, 9], "z": [-9, 9], "seed": 1}
    (why,) = culling(make_scene([{**CUBE, "scatter": scatter}]))
    assert why.endswith(")") and "(copy " in why


def test_every_camera_has_its_verdict(make_scene: Any) -> None:
    scene: Scene = make_scene([CUBE])
    outside, inside = (
        scene.camera[0],
        scene.camera[0].model_copy(update={"name": "in", "eye": (0.0, 0.0, 0.5)}),
    )
    found = describe(scene.model_copy(update={"camera": (outside, inside)}))
    assert found["objects"][0]["culling"] == {"main": "", "in": "the eye is inside it"}
    text = lines(found)
    assert "  culling its back faces seen by main changes nothing" in text
    assert "  culling its back faces seen by in may change the picture: the eye is inside it" in text


# ---------------------------------------------------------------- words


def test_lines_for_people(tmp_path: Path) -> None:
    (tmp_path / "q.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    text = lines(describe(load(tmp_path / "q.obj"), (100, 100)))
    assert text[0] == "q.obj"
    assert text[1] == "1 object, 2 faces; from (0, 0, 0) to (1, 1, 0)"
    assert text[2].startswith("camera fitted: perspective, fov 40.00 x 40.00 degrees, near ")
    assert text[3] == "object q: mesh, 2 faces, cull none, 1 face of its file cut into triangles"
    assert (
        text[4]
        == "  culling its back faces may change the picture: not closed: 4 edges belong to one face only"
    )


def test_a_parallel_view_and_copies_in_words(make_scene: Any) -> None:
    scatter = {"count": 2, "x": [0, 0], "z": [0, 0]}
    scene = make_scene([{**CUBE, "scatter": scatter}], type="orthographic", height=4, far=9)
    text = lines(describe(scene, (200, 100)))
    assert text[0] == "untitled scene"
    assert text[2] == "camera main: orthographic, 8 x 4 units, near 0, far 9"
    assert text[3] == "object box: 2 x cube, 6 faces, cull none"


def test_a_camera_that_cannot_be_used(make_scene: Any) -> None:
    with pytest.raises(ViewError, match=r"^camera 'main': its numbers are too extreme"):
        describe(make_scene([CUBE], fov=1e-320))


def test_the_schema_knows_every_shape_and_takes_no_unknown_key() -> None:
    found = schema()
    assert found["$schema"].endswith("2020-12/schema") and found["additionalProperties"] is False
    shapes = found["$defs"]["Step"]
    assert (shapes["minProperties"], shapes["maxProperties"]) == (1, 1)
    assert {"Cube", "Mesh", "Polyhedron", "Teapot", "Fir"} <= set(found["$defs"])
    assert "folder" not in json.dumps(found["properties"])
    assert {"type": "number"} in shapes["properties"]["scale"]["anyOf"]


def test_turned_bounds_hold_the_corners(make_scene: Any) -> None:
    turns = [{"rotate_x": 10}, {"rotate_y": 20}, {"rotate_z": 30}]
    found = describe(make_scene([{**CUBE, "transform": turns}]))["bounds"]
    from hsr.scene.model import Step
    from hsr.scene.transforms import compose

    matrix = compose([Step.model_validate(turn) for turn in turns])[:3, :3]
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) @ matrix.T
    assert np.allclose(found["low"], corners.min(axis=0)) and np.allclose(found["high"], corners.max(axis=0))
