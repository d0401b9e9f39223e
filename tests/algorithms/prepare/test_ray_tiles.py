"""Certified tiles of rays: the true face at every sample, whatever is looked at."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms import raycast
from hsr.algorithms.prepare import ray_tiles
from hsr.difference.cause import causes
from hsr.exact.oracle import truth
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View, view
from tests.conftest import JIT
from tests.exact import brute
from tests.exact.adversarial import adversarial
from tests.exact.cones import CONES
from tests.exact.extreme import EXTREME, extreme
from tests.exact.hard import scene

SEEDS = 240 if JIT else 32


def seeds_of(what: dict[str, bool]) -> int:
    """How many views there are: of curved shapes, which take longer, fewer; the long run has thousands."""
    return SEEDS // 3 if what else SEEDS


def cast(view: View, certified: bool = True) -> VisibilityMap:
    return raycast.render(view, raycast.Options(certified=certified))


def check(seen: View) -> VisibilityMap:
    """Return the map of a view after comparing it with the truth."""
    answer, exact = cast(seen), truth(seen)
    assert np.array_equal(answer.face, exact.face)
    shown = exact.face >= 0
    assert answer.depth[shown] == pytest.approx(exact.depth[shown], rel=1e-5, abs=1e-12)
    assert np.isinf(answer.depth[~shown]).all()
    return answer


@pytest.mark.parametrize("what", [{}, {"curved": True}, {"cones": True}], ids=["planar", "curved", "cones"])
@pytest.mark.parametrize("share", range(8))
def test_adversarial_views_are_right_at_every_sample(share: int, what: dict[str, bool]) -> None:
    for seed in range(share, seeds_of(what), 8):
        check(adversarial(seed, **what))


@pytest.mark.parametrize("name", EXTREME)
def test_extreme_numbers_are_right_at_every_sample(name: str) -> None:
    check(EXTREME[name]())


@pytest.mark.parametrize("what", [{}, {"curved": True}, {"cones": True}], ids=["planar", "curved", "cones"])
def test_extreme_views_are_right_at_every_sample(what: dict[str, bool]) -> None:
    for seed in range(seeds_of(what)):
        seen = extreme(seed, **what)
        assert np.array_equal(cast(seen).face, truth(seen).face), f"seed {seed}"


@pytest.mark.jit
def test_scenes_are_right_at_every_sample(scenes: Any) -> None:
    for path in sorted(scenes.glob("*.toml")):
        loaded = hsr.load(path)
        for camera in loaded.camera:
            seen = hsr.view(loaded, (48, 40), camera.name)
            answer = check(seen)
            if not seen.curved:
                assert np.array_equal(answer.face, hsr.render(seen, "zbuffer").face), path.name


@pytest.mark.parametrize("name", CONES)
def test_cones_are_right_at_every_sample(name: str) -> None:
    seen = CONES[name]
    answer = check(seen)
    assert answer.face.tolist() == brute.over_all(seen, brute.owner)
    flat = seen.tessellated()
    assert np.array_equal(hsr.render(flat, "zbuffer").face, truth(flat).face)


# ---------------------------------------------------------------- who owns a sample

ABOVE = {"type": "orthographic", "eye": [0.0, 0.0, 8.0], "height": 8.0, "near": 1.0, "far": 20.0}
"""Samples at -3.5, -2.5, ..., 3.5 if the image is 8 x 8."""


def test_whole_numbers_of_64_bits_stay_whole() -> None:
    eye = {"type": "orthographic", "eye": [0, 0, 5], "height": 4.0, "near": 1.0, "far": 9.0}
    for scale in ([2.0**25, 2.0**25, 1.0], [2.0**-25, 1.0, 1.0]):
        ball = {"name": "ball", "shape": "sphere", "transform": [{"scale": scale}]}
        check(view(hsr.Scene.model_validate({"hsr": 1, "camera": [eye], "object": [ball]}), (8, 8)))


def above(*objects: dict[str, Any], side: int = 8, **camera: Any) -> View:
    return view(scene(list(objects), ABOVE | {"target": [0.0, 0.0, 0.0]} | camera), (side, side))


AT_SAMPLES = [{"scale": 2.0}, {"translate": [0.5, 0.5, 0.0]}]
"""A unit circle then runs through the samples in row 3, columns 2 and 6, and column 4, rows 1 and 5."""


def test_the_border_of_a_square_belongs_to_it_where_the_limit_runs_into_it() -> None:
    expected = np.full((8, 8), -1)
    expected[2:5, 2:5] = 0
    assert check(above({"shape": "square", "transform": [{"scale": 1.5}]})).face.tolist() == expected.tolist()


def test_the_outline_of_a_sphere_belongs_to_it_where_the_limit_runs_into_it() -> None:
    """Of the samples on the outline only the leftmost does: moved to the right, the others leave the disc."""
    face = check(above({"shape": "sphere", "transform": AT_SAMPLES})).face
    assert (face[3, 2], face[3, 6], face[1, 4], face[5, 4]) == (0, -1, -1, -1)
    assert (face[3, 3:6] == 0).all()


def test_a_cylinder_along_the_lines_of_sight_shows_its_cap_alone() -> None:
    answer = check(above({"shape": "cylinder", "transform": AT_SAMPLES}))
    assert set(answer.face.ravel().tolist()) == {-1, 2} and answer.face[3, 2] == 2
    assert answer.work["uncertain"] == 4


def test_the_rim_of_a_cylinder_has_one_owner() -> None:
    answer = check(above({"shape": "cylinder", "transform": [{"rotate_x": 90.0}, {"scale": 1.5}]}))
    assert 0 in answer.face


@pytest.mark.parametrize("cull", ["none", "back", "front"])
@pytest.mark.parametrize("shape", ["square", "cube", "sphere", "cylinder"])
@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_culling_and_mirrors(shape: str, cull: str, mirror: float) -> None:
    turned = [{"scale": [mirror, 1.0, 0.7]}, {"rotate_x": 35.0}, {"rotate_y": 20.0}]
    check(above({"shape": shape, "cull": cull, "transform": turned}))


@pytest.mark.parametrize("plane", ["near", "far"])
@pytest.mark.parametrize("shape", ["cube", "sphere", "cylinder"])
@pytest.mark.parametrize("depth", [7.0, 7.5, 8.0])
def test_near_and_far_are_closed_and_cut_solids_open(shape: str, plane: str, depth: float) -> None:
    check(above({"shape": shape}, **{plane: depth}))


EYES = {
    "before": [0.0, 0.0, 3.0],
    "on the surface": [0.0, 0.0, 1.0],
    "next to the surface": [0.0, 0.0, 1.0 + 2.0**-52],
    "inside": [0.1, 0.2, 0.3],
    "in the middle": [0.0, 0.0, 0.0],
    "in the plane of the base": [2.0, 0.0, 0.0],
    "behind": [0.0, 0.0, -3.0],
    "far away": [0.0, 0.0, 1e9],
}


@pytest.mark.parametrize("eye", EYES)
@pytest.mark.parametrize("shape", ["sphere", "cylinder", "cube"])
def test_any_place_of_the_eye(shape: str, eye: str) -> None:
    x, y, z = EYES[eye]
    camera = {"type": "perspective", "eye": [x, y, z], "near": 2.0**-20, "fov": 60.0 if z < 1e8 else 1e-7}
    towards = {"target": [0.5 * x - 1.0, y, z] if eye == "in the plane of the base" else [x, y, z - 1.0]}
    answer = check(view(scene([{"shape": shape}], camera | towards), (13, 11)))
    assert (answer.face >= 0).any() or eye == "behind" or (shape, eye) == ("cylinder", "in the middle")


@pytest.mark.parametrize("steps", [[1.0, 1.0, 2.0**-30], [1.0, 2.0**30, 1.0], [2.0**-40] * 3])
@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
def test_ill_conditioned_transforms(shape: str, steps: list[float]) -> None:
    turned = [{"scale": steps}, {"rotate_x": 50.0}, {"rotate_y": 20.0}]
    check(above({"shape": shape, "transform": turned}))


def test_a_huge_far_sphere_and_a_tiny_near_one() -> None:
    planet = {"shape": "sphere", "transform": [{"scale": 6.4e6}, {"translate": [0.0, -6.4e6, 0.0]}]}
    ball = {"shape": "sphere", "transform": [{"scale": 1e-3}, {"translate": [0.0, 1.0, -1.0]}]}
    camera = {"type": "perspective", "eye": [0.0, 1.0, 0.0], "target": [0.0, 1.0, -1.0], "near": 1e-3}
    assert set(check(view(scene([planet, ball], camera | {"far": 1e8}), (41, 41))).face.ravel()) == {-1, 0, 1}


# ---------------------------------------------------------------- doubts, batches, work


@pytest.mark.parametrize("curved", [False, True], ids=["planar", "curved"])
def test_batches_and_room_leave_no_trace(curved: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    views = [adversarial(seed, curved) for seed in range(0, SEEDS // 4)]
    expected = [cast(seen) for seen in views]
    monkeypatch.setattr(ray_tiles, "BATCH", 1)
    monkeypatch.setattr(ray_tiles, "ROOM", 1)
    for seen, whole in zip(views, expected, strict=True):
        answer = cast(seen)
        assert np.array_equal(answer.face, whole.face) and np.array_equal(answer.depth, whole.depth)
        assert answer.work["uncertain"] == whole.work["uncertain"]


def test_a_later_batch_may_hide_what_an_earlier_one_left_in_doubt(monkeypatch: pytest.MonkeyPatch) -> None:
    """The diagonal of the slope runs through samples; the board comes later, but is nearer to the right."""
    corners = [[-4.0, -4.0, 4.0], [4.0, -4.0, -4.0], [4.0, 4.0, -4.0], [-4.0, 4.0, 4.0]]
    slope = {"shape": "mesh", "vertices": corners, "faces": [[0, 1, 2], [0, 2, 3]]}
    board = {"shape": "square", "transform": [{"scale": 1.2}, {"translate": [2.1, 2.2, 0.0]}]}
    monkeypatch.setattr(ray_tiles, "BATCH", 1)
    answer = check(above(slope, board))
    assert (np.diag(answer.face[:, ::-1])[:4] == [0, 2, 2, 0]).all()
    assert answer.work["uncertain"] == 6


@pytest.mark.jit
def test_what_is_behind_earlier_batches_is_not_walked(monkeypatch: pytest.MonkeyPatch) -> None:
    wall = {"shape": "square", "transform": [{"scale": 9.0}, {"translate": [0.3, 0.1, 2.0]}]}
    balls = {"shape": "sphere", "transform": [{"translate": [0.0, 0.0, -9.0]}]}
    hidden = {"shape": "teapot", "transform": [{"translate": [0.0, 0.0, -2.0]}]}
    alone, behind = above(hidden, side=16), above(wall, balls, hidden, side=16)
    for batch in (ray_tiles.BATCH, 1):
        monkeypatch.setattr(ray_tiles, "BATCH", batch)
        answer = check(behind)
        assert (answer.face == 0).all()
        assert answer.work["nodes visited"] == 1 < cast(alone).work["nodes visited"]


def test_a_hierarchy_is_built_once_a_shape() -> None:
    thing = {"shape": "polyhedron", "vertices": [*np.eye(3).tolist(), [0.0, 0.0, 0.0]]}
    thing["faces"] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]
    mirrored = thing | {"transform": [{"scale": [-1.0, 1.0, 1.0]}]}
    seen = above(thing, mirrored, thing)
    shapes = {placement.shape for placement in seen.placements}
    assert len(shapes) == 1 and len(ray_tiles.hierarchies_of(seen.geometry)) == 2


def test_left_alone_rounding_decides_and_is_explained() -> None:
    wrong = 0
    for seed in (3, 7, 12, 20, 23, 37, 45):
        seen = adversarial(seed, True)
        plain = cast(seen, certified=False)
        assert plain.work["uncertain"] == 0
        found = causes(seen, hsr.render(seen, "raycast-plain"), hsr.render(seen, "exact"))
        assert found.unexplained == 0 and found.reproduced
        assert causes(seen, hsr.render(seen, "raycast"), hsr.render(seen, "exact")).wrong == 0
        wrong += found.wrong
    assert wrong > 0


# ---------------------------------------------------------------- the same bits everywhere

SHOWN = """
import json, hsr
from tests.exact.adversarial import adversarial
maps = [hsr.render(adversarial(seed, True), "raycast") for seed in (1, 2, 3, 5, 6, 7, 8)]
print(json.dumps([[m.face.tolist(), m.depth.tobytes().hex(), m.work] for m in maps]))
"""


@pytest.mark.jit
@pytest.mark.parametrize("setting", [{"NUMBA_NUM_THREADS": "1"}, {"NUMBA_DISABLE_JIT": "1"}], ids=str)
def test_threads_and_compiler_leave_no_trace(setting: dict[str, str]) -> None:
    command = [sys.executable, "-W", "error", "-c", SHOWN]
    shown = subprocess.run(command, env=os.environ | setting, capture_output=True, text=True, check=True)
    maps = [hsr.render(adversarial(seed, True), "raycast") for seed in (1, 2, 3, 5, 6, 7, 8)]
    assert json.loads(shown.stdout) == [[m.face.tolist(), m.depth.tobytes().hex(), m.work] for m in maps]
