"""tinyrenderer, a small rasteriser: its samples are the lower left corners of pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.errors import VisibilityError
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View
from hsr.scene.model import Scene
from hsr.testing import assert_agree, from_ids

tiny = pytest.importorskip("pytinyrenderer")

EYE = [2.5, 2.0, 4.0]


@pytest.fixture(scope="module")
def view() -> View:
    box = {"name": "box", "shape": "cube", "transform": [{"rotate_y": 30.0}]}
    wall = {"name": "wall", "shape": "square", "transform": [{"scale": 2.0}, {"rotate_x": 15.0}]}
    camera = {"type": "perspective", "eye": EYE, "far": 100.0}
    return hsr.view(Scene.model_validate({"camera": [camera], "object": [box, wall]}), (96, 96))


def drawn(view: View, right: float = 0.0, down: float = 0.0) -> VisibilityMap:
    """Draw every triangle as an object of its own, the picture shifted by some pixels."""
    scene, light = tiny.TinySceneRenderer(), tiny.TinyRenderLight(has_shadow=False)
    things = []
    for number, triangle in enumerate(view.triangles):
        corners = triangle.ravel().tolist()
        mesh = scene.create_mesh(corners, [0.0, 0.0, 1.0] * 3, [0.0] * 6, [0, 1, 2], [255] * 3, 1, 1, 1.0)
        things.append(scene.create_object_instance(mesh))
        scene.set_object_double_sided(things[-1], True)
        scene.set_object_segmentation_uid(things[-1], number + 1)
    clip_from_world = view.clip_from_world.copy()
    clip_from_world[0] += 2.0 * right / view.width * clip_from_world[3]
    clip_from_world[1] -= 2.0 * down / view.height * clip_from_world[3]
    eye_from_world = tiny.compute_view_matrix(EYE, [0.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    clip_from_eye = clip_from_world @ np.linalg.inv(np.reshape(eye_from_world, (4, 4)).T)
    camera = tiny.TinyRenderCamera(view.width, view.height, eye_from_world, clip_from_eye.T.ravel().tolist())
    picture = scene.get_camera_image(things, light, camera)
    ids = np.reshape(picture.segmentation_mask, (picture.height, picture.width))
    return from_ids(ids, view, background=0, first=1, method="tinyrenderer")


@pytest.mark.jit
def test_its_mistake_is_named(view: View) -> None:
    named = "diagnosis: lower pixel corner instead of centre: explains .* without it 0 would"
    with pytest.raises(VisibilityError, match=named):
        assert_agree({"tiny": drawn(view)}, hsr.render(view, "exact"), scene=view)


@pytest.mark.jit
def test_with_its_mistake_undone_it_is_right(visibility: Any, view: View) -> None:
    shifted = drawn(view, right=-0.5, down=0.5)
    visibility.agree({"tiny": shifted}, hsr.render(view, "exact"), scene=view)
