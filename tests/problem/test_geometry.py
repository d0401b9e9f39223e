"""What a scene's views share: made once, kept by the scene, freed with it."""

from __future__ import annotations

import copy
import gc
import weakref
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms.registry import method_named
from hsr.base.errors import UnavailableError, ViewError
from hsr.problem.geometry import Geometry

OBJECTS = [
    {"name": "box", "shape": "cube", "transform": [{"scale": 0.5}]},
    {"name": "ball", "shape": "sphere", "transform": [{"translate": [1.2, 0.0, 0.0]}]},
    {"name": "knot", "shape": "torus-knot", "transform": [{"scale": [-1.0, 1.0, 1.0]}]},
]
ASIDE = hsr.Perspective(eye=(3.0, 2.0, 4.0))
MIRRORING = hsr.MatrixCamera(matrix=np.diag([0.4, 0.4, 0.4, 1.0]))
ONCE = ("zbuffer", "raycast", "raycast-single", "scanline", "opengl", "embree", "embree-packets")


@pytest.fixture
def scene(make_scene: Any) -> hsr.Scene:
    made: hsr.Scene = make_scene(OBJECTS)
    return made


@pytest.mark.parametrize("name", ONCE)
@pytest.mark.parametrize("camera", [ASIDE, MIRRORING])
def test_a_second_camera_sees_what_it_would_have_seen_first(name: str, camera: Any, scene: hsr.Scene) -> None:
    other = copy.deepcopy(scene)
    try:
        hsr.render(scene, name, (9, 9))
    except UnavailableError as error:
        pytest.skip(str(error))
    seen = hsr.view(scene, (24, 18), camera)
    kept = len(seen.tessellated().geometry._made) + len(seen.geometry._made)
    second, first = hsr.render(seen, name), hsr.render(other, name, (24, 18), camera)
    assert np.array_equal(second.face, first.face) and np.array_equal(second.depth, first.depth)
    assert second.work == first.work and second.hashes == first.hashes
    if camera is ASIDE:
        assert len(seen.tessellated().geometry._made) + len(seen.geometry._made) - kept <= 1  # the hash


def test_views_share_what_does_not_depend_on_the_camera(scene: hsr.Scene) -> None:
    one, other = hsr.view(scene, (8, 8)), hsr.view(scene, (9, 9), ASIDE)
    assert one.geometry is other.geometry is scene.geometry
    assert one.tessellated().polygons is other.tessellated().polygons
    assert one.hashes["scene"] == other.hashes["scene"] and one.hashes != other.hashes
    assert replace(one, segments=12).tessellated().geometry is not one.tessellated().geometry


def test_what_a_mirroring_camera_turns_is_its_own(scene: hsr.Scene) -> None:
    seen, turned = hsr.view(scene).geometry, hsr.view(scene, camera=MIRRORING).geometry
    assert turned is hsr.view(scene, (8, 8), MIRRORING).geometry is not seen
    assert [one.mirrored for one in turned] == [not one.mirrored for one in seen]


def test_other_objects_are_another_geometry(scene: hsr.Scene) -> None:
    seen = hsr.view(scene)
    assert replace(seen, width=8).geometry is seen.geometry
    fewer = replace(seen, placements=seen.placements[:1])
    assert isinstance(fewer.placements, Geometry) and len(fewer.polygons) == 6
    alone = scene.model_copy(update={"object": scene.object[:1]})
    assert len(alone.geometry) == 1 and len(scene.geometry) == 3
    assert scene == scene.located(scene.folder) and len(copy.deepcopy(scene).geometry) == 3


def test_it_is_freed_with_the_scene(make_scene: Any) -> None:
    scene = make_scene(OBJECTS[:1])
    hsr.render(scene, "zbuffer", (8, 8))
    polygons = weakref.ref(scene.geometry.polygons)
    assert polygons() is not None
    del scene
    gc.collect()
    assert polygons() is None


def test_warming_up_prepares_nothing(scene: hsr.Scene) -> None:
    seen = hsr.view(scene, (8, 8))
    method_named("zbuffer").warm_up(seen)
    assert not seen.geometry._made


# ---------------------------------------------------------------- cameras of one's own


def test_cameras_are_made_without_their_type_and_of_arrays(scene: hsr.Scene) -> None:
    camera = hsr.Orthographic(eye=np.array([0.0, 0.0, 5.0]), height=np.float64(4.0), far=9)
    assert (camera.type, camera.name, camera.height) == ("orthographic", "main", 4.0)
    matrix = hsr.MatrixCamera(matrix=hsr.view(scene, (8, 8), camera).clip_from_world)
    assert (
        hsr.render(scene, size=(8, 8), camera=matrix).face
        == hsr.render(scene, size=(8, 8), camera=camera).face
    ).all()


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (
            lambda: hsr.Perspective(eye=(1, 2, 3), target=(1, 2, 3)),
            "camera 'main': eye and target must differ",
        ),
        (
            lambda: hsr.Perspective(name="a", eye=(0, 1, 0)),
            "camera 'a': up must not be zero nor point along the view axis",
        ),
        (lambda: hsr.Perspective(eye=(0, 1)), "camera 'main': eye: expected 3 numbers, got 2"),
        (
            lambda: hsr.Orthographic(eye=(0, 0, 1), height=-1.0, far=2.0),
            "camera 'main': height: Input should be greater than 0",
        ),
        (
            lambda: hsr.MatrixCamera(matrix=np.zeros((4, 4))),
            "camera 'main': matrix: the matrix is singular: it flattens the world",
        ),
    ],
)
def test_a_camera_that_sees_nothing_is_one_clear_line(make: Any, told: str) -> None:
    with pytest.raises(ViewError) as caught:
        make()
    assert str(caught.value) == told
