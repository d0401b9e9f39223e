"""The view: cameras, rays, placements, polygons in world space, and hashes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.arrays import Floats
from hsr.base.errors import SceneError, ViewError
from hsr.problem.view import View
from hsr.scene import shapes
from hsr.scene.model import Scene

CUBE = {"name": "box", "shape": "cube"}
BALL = {"name": "ball", "shape": "sphere"}
DRUM = {"name": "drum", "shape": "cylinder"}
PARALLEL = {"type": "orthographic", "height": 4.0, "far": 20.0}


def samples(view: View) -> tuple[Floats, Floats]:
    """Normalised device coordinates of all samples, row 0 at the top."""
    x = (2 * np.arange(view.width) + 1) / view.width - 1
    y = 1 - (2 * np.arange(view.height) + 1) / view.height
    columns, rows = np.meshgrid(x, y)
    return columns.ravel(), rows.ravel()


def with_matrix(scene: Scene, clip: Floats) -> Scene:
    table = {"type": "matrix", "name": "main", "matrix": clip.tolist()}
    return Scene.model_validate({"camera": [table], "object": [thing.model_dump() for thing in scene.object]})


# ---------------------------------------------------------------- samples and rays


@pytest.mark.parametrize(
    "camera", [{}, PARALLEL, {"up": [1.0, 1.0, 0.3], "target": [0.5, -1.0, 0.2]}, {**PARALLEL, "near": -3.0}]
)
@pytest.mark.parametrize("mirror", [1.0, -1.0])
@pytest.mark.parametrize("as_matrix", [False, True])
def test_rays_run_where_the_projection_says(
    make_scene: Any, camera: dict[str, Any], mirror: float, as_matrix: bool
) -> None:
    scene = make_scene([CUBE], **camera)
    view = hsr.view(scene, (7, 5))
    if as_matrix or mirror < 0:
        view = hsr.view(with_matrix(scene, np.diag([mirror, 1.0, 1.0, 1.0]) @ view.clip_from_world), (7, 5))
    x, y = samples(view)
    ones = np.ones_like(x)
    origin = view.rays.origin @ [ones, x, y]
    direction = view.rays.direction @ [ones, x, y]
    for depth in (0.5, 3.0, 11.0):
        points = np.vstack([origin + depth * direction, ones])
        clip_x, clip_y, _, w = view.clip_from_world @ points
        assert np.allclose(clip_x / w, x, atol=1e-14) and np.allclose(clip_y / w, y, atol=1e-14)
        assert np.allclose(view.depth_row @ points, depth, atol=1e-14)


def test_the_first_sample_is_at_the_top_left(make_scene: Any) -> None:
    view = hsr.view(make_scene([CUBE], eye=[0.0, 0.0, 5.0]), (4, 4))
    x, y = samples(view)
    assert (x[0], y[0]) == (-0.75, 0.75)
    point = view.rays.direction @ [1.0, x[0], y[0]]
    assert point[0] < 0.0 < point[1] and point[2] == pytest.approx(-1.0)


def test_rays_leave_the_eye_in_perspective_and_run_alike_in_parallel(make_scene: Any) -> None:
    perspective, parallel = (hsr.view(make_scene([CUBE], **camera), (4, 4)) for camera in ({}, PARALLEL))
    assert perspective.perspective and not parallel.perspective
    assert (
        np.allclose(perspective.rays.origin[:, 0], [0.3, 0.4, 5.0])
        and not perspective.rays.origin[:, 1:].any()
    )
    assert not parallel.rays.direction[:, 1:].any() and parallel.rays.origin[:, 1:].any()


def test_the_camera_to_look_through_is_chosen_by_name(make_scene: Any) -> None:
    scene: Scene = make_scene([CUBE])
    side = scene.camera[0].model_copy(update={"name": "side", "eye": (9.0, 0.0, 0.0)})
    two = scene.model_copy(update={"camera": (*scene.camera, side)})
    assert hsr.view(two, (4, 4)).depth_row[3] != hsr.view(two, (4, 4), camera="side").depth_row[3] == 9.0
    with pytest.raises(ViewError, match=r"^no camera is named 'top'; the scene has main, side$"):
        hsr.view(two, (4, 4), camera="top")


@pytest.mark.parametrize("size", [512, "64x64", (1, 2, 3), (2.5, 4), (float("nan"), 4), None])
def test_sizes_that_are_none(make_scene: Any, size: Any) -> None:
    with pytest.raises(ViewError, match="expected two whole numbers, "):
        hsr.view(make_scene([CUBE]), size)


@pytest.mark.parametrize("size", [(0, 4), (4, 0), (16385, 4), (4, -1)])
def test_sizes_out_of_range(make_scene: Any, size: tuple[int, int]) -> None:
    with pytest.raises(
        ViewError, match=rf"^size {size[0]}x{size[1]}: width and height must be from 1 to 16384$"
    ):
        hsr.view(make_scene([CUBE]), size)


def test_a_camera_that_cannot_be_used_is_named(make_scene: Any) -> None:
    clip = np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0.5, 0, -1.2, -2.2], [0, 0, -1.0, 0]])
    with pytest.raises(ViewError, match=r"^camera 'main': its near plane is oblique"):
        hsr.view(with_matrix(make_scene([CUBE]), clip))


# ---------------------------------------------------------------- objects and faces


def test_faces_are_numbered_in_the_order_of_the_file(make_scene: Any) -> None:
    view = hsr.view(make_scene([CUBE, BALL, DRUM, {"name": "sheet", "shape": "square"}]))
    assert view.first_faces.tolist() == [0, 6, 7, 10] and view.faces == 11
    assert view.object_of(np.array([-1, 0, 5, 6, 7, 9, 10], dtype=np.int32)).tolist() == [
        -1,
        0,
        0,
        1,
        2,
        2,
        3,
    ]
    assert [entry["name"] for entry in view.manifest] == ["box", "ball", "drum", "sheet"]
    assert view.manifest[2] == {
        "name": "drum",
        "shape": "cylinder",
        "first": 7,
        "count": 3,
        "faces": ["side", "base", "cap"],
    }


def test_copies_share_their_shape_and_have_faces_of_their_own(make_scene: Any) -> None:
    view = hsr.view(make_scene([{**CUBE, "scatter": {"count": 3, "x": [-1, 1], "z": [-1, 1]}}]))
    assert [placement.name for placement in view.placements] == ["box.0", "box.1", "box.2"]
    assert view.first_faces.tolist() == [0, 6, 12]
    assert len({id(placement.shape) for placement in view.placements}) == 1


def test_tessellated_polygons_keep_the_face_of_their_surface(make_scene: Any) -> None:
    view = hsr.view(make_scene([CUBE, BALL, DRUM]))
    assert view.curved and view.tessellated() is view.tessellated()
    flat = view.tessellated()
    assert not flat.curved and flat.faces == view.faces == 10 and flat.tessellated() is flat
    face = flat.polygons.face
    assert np.array_equal(np.unique(face), np.arange(10)) and (np.diff(face) >= 0).all()
    assert (face == 6).sum() == 48 * 2 * 23 and (face == 7).sum() == 48
    assert flat.manifest == view.manifest
    with pytest.raises(ViewError, match=r"^object 'ball' is curved; use view.tessellated\(\)$"):
        _ = view.polygons


def test_vertices_beyond_float64_in_world_space_are_refused(make_scene: Any) -> None:
    wide = {"name": "wide", "shape": "mesh", "vertices": (np.eye(3) * 1e90).tolist(), "faces": [[0, 1, 2]]}
    thing = {**wide, "transform": [{"scale": [1e220] * 3}]}
    with pytest.raises(ViewError, match=r"^object 'wide': its vertices overflow float64 in world space; "):
        _ = hsr.view(make_scene([thing])).polygons


def test_triangles_carry_the_face_of_their_polygon(make_scene: Any) -> None:
    view = hsr.view(make_scene([{"name": "sheet", "shape": "square"}, CUBE]))
    assert view.triangles.shape == (14, 3, 3)
    assert view.triangle_face.tolist() == [0, 0, *np.repeat(np.arange(1, 7), 2)]


def test_world_polygons_are_transformed(make_scene: Any) -> None:
    moved = {**CUBE, "name": "moved", "transform": [{"scale": 2}, {"translate": [10, 0, 0]}], "cull": "front"}
    polygons = hsr.view(make_scene([CUBE, moved])).polygons
    assert polygons.vertices[8:].min(axis=0).tolist() == [8, -2, -2]
    assert polygons.vertices[8:].max(axis=0).tolist() == [12, 2, 2]
    assert polygons.cull.tolist() == [0] * 6 + [2] * 6


@pytest.mark.parametrize("flip", [1.0, -1.0])
@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_fronts_run_counter_clockwise_on_the_screen(make_scene: Any, flip: float, mirror: float) -> None:
    scene = make_scene([{**CUBE, "transform": [{"scale": [flip, 1, 1]}]}], eye=[2.0, 3.0, 6.0])
    view = hsr.view(scene)
    view = hsr.view(with_matrix(scene, np.diag([mirror, 1.0, 1.0, 1.0]) @ view.clip_from_world))
    assert view.placements[0].mirrored == (flip * mirror < 0)
    corners = view.triangles @ view.clip_from_world[:, :3].T + view.clip_from_world[:, 3]
    x, y = np.moveaxis(corners[..., :2] / corners[..., 3:], 2, 0)
    area = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    toward = {"top", "front", "right" if flip > 0 else "left"}
    names = view.placements[0].shape.face_names
    assert {names[face] for face in view.triangle_face[area > 0]} == toward
    # Mirroring keeps the first corner of every loop, so the fans stay the same.
    assert np.array_equal(view.polygons.corner[view.polygons.start[:-1]], [6, 0, 5, 0, 4, 1])


def test_problems_of_python_scenes_come_with_the_view(make_scene: Any) -> None:
    with pytest.raises(SceneError, match=r"^object 'm': faces: the mesh has no faces$"):
        hsr.view(make_scene([{"name": "m", "shape": "mesh", "vertices": [], "faces": []}]))
    flat = {**CUBE, "transform": [{"scale": 1e-200}, {"scale": 1e-200}]}
    with pytest.raises(SceneError, match=r"^object 'box': the steps together over- or underflow float64"):
        hsr.view(make_scene([flat]))


def test_more_faces_than_int32_numbers(make_scene: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hsr.problem.geometry.MAX_FACES", 11)
    with pytest.raises(ViewError, match=r"^object 'b': more than 11 faces in the scene$"):
        hsr.view(make_scene([CUBE, {"name": "b", "shape": "cube"}]))
    assert shapes.MAX_FACES == 2**31 - 2


# ---------------------------------------------------------------- hashes


def hashes(
    make_scene: Any, thing: dict[str, Any] | None = None, size: tuple[int, int] = (8, 8), **camera: Any
) -> dict[str, str]:
    return hsr.view(make_scene([{**CUBE, **(thing or {})}, BALL], **camera), size).hashes


@pytest.mark.parametrize(
    ("change", "changed"),
    [
        ({}, set()),
        ({"thing": {"colour": [1, 0, 0]}}, set()),
        ({"thing": {"transform": [{"rotate_x": 0}]}}, set()),
        ({"size": (8, 9)}, {"size", "camera"}),
        ({"size": (16, 16)}, {"size"}),
        ({"fov": 46.0}, {"camera"}),
        ({"near": 0.2}, {"camera"}),
        ({"far": 100.0}, {"camera"}),
        ({"thing": {"name": "crate"}}, {"scene"}),
        ({"thing": {"cull": "back"}}, {"scene"}),
        ({"thing": {"shape": "square"}}, {"scene"}),
        ({"thing": {"transform": [{"translate": [1e-300, 0, 0]}]}}, {"scene"}),
    ],
)
def test_hashes_change_when_what_is_seen_changes_and_only_then(
    make_scene: Any, change: dict[str, Any], changed: set[str]
) -> None:
    before, after = hashes(make_scene), hashes(make_scene, **change)
    assert {key for key in before if before[key] != after[key]} == changed


def test_the_top_of_a_cylinder_counts(make_scene: Any) -> None:
    plain = hsr.view(make_scene([DRUM]))
    views = [hsr.view(make_scene([DRUM | {"top": top}])) for top in (0.0, 0.5, 1.0 - 2.0**-53, 1.0, 2.0)]
    assert len({view.hashes["scene"] for view in views}) == len(views)
    assert len({view.tessellated().hashes["scene"] for view in views}) == len(views)
    assert views[3].hashes == plain.hashes and views[3].manifest == plain.manifest
    assert views[0].manifest[0]["faces"] == ["side", "base"] and views[0].faces == 2


def test_the_order_of_objects_counts(make_scene: Any) -> None:
    one, other = (hsr.view(make_scene(things)).hashes for things in ([CUBE, BALL], [BALL, CUBE]))
    assert one["scene"] != other["scene"] and one["camera"] == other["camera"]


def test_segments_count_only_where_something_is_curved(make_scene: Any) -> None:
    for things, same in ([CUBE], True), ([CUBE, BALL], False):
        scene: Scene = make_scene(things)
        coarse = scene.model_copy(update={"segments": 12})
        assert (hsr.view(scene).hashes["scene"] == hsr.view(coarse).hashes["scene"]) == same


def test_tessellating_keeps_the_hashes_of_the_camera_and_the_size(make_scene: Any) -> None:
    view = hsr.view(make_scene([CUBE, BALL]))
    assert view.tessellated().hashes["camera"] == view.hashes["camera"]


def test_a_scene_without_a_camera_says_what_to_give() -> None:
    scene = hsr.Scene.model_validate({"object": [{"name": "box", "shape": "cube"}]})
    with pytest.raises(ViewError, match="the scene has no camera; give one"):
        hsr.view(scene)
    assert hsr.view(scene, (8, 8), hsr.Perspective(eye=(0, 0, 4))).faces == 6
