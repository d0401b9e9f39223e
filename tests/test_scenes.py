"""The built-in scenes: each can be used, is seen whole, and shows what it says it shows."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import hsr
from hsr.base.arrays import Array, Floats, Ints
from hsr.problem.view import View
from hsr.scene.info import describe
from hsr.scene.model import Scene
from tests.conftest import SCENES

FILES = sorted(SCENES.glob("*.toml"))
CAMERAS = [(path, camera.name) for path in FILES for camera in hsr.load(path).camera]
IDS = [f"{path.stem}-{name}" for path, name in CAMERAS]

ENDLESS = ("forest", "room", "terrain")
"""Scenes that go on beyond the picture."""


def scene(name: str) -> Scene:
    return hsr.load(SCENES / f"{name}.toml")


def seen(name: str, size: int = 96, camera: str | None = None) -> View:
    return hsr.view(scene(name), (size, size), camera).tessellated()


def owners(view: View, method: str = "zbuffer") -> Ints:
    return hsr.render(view, method).face


def projected(view: View) -> tuple[Floats, Array]:
    """Clip coordinates (n, 4) of all corners of triangles, and the name (n,) of the object of each."""
    corners = view.triangles.reshape(-1, 3)
    clip = corners @ view.clip_from_world[:, :3].T + view.clip_from_world[:, 3]
    names = np.array([placement.name for placement in view.placements])
    return clip, np.repeat(names[view.object_of(view.triangle_face)], 3)


# ---------------------------------------------------------------- all of them


def test_there_are_scenes_enough_and_their_titles_differ() -> None:
    titles = [hsr.load(path).title for path in FILES]
    assert len(FILES) >= 16 and len(set(titles)) == len(titles)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_scene_says_what_it_shows(path: Path) -> None:
    loaded = hsr.load(path)
    assert path.read_text(encoding="utf-8").startswith("# ")
    assert loaded.title and loaded.about.endswith(".") and 40 < len(loaded.about) < 240
    assert loaded.light and any(light.type != "ambient" for light in loaded.light)
    assert describe(loaded)["totals"]["faces"] > 0


@pytest.mark.parametrize(("path", "camera"), CAMERAS, ids=IDS)
def test_a_camera_sees_its_objects_large_and_uncut(path: Path, camera: str) -> None:
    view = hsr.view(hsr.load(path), (64, 64), camera).tessellated()
    clip, name = projected(view)
    if path.stem in ENDLESS:
        inside = (np.abs(clip[:, :3]) < clip[:, 3:]).all(axis=1)
        assert len(np.unique(name[inside])) >= len(view.placements) / 2
        return
    assert (clip[:, 3] > 0.0).all()
    ndc = clip[:, :2] / clip[:, 3:]
    assert np.abs(ndc).max() < 0.99, "cut by the frame"
    assert np.ptp(ndc, axis=0).max() > 1.7, "small"


# ---------------------------------------------------------------- what they show


@pytest.mark.jit
def test_back_face_detection_is_right_where_the_files_say_so() -> None:
    for name in ("cube", "convex-apart", "polyhedra"):
        view = seen(name)
        assert (owners(view, "backface") == owners(view)).all(), name


@pytest.mark.jit
def test_back_face_detection_is_wrong_where_the_files_say_so() -> None:
    for name in ("convex-behind", "concave", "cyclic", "interpenetrating", "near-cut", "room"):
        view = seen(name)
        assert (owners(view, "backface") != owners(view)).sum() > 20, name


@pytest.mark.jit
def test_the_beams_hide_one_another_in_a_circle() -> None:
    cyclic = scene("cyclic")
    before = set()
    for pair in combinations(range(3), 2):
        both = cyclic.model_copy(update={"object": tuple(cyclic.object[k] for k in pair)})
        view = hsr.view(both, (96, 96))
        alone = [hsr.view(cyclic.model_copy(update={"object": (cyclic.object[k],)}), (96, 96)) for k in pair]
        crossing = np.logical_and(*[owners(single) >= 0 for single in alone])
        (front,) = np.unique(view.object_of(owners(view)[crossing]))
        before.add((pair[front], pair[1 - front]))
    assert before in ({(0, 1), (1, 2), (2, 0)}, {(1, 0), (2, 1), (0, 2)})


def test_no_square_of_the_interpenetrating_three_is_before_another_everywhere() -> None:
    planes = [view.triangles.reshape(-1, 3) for view in _each_object_of("interpenetrating")]
    for one, other in combinations(planes, 2):
        normal = np.cross(one[1] - one[0], one[2] - one[0])
        side = (other - one[0]) @ normal
        assert side.min() < 0.0 < side.max()


def _each_object_of(name: str) -> list[View]:
    whole = scene(name)
    return [hsr.view(whole.model_copy(update={"object": (thing,)})) for thing in whole.object]


@pytest.mark.jit
def test_the_near_plane_cuts_all_three_solids_and_shows_their_insides() -> None:
    view = seen("near-cut")
    clip, name = projected(view)
    for solid in ("shell", "box", "kernel"):
        depth = clip[name == solid, 3]
        assert depth.min() < view.near < depth.max(), solid
    assert set(np.unique(view.object_of(owners(view)))) == {-1, 0, 1, 2}


def test_the_sheets_lie_exactly_in_one_plane_and_overlap() -> None:
    view = seen("coplanar")
    assert (view.triangles[:, :, 2] == 0.0).all()
    sheets = view.triangles.reshape(4, 6, 3)
    for one, other in combinations(sheets, 2):
        low = np.maximum(one.min(axis=0), other.min(axis=0))[:2]
        high = np.minimum(one.max(axis=0), other.max(axis=0))[:2]
        assert (low < high).all()


def test_the_mirror_image_is_wound_the_other_way() -> None:
    mirrored = {placement.name: placement.mirrored for placement in seen("mirrored").placements}
    assert mirrored == {"knot": False, "mirror-image": True, "sheared-cube": False, "sheared-ball": False}
    assert {placement.cull for placement in seen("mirrored").placements} == {1}


def test_the_forest_has_more_than_half_a_million_triangles() -> None:
    assert len(seen("forest").triangle_face) >= 500_000


@pytest.mark.jit
def test_the_mirrored_knot_is_not_seen_inside_out() -> None:
    """With and without culling, the closed knots look the same."""
    culled = scene("mirrored")
    bare = tuple(thing.model_copy(update={"cull": "none"}) for thing in culled.object)
    free = hsr.view(culled.model_copy(update={"object": bare}), (96, 96)).tessellated()
    assert (owners(seen("mirrored")) == owners(free)).all()


@pytest.mark.jit
@pytest.mark.parametrize("name", [path.stem for path in FILES if path.stem not in ("coplanar", "forest")])
def test_no_sample_is_a_tie_by_accident(name: str) -> None:
    """The depth buffer and the ray caster round differently, and agree all the same."""
    view = seen(name, 64)
    assert (owners(view) == owners(view, "raycast")).all()


def test_the_numbers_that_the_texts_name_are_true() -> None:
    for name, faces in (("teapot", "16,256"), ("terrain", "131,072"), ("menger", "18,048")):
        assert faces in scene(name).about
        assert describe(scene(name))["objects"][0]["faces"] == int(faces.replace(",", ""))
    firs = describe(scene("forest"))["objects"][1:]
    assert sum(fir["copies"] for fir in firs) == 520 and {fir["faces"] for fir in firs} == {1308}
