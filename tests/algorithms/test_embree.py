from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms import embree
from hsr.errors import MethodError, UnavailableError
from tests.opengl.brute_force import assert_agrees


def test_without_embreex_it_says_what_to_install(make_scene: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "embreex", None)
    with pytest.raises(UnavailableError, match=r"pip install 'hsr-lab\[embree\]'"):
        hsr.render(make_scene([{"name": "cube", "shape": "cube"}]), "embree", size=(4, 4))


@pytest.fixture
def _installed() -> None:
    pytest.importorskip("embreex", reason="embreex is not installed")


CAMERAS: dict[str, dict[str, Any]] = {
    "to infinity": {"near": 0.5},
    "near and far cut": {"near": 4.6, "far": 6.0},
    "inside the scene": {"eye": [0.3, 0.2, 0.4], "near": 0.05, "fov": 90.0},
    "parallel": {"type": "orthographic", "height": 5.0, "near": -1.0, "far": 5.5},
}


@pytest.mark.usefixtures("_installed")
@pytest.mark.parametrize("cull", ["none", "back", "front"])
@pytest.mark.parametrize("camera", CAMERAS)
def test_agrees_with_brute_force_where_no_edge_is_near(make_scene: Any, camera: str, cull: str) -> None:
    turned = [{"rotate_x": 20.0}, {"rotate_y": 35.0}]
    objects = [
        {"name": "cube", "shape": "cube", "cull": cull, "transform": turned},
        {"name": "wall", "shape": "square", "transform": [{"scale": 1.7}, {"rotate_y": -50.0}]},
        {"name": "can", "shape": "cylinder", "cull": cull, "transform": [{"scale": [-0.5, 0.5, 2.0]}]},
    ]
    scene = make_scene(objects, **CAMERAS[camera]).model_copy(update={"segments": 12})
    view = hsr.view(scene, (40, 30))
    answer = hsr.render(view, "embree")
    # A few roundings of float32 against distances of the size of the scene.
    assert_agrees(answer.face, answer.depth, view, relative=1e-5)


@pytest.mark.usefixtures("_installed")
def test_an_image_in_bands_is_the_image(make_scene: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    view = hsr.view(make_scene([{"name": "cube", "shape": "cube"}]), (16, 13))
    whole = hsr.render(view, "embree")
    monkeypatch.setattr(embree, "RAYS_AT_ONCE", 16 * 5)
    bands = hsr.render(view, "embree")
    np.testing.assert_array_equal(bands.face, whole.face)
    np.testing.assert_array_equal(bands.depth, whole.depth)


@pytest.mark.usefixtures("_installed")
def test_says_what_was_traced_and_how_long_it_took(make_scene: Any) -> None:
    answer = hsr.render(make_scene([{"name": "can", "shape": "cylinder"}]), "embree", size=(8, 6))
    assert answer.method == "embree"
    assert answer.work == {"rays": 48, "triangles": 2 * 48 + 2 * 46}
    assert set(answer.seconds) == {"prepare", "build", "render"}
    assert answer.notes["driver"].startswith("embreex ")
    assert answer.notes["depth_format"]["stored"] == "distance"
    assert answer.face.dtype == np.int32 and answer.depth.dtype == np.float64


@pytest.mark.usefixtures("_installed")
def test_a_scene_of_which_nothing_is_left_is_background(make_scene: Any) -> None:
    away = {"name": "wall", "shape": "square", "cull": "back", "transform": [{"rotate_y": 180.0}]}
    answer = hsr.render(make_scene([away]), "embree", size=(8, 8))
    assert (answer.face == -1).all() and np.isposinf(answer.depth).all()
    assert answer.work["triangles"] == 0


@pytest.mark.usefixtures("_installed")
def test_coordinates_beyond_float32_are_one_clear_line(make_scene: Any) -> None:
    huge = {"name": "cube", "shape": "cube", "transform": [{"scale": 1e39}]}
    with pytest.raises(MethodError, match="beyond float32"):
        hsr.render(make_scene([huge]), "embree", size=(4, 4))
