"""Back-face culling as the only method."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms.registry import method_named
from hsr.base.errors import MethodError

FORMS = ["normal", "ndc", "determinant"]
ORTHOGRAPHIC = {"type": "orthographic", "eye": [2.0, 3.0, 5.0], "height": 8.0, "near": -20.0, "far": 20.0}
CAMERAS = [{"eye": [2.0, 3.0, 5.0]}, ORTHOGRAPHIC]


def cube(name: str, x: float = 0.0, z: float = 0.0, **keys: Any) -> dict[str, Any]:
    steps = [{"scale": 0.5}, {"rotate_y": 20.0}, {"translate": [x, 0.0, z]}]
    return {"name": name, "shape": "cube", "transform": steps, **keys}


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("form", FORMS)
def test_a_convex_solid_is_shown_as_the_depth_buffer_shows_it(
    make_scene: Any, form: str, camera: dict[str, Any]
) -> None:
    view = hsr.view(
        make_scene([{"name": "ball", "shape": "sphere"}, cube("box", 2.2, 2.0)], **camera), (40, 30)
    )
    answer, expected = hsr.render(view, "backface", form=form), hsr.render(view, "zbuffer")
    assert np.array_equal(answer.face, expected.face) and (answer.face >= 0).any()
    seen = answer.face >= 0
    assert answer.depth[seen] == pytest.approx(expected.depth[seen], rel=1e-12)
    assert answer.notes == {"sufficient": True, "overlapping_samples": 0, "uncovered_samples": 0}


@pytest.mark.parametrize("form", FORMS)
def test_solids_in_line_refute_it(make_scene: Any, form: str) -> None:
    """They do not touch, but overlap in projection: the later one is painted over the nearer."""
    things = [cube("near", 0.0, 2.0), cube("far", 0.0, -2.0)]
    view = hsr.view(make_scene(things, eye=[0.0, 0.0, 8.0]), (20, 20))
    answer, expected = hsr.render(view, "backface", form=form), hsr.render(view, "zbuffer")
    assert answer.name_of(int(answer.face[10, 10])).startswith("far")
    assert expected.name_of(int(expected.face[10, 10])).startswith("near")
    assert not answer.notes["sufficient"] and answer.notes["overlapping_samples"] > 0
    assert answer.depth[10, 10] > 8.0


def test_file_order_decides_what_is_on_top(make_scene: Any) -> None:
    near, far = cube("near", 0.0, 2.0), cube("far", 0.0, -2.0)
    answer = hsr.render(make_scene([far, near], eye=[0.0, 0.0, 8.0]), "backface", size=(20, 20))
    assert answer.name_of(int(answer.face[10, 10])).startswith("near")
    assert not answer.notes["sufficient"]  # right by luck of the order


def test_an_open_surface_from_behind_is_missing(make_scene: Any) -> None:
    def notes(**keys: Any) -> dict[str, Any]:
        wall = {"name": "wall", "shape": "square", **keys}
        answer = hsr.render(make_scene([wall], eye=[0.0, 0.0, -5.0]), "backface", size=(9, 9))
        assert (answer.face < 0).all()
        return answer.notes

    assert notes()["uncovered_samples"] > 0 and not notes()["sufficient"]
    assert notes(cull="back")["sufficient"]  # there the scene means it


@pytest.mark.parametrize("cull", ["none", "back", "front"])
def test_what_the_object_culls_is_not_heeded(make_scene: Any, cull: str) -> None:
    answer = hsr.render(make_scene([cube("box", cull=cull)], eye=[0.0, 0.0, 5.0]), "backface", size=(9, 9))
    assert answer.name_of(int(answer.face[4, 4])) == "box.front"


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("mirrored", [False, True])
def test_counts_of_faces(make_scene: Any, form: str, mirrored: bool, camera: dict[str, Any]) -> None:
    mirror = [{"scale": [1.0, -1.0, 1.0]}] if mirrored else []
    box = {"name": "box", "shape": "cube", "transform": mirror}
    answer = hsr.render(make_scene([box], **camera), "backface", size=(8, 8), form=form)
    assert answer.work == {"polygons": 6, "front_faces": 3, "back_faces": 3, "edge_on": 0}


@pytest.mark.parametrize("form", FORMS)
def test_edge_on_faces_are_neither(make_scene: Any, form: str) -> None:
    camera = {"type": "orthographic", "eye": [0.0, 0.0, 5.0], "height": 4.0, "far": 20.0}
    answer = hsr.render(
        make_scene([{"name": "box", "shape": "cube"}], **camera), "backface", size=(8, 8), form=form
    )
    assert answer.work == {"polygons": 6, "front_faces": 1, "back_faces": 1, "edge_on": 4}
    assert answer.notes["sufficient"]


def test_refused_form_names_the_choices() -> None:
    with pytest.raises(
        MethodError, match="backface has no form 'cross'; choose from normal, ndc, determinant"
    ):
        method_named("backface").options(form="cross")
