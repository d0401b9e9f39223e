"""The certified depth buffer: who owns a sample on an edge, and that rounding decides nothing."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms import zbuffer
from hsr.base.errors import ViewError
from hsr.exact.oracle import truth
from hsr.kernels.projection import clip_rows
from hsr.kernels.zbuffer.setup import LANES, TIE
from hsr.kernels.zbuffer.tiles import COLUMNS, LINES
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View, view
from tests.conftest import JIT
from tests.exact.adversarial import adversarial
from tests.exact.extreme import EXTREME, extreme
from tests.exact.hard import scene

SEEDS = 240 if JIT else 40


def on_image(
    corners: list[list[float]], triangles: list[list[int]], size: tuple[int, int] = (4, 4), cull: str = "none"
) -> View:
    """A parallel view whose world is the image: x right and y *down* in pixels, depth 10 (1 + z)."""
    points = np.array(corners, float)
    points = np.column_stack([points, np.zeros(len(points))]) if points.shape[1] == 2 else points
    vertices = np.column_stack([points[:, 0], -points[:, 1], -10.0 * points[:, 2]])
    thing = {"shape": "mesh", "vertices": vertices.tolist(), "faces": triangles, "cull": cull}
    eye = [size[0] / 2, -size[1] / 2, 10.0]
    camera = {"type": "orthographic", "eye": eye, "target": [*eye[:2], 0.0], "height": float(size[1])}
    return view(scene([thing], {**camera, "near": 10.0, "far": 20.0}), size)


def owners(*arguments: Any, **options: Any) -> list[list[int]]:
    return rendered(on_image(*arguments, **options)).face.tolist()


def rendered(view: View, certified: bool = True) -> VisibilityMap:
    return zbuffer.render(view, zbuffer.Options(certified))


# ---------------------------------------------------------------- who owns a sample

# The corners of a square whose sides pass through pixel centres.
SQUARE = [[0.5, 0.5], [2.5, 0.5], [2.5, 2.5], [0.5, 2.5]]


@pytest.mark.parametrize(
    ("triangles", "expected"),
    [
        ([[0, 1, 2], [0, 2, 3]], [[0, 0, -1, -1], [1, 0, -1, -1], [-1, -1, -1, -1], [-1] * 4]),
        ([[0, 1, 3], [1, 2, 3]], [[0, 0, -1, -1], [0, 1, -1, -1], [-1, -1, -1, -1], [-1] * 4]),
    ],
)
@pytest.mark.parametrize("turned", [False, True])
def test_top_left_rule(triangles: list[list[int]], expected: list[list[int]], turned: bool) -> None:
    wound = [list(reversed(corners)) for corners in triangles] if turned else triangles
    assert owners(SQUARE, wound) == expected


def test_a_lattice_of_shared_edges_is_owned_by_the_cell_to_the_right_and_below() -> None:
    n = 6
    corners = [[x + 0.5, y + 0.5] for y in range(n + 1) for x in range(n + 1)]
    cells = [
        [y * (n + 1) + x, y * (n + 1) + x + 1, (y + 1) * (n + 1) + x + 1, (y + 1) * (n + 1) + x]
        for y in range(n)
        for x in range(n)
    ]
    halves = [half for a, b, c, d in cells for half in ([a, c, d], [a, b, c])]
    assert (np.array(owners(corners, halves, (n, n))) // 2).tolist() == np.arange(n * n).reshape(
        n, n
    ).tolist()


def test_nearer_wins_in_either_order() -> None:
    near, far = ([[-9, -9, z], [30, -9, z], [-9, 30, z]] for z in (0.25, 0.75))
    assert owners(near + far, [[0, 1, 2], [3, 4, 5]]) == [[0] * 4] * 4
    assert owners(far + near, [[0, 1, 2], [3, 4, 5]]) == [[1] * 4] * 4


def test_of_two_in_one_plane_the_lower_face_wins() -> None:
    same = [[-9, -9, 0.3], [30, -9, 0.6], [-9, 30, 0.9]]
    answer = rendered(on_image(same + same, [[3, 4, 5], [0, 1, 2]]))
    assert (answer.face == 0).all() and answer.work["uncertain"] == 16


def test_two_planes_that_cross_at_samples_part_there_to_the_right() -> None:
    rising, level = ([[-9, -9, a], [9, -9, b], [-9, 30, a]] for a, b in ((0.1, 0.9), (0.5, 0.5)))
    # They cross at x = 0; moved by half a pixel, at the samples of column 1.
    moved = [[x + 1.5, y, z] for x, y, z in rising + level]
    assert owners(moved, [[0, 1, 2], [3, 4, 5]]) == [[0, 1, 1, 1]] * 4


@pytest.mark.parametrize("z", [0.0, 1.0])
def test_near_and_far_are_closed(z: float) -> None:
    assert owners([[-9, -9, z], [30, -9, z], [-9, 30, z]], [[0, 1, 2]]) == [[0] * 4] * 4
    beyond = np.nextafter(z, 9.0 if z else -9.0)
    assert owners([[-9, -9, beyond], [30, -9, beyond], [-9, 30, beyond]], [[0, 1, 2]]) == [[-1] * 4] * 4


@pytest.mark.parametrize(("cull", "drawn"), [("none", True), ("back", False), ("front", True)])
def test_clockwise_is_a_back_face(cull: str, drawn: bool) -> None:
    clockwise = [[-9, -9], [30, -9], [-9, 30]]  # y down
    assert (owners(clockwise, [[0, 1, 2]], cull=cull)[0][0] == 0) == drawn
    assert (owners(clockwise, [[0, 2, 1]], cull=cull)[0][0] == 0) == (cull != "front")


@pytest.mark.parametrize(
    "corners",
    [
        [[0, 0], [4, 4], [2, 2]],
        [[1, 1], [1, 1], [3, 3]],
        [[0.6, 0.6], [0.9, 0.6], [0.6, 0.9]],
        [[9, 9], [12, 9], [9, 12]],
    ],
    ids=["collinear", "repeated corner", "between samples", "off the image"],
)
def test_what_covers_no_sample_shows_nothing(corners: list[list[float]]) -> None:
    assert owners(corners, [[0, 1, 2]]) == [[-1] * 4] * 4


def test_tiles_and_lanes_leave_no_trace() -> None:
    size = (COLUMNS + LANES + 3, LINES + 5)
    seen = on_image([[1, 2, 0.1], [529, 20, 0.9], [3, 66, 0.4]], [[0, 1, 2]], size)
    assert np.array_equal(rendered(seen).face, truth(seen).face)


# ---------------------------------------------------------------- against the truth


@pytest.mark.parametrize("share", range(8))
def test_adversarial_views_are_right_at_every_sample(share: int) -> None:
    for seed in range(share, SEEDS, 8):
        seen = adversarial(seed)
        answer, exact = rendered(seen), truth(seen)
        assert np.array_equal(answer.face, exact.face), f"seed {seed}"
        shown = exact.face >= 0
        assert answer.depth[shown] == pytest.approx(exact.depth[shown], rel=1e-5, abs=1e-12), f"seed {seed}"


@pytest.mark.parametrize("name", EXTREME)
def test_extreme_numbers_are_right_at_every_sample(name: str) -> None:
    seen = EXTREME[name]().tessellated()
    answer = rendered(seen)
    assert np.array_equal(answer.face, truth(seen).face)
    depths = answer.depth[answer.face >= 0]
    assert (depths < np.inf).all() and (depths >= 0.999 * seen.near).all()


def test_extreme_views_are_right_at_every_sample() -> None:
    shown, refused = 0, 0
    for seed in range(SEEDS):
        seen = extreme(seed).tessellated()
        try:
            answer = rendered(seen)
        except ViewError:
            refused += 1
            continue
        assert np.array_equal(answer.face, truth(seen).face), f"seed {seed}"
        shown += (answer.face >= 0).sum()
    assert shown > 10 * SEEDS and refused < 0.05 * SEEDS


@pytest.mark.jit
@pytest.mark.parametrize("name", ["coplanar", "near-cut", "mirrored", "cyclic", "room", "solids", "terrain"])
def test_scenes_are_right_at_every_sample(name: str, scenes: Any) -> None:
    seen = hsr.view(hsr.load(scenes / f"{name}.toml"), (80, 64))
    assert np.array_equal(rendered(seen).face, hsr.render(seen.tessellated(), "exact").face)


@pytest.mark.jit
@pytest.mark.parametrize("method", ["zbuffer", "raycast"])
@pytest.mark.parametrize("name", ["teapot", "terrain", "torus-knot", "engineering"])
def test_depths_are_as_exact_as_stated(name: str, method: str, scenes: Any) -> None:
    """Within 2^-35 of the range of what is seen: in a parallel view of depths, else of their inverses."""
    for camera in hsr.load(scenes / f"{name}.toml").camera:
        seen = hsr.view(hsr.load(scenes / f"{name}.toml"), (96, 80), camera.name).tessellated()
        eye = zbuffer.eye_of(seen, zbuffer.clusters_of(seen), clip_rows(seen.clip_from_world, seen.depth_row))
        assert eye.tie == TIE
        answer, exact = hsr.render(seen, method), truth(seen)
        shown = exact.face >= 0
        near, true = answer.depth[shown], exact.depth[shown]
        off = 1.0 / near - 1.0 / true if seen.perspective else near - true
        assert np.abs(off).max() <= 2.0**-35 * (eye.closest - eye.farthest)


def test_more_doubts_than_room_are_all_decided(monkeypatch: pytest.MonkeyPatch, scenes: Any) -> None:
    seen = hsr.view(hsr.load(scenes / "coplanar.toml"), (24, 24))
    expected = rendered(seen)
    monkeypatch.setattr(zbuffer, "ROOM", 1)
    again = rendered(seen)
    assert np.array_equal(again.face, expected.face) and np.array_equal(again.depth, expected.depth)
    assert again.work == expected.work and expected.work["uncertain"] > 100


def test_left_alone_ties_go_where_they_seem_to_be() -> None:
    plain = rendered(on_image(SQUARE, [[0, 1, 2], [0, 2, 3]]), certified=False)
    assert (plain.face[:3, :3] >= 0).all() and plain.work["uncertain"] == 0


def test_hidden_clusters_are_not_looked_into() -> None:
    n = 24
    x, y = (grid.ravel().tolist() for grid in np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0)))
    cell = [j * (n + 1) + i for j in range(n) for i in range(n)]
    behind = [[px, py, 0.9 + 0.01 * (px == py)] for px, py in zip(x, y, strict=True)]
    wall = [[-9.0, -9.0, 0.1], [99.0, -9.0, 0.1], [-9.0, 99.0, 0.1]]
    triangles = [[0, 1, 2]] + [[3 + a, 3 + a + 1, 3 + a + n + 1] for a in cell]
    alone = rendered(on_image(wall + behind, triangles[1:], (n, n)))
    answer = rendered(on_image(wall + behind, triangles, (n, n)))
    assert (answer.face == 0).all() and answer.work["clusters_hidden"] > 0
    assert answer.work["triangles_drawn"] < alone.work["triangles_drawn"]


# ---------------------------------------------------------------- the same bits everywhere

SHOWN = """
import json, hsr
from tests.exact.adversarial import adversarial
maps = [hsr.render(adversarial(seed), "zbuffer") for seed in (1, 2, 3, 5, 6, 7)]
print(json.dumps([[m.face.tolist(), m.depth.tobytes().hex(), m.work] for m in maps]))
"""


@pytest.mark.jit
@pytest.mark.parametrize("setting", [{"NUMBA_NUM_THREADS": "1"}, {"NUMBA_DISABLE_JIT": "1"}], ids=str)
def test_threads_and_compiler_leave_no_trace(setting: dict[str, str]) -> None:
    """Bit for bit the same, faces, depths and counts."""
    here = [hsr.render(adversarial(seed), "zbuffer") for seed in (1, 2, 3, 5, 6, 7)]
    run = subprocess.run(
        [sys.executable, "-c", SHOWN],
        env={**os.environ, **setting},
        capture_output=True,
        text=True,
        check=True,
    )
    for mine, (face, depth, work) in zip(here, json.loads(run.stdout), strict=True):
        assert mine.face.tolist() == face and mine.depth.tobytes().hex() == depth and mine.work == work
