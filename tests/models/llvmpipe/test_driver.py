"""The model of the driver: bit for bit what it draws, and each stage where it shows."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from hsr.base.arrays import Floats, Ints
from hsr.base.errors import UnavailableError
from hsr.gl.depth import D24, DEPTH_BUFFERS, DepthBuffer
from hsr.models.llvmpipe import driver
from hsr.models.llvmpipe.driver import STAGES, Prediction, predict
from hsr.models.stages import Cause
from hsr.problem.view import View, view
from hsr.scene.model import Scene
from hsr.scene.shapes import Kind, Polygons, Shape

PARALLEL = {"type": "orthographic", "eye": [0.0, 0.0, 10.0], "height": 8.0, "near": 0.0, "far": 16.0}
"""With 8 x 8 samples: of (row r, column c) at x = c - 3.5, y = 3.5 - r."""


def scene_of(triangles: list[Floats], camera: dict[str, Any], size: tuple[int, int], cull: Any) -> View:
    """A view of meshes given by their corners (n, 3, 3)."""
    names = [f"mesh{k}" for k in range(len(triangles))]
    stand_in = {"shape": "mesh", "vertices": [[0.0, 0.0, 0.0]] * 3, "faces": [[0, 1, 2]]}
    objects = [{**stand_in, "name": name, "cull": side} for name, side in zip(names, cull, strict=True)]
    seen = view(Scene.model_validate({"camera": [camera], "object": objects}), size)
    placements, first = [], 0
    for placement, corners in zip(seen.placements, triangles, strict=True):
        polygons = Polygons.of_rows(
            np.reshape(corners, (-1, 3)).astype(np.float64), np.arange(3 * len(corners)).reshape(-1, 3)
        )
        placements.append(replace(placement, shape=Shape(Kind.MESH, "mesh", polygons), first=first))
        first += len(corners)
    return replace(seen, placements=tuple(placements))


def parallel(*triangles: Any, cull: str = "none", **camera: Any) -> View:
    return scene_of([np.array(triangles, dtype=np.float64)], PARALLEL | camera, (8, 8), [cull])


def faces(seen: View, upto: Cause) -> Ints:
    return predict(seen, upto).face


def random_view(seed: int) -> View:
    """Meshes of triangles of all sizes, some through the eye, needles and lattices among them."""
    random = np.random.default_rng(seed)
    size = [(64, 64), (97, 53), (33, 70), (1, 1)][seed % 4]
    camera: dict[str, Any] = {"type": "orthographic", "eye": [0.0, 0.0, 3.0], "height": 2.0, "far": 6.0}
    if seed % 3:
        camera = {"type": "perspective", "eye": [0.3, 0.4, 3.0], "near": 10.0 ** random.uniform(-3, 0)}
    meshes = []
    for _ in range(3):
        count = int(random.integers(1, 900))
        centre = random.normal(size=(count, 1, 3))
        spread = random.normal(size=(count, 3, 3))
        kind = random.integers(4)
        if kind == 0:
            corners = centre + spread * 10.0 ** random.uniform(-3, 4) * random.random((count, 1, 1)) ** 4
        elif kind == 1:
            along = random.normal(size=(count, 1, 3)) * random.uniform(-1, 1, (count, 3, 1))
            corners = centre + along + spread * 10.0 ** random.uniform(-7, -3, (count, 1, 1))
        elif kind == 2:
            corners = np.round((centre + 0.5 * spread) * 16) / 16
        else:
            corners = np.round(centre + spread)
        meshes.append(corners)
    cull = [str(side) for side in random.choice(["none", "back", "front"], 3)]
    return scene_of(meshes, camera, size, cull)


# ---------------------------------------------------------------- the driver


@pytest.fixture(scope="module")
def llvmpipe() -> Any:
    from hsr.gl.backends import shared_context

    try:
        context = shared_context("auto")
    except UnavailableError as error:
        pytest.skip(str(error))
    if "llvmpipe" not in context.renderer or "Mesa 22." not in context.version:
        pytest.skip(f"the model is of llvmpipe in Mesa 22, not of {context.renderer}, {context.version}")
    return context


def assert_drawn_as_predicted(seen: View, context: Any, buffer: DepthBuffer = D24) -> Prediction:
    from hsr.gl.drawing import Drawing, depth_of_window

    with Drawing(context, seen, buffer) as drawing:
        drawing.draw()
        face, depth = drawing.read()
    model = predict(seen, buffer=buffer)
    assert np.array_equal(model.face, face)
    drawn = face >= 0
    assert np.array_equal(depth_of_window(seen, model.window[drawn], buffer.reversed), depth[drawn])
    assert (model.window[~drawn] == buffer.cleared_to).all()
    return model


@pytest.mark.jit
@pytest.mark.parametrize("seed", range(48))
def test_the_last_model_is_what_the_driver_draws(seed: int, llvmpipe: Any) -> None:
    assert_drawn_as_predicted(random_view(seed), llvmpipe)


@pytest.mark.jit
@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("name", [name for name in DEPTH_BUFFERS if name != "d24"])
def test_so_it_is_in_every_depth_format(name: str, seed: int, llvmpipe: Any) -> None:
    assert_drawn_as_predicted(random_view(seed), llvmpipe, DEPTH_BUFFERS[name])


# Runs clockwise; snapped to multiples of 1/256, counter-clockwise along the samples of column 4.
TURNED = [[0.5, -3.0, 0.0], [0.5 + 0.6 / 256, 3.0, 0.0], [0.5 + 0.4 / 256, 0.0, 0.0]]
CROSSING = [[-9.0, -9.0, -1.0], [-8.0, -9.0, -1.0], [0.0, -3.9, -1.0]]


@pytest.mark.parametrize(("count", "shown"), [(341, 0), (342, 3)])
def test_a_batch_is_of_341_triangles(count: int, shown: int, llvmpipe: Any) -> None:
    nothing = [[[0.0, 0.0, 0.0]] * 3] * (count - 2)
    model = assert_drawn_as_predicted(parallel(CROSSING, *nothing, TURNED, cull="back"), llvmpipe)
    assert np.count_nonzero(model.face == count - 1) == shown


# ---------------------------------------------------------------- before anything but input rounds


def brute(seen: View) -> Ints:
    """Owners in rational arithmetic, face by face and sample by sample; ties go to left and top edges."""
    matrix = [[Fraction(float(np.float32(x))) for x in row] for row in seen.clip_from_world]
    owner = np.full((seen.height, seen.width), -1, dtype=np.int32)
    nearest: dict[tuple[int, int], Fraction] = {}
    for face, triangle in enumerate(seen.triangles.astype(np.float32)):
        corners = [[Fraction(float(x)) for x in point] + [Fraction(1)] for point in triangle]
        clip = [[sum((m * p for m, p in zip(row, point, strict=True)), Fraction(0)) for row in matrix]
                for point in corners]  # fmt: skip
        for row in range(seen.height):
            for column in range(seen.width):
                x = Fraction(2 * column + 1, seen.width) - 1
                y = 1 - Fraction(2 * row + 1, seen.height)
                z = depth_at(clip, x, y)
                best = nearest.get((row, column), Fraction(2))
                if z is not None and -1 <= z <= 1 and z < best:
                    nearest[row, column], owner[row, column] = z, face
    return owner


def depth_at(clip: list[list[Fraction]], x: Fraction, y: Fraction) -> Fraction | None:
    """Return z / w of a triangle at (x, y), None where it does not cover that."""
    weights = []
    for i in range(3):
        (ax, ay, _, aw), (bx, by, _, bw) = clip[i - 2], clip[i - 1]
        weights.append((ay * bw - aw * by, aw * bx - ax * bw, ax * by - ay * bx))
    cx, cy, _, cw = clip[0]
    determinant = weights[0][0] * cx + weights[0][1] * cy + weights[0][2] * cw
    if determinant == 0:
        return None
    z = Fraction(0)
    for (a, b, c), corner in zip(weights, clip, strict=True):
        value = (a * x + b * y + c) / determinant
        toward_right, toward_down = a / determinant, -b / determinant
        if (value, toward_right, toward_down) <= (0, 0, 0):
            return None
        z += value * corner[2]
    return z


@pytest.mark.parametrize("seed", range(12))
def test_the_first_model_is_exact_on_rounded_input(seed: int) -> None:
    random = np.random.default_rng(seed)
    camera = PARALLEL if seed % 2 else {"type": "perspective", "eye": [0.1, 0.2, 1.0], "near": 0.25}
    corners = random.normal(size=(6, 3, 3)) * [2.0, 2.0, 1.0]
    if seed % 3 == 0:
        corners = np.round(corners * 2) / 2
    seen = scene_of([corners], camera, (9, 7), ["none"])
    assert np.array_equal(faces(seen, Cause.INPUT_ROUNDING), brute(seen))


# ---------------------------------------------------------------- one stage at a time


def change(seen: View, stage: Cause, buffer: DepthBuffer = D24) -> tuple[list[list[int]], Prediction]:
    """Samples [row, column] whose owner a stage changes, and what is shown after it."""
    before, after = predict(seen, Cause(stage - 1), buffer), predict(seen, stage, buffer)
    return np.argwhere(before.face != after.face).tolist(), after


def square(z: float) -> list[list[list[float]]]:
    """Two triangles that cover everything."""
    return [
        [[-9.0, -9.0, z], [9.0, -9.0, z], [9.0, 9.0, z]],
        [[-9.0, -9.0, z], [9.0, 9.0, z], [-9.0, 9.0, z]],
    ]


def test_the_transform_loses_what_a_sum_loses() -> None:
    seen = parallel(*square(0.0), *square(2.0**-30))
    samples, after = change(seen, Cause.TRANSFORM)
    assert len(samples) == 64
    assert set(after.face.ravel()) == {0, 1}


def test_clipping_moves_an_edge_off_the_samples_it_ran_through() -> None:
    # The lower edge has slope 1/3, runs through samples, and is cut at the right side of the image.
    seen = parallel([[-3.5, -3.5, 0.0], [23.5, 5.5, 0.0], [-3.5, 30.5, 0.0]])
    samples, after = change(seen, Cause.CLIPPING)
    assert samples == [[5, 6], [6, 3]]
    assert after.face[5, 6] == after.face[6, 3] == 0


@pytest.mark.parametrize(("offset", "moved"), [(2.0**-10, True), (2.0**-8, False)])
def test_snapping_rounds_corners_to_a_grid(
    offset: float, moved: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = 0.5 + offset  # just right of the samples of column 4
    seen = parallel([[left, -3.0, 0.0], [3.0, 0.0, 0.0], [left, 3.0, 0.0]])
    samples, _ = change(seen, Cause.VERTEX_SNAPPING)
    assert samples == ([[row, 4] for row in range(1, 7)] if moved else [])
    monkeypatch.setattr(driver, "SUBPIXEL_BITS", 4)
    assert change(seen, Cause.VERTEX_SNAPPING)[0]


def test_the_fill_rule_gives_horizontal_edges_away() -> None:
    seen = parallel([[-2.5, -1.5, 0.0], [1.5, -1.5, 0.0], [-2.5, 1.5, 0.0]])
    samples, after = change(seen, Cause.FILL_RULE)
    assert samples == [[5, 1], [5, 2], [5, 3], [5, 4]]
    assert (after.face[5, 1:5] == 0).all()


def test_depth_arithmetic_does_not_draw_what_lies_on_the_far_plane() -> None:
    seen = parallel(*square(-6.0))
    samples, after = change(seen, Cause.DEPTH_ARITHMETIC)
    assert len(samples) == 64
    assert (after.face == -1).all() and (after.window == 1.0).all()


def test_the_depth_format_makes_ties_of_what_is_closer_than_its_step() -> None:
    seen = parallel(*square(9.5), *square(9.5 + 2.0**-20))  # 1 / 2**24 of the depth range, near 0
    assert set(faces(seen, Cause.DEPTH_ARITHMETIC).ravel()) == {2, 3}
    samples, after = change(seen, Cause.DEPTH_FORMAT, DEPTH_BUFFERS["d16"])
    assert len(samples) == 64
    assert set(after.face.ravel()) == {0, 1}
    assert np.array_equal(after.window * 65535, np.full((8, 8), 2048.0))


# ---------------------------------------------------------------- culling


@pytest.mark.parametrize("upto", STAGES)
def test_culling_by_the_side_a_triangle_shows(upto: Cause) -> None:
    front = [[-3.0, -3.0, 0.0], [3.0, -3.0, 0.0], [0.0, 3.0, 0.0]]
    shown = {cull: (faces(parallel(front, front[::-1], cull=cull), upto)).max() for cull in ("back", "front")}
    assert shown == {"back": 0, "front": 1}
    assert faces(parallel(front[::-1], front, cull="none"), upto).max() == 0


def test_a_clipped_batch_is_culled_before_it_is_snapped_too(monkeypatch: pytest.MonkeyPatch) -> None:
    lower_half = [[4, 4], [5, 4], [6, 4]]
    for others, batch, expected in (([], 341, lower_half), ([CROSSING], 1, lower_half), ([CROSSING], 2, [])):
        monkeypatch.setattr(driver, "BATCH", batch)
        seen = parallel(TURNED, *others, cull="back")
        assert np.argwhere(faces(seen, Cause.DEPTH_FORMAT) == 0).tolist() == expected


@pytest.mark.parametrize("upto", STAGES)
def test_nothing_is_seen_of_what_lies_behind_the_eye(upto: Cause) -> None:
    camera = {"type": "perspective", "eye": [0.0, 0.0, 0.0], "target": [0.0, 0.0, -1.0]}
    behind = np.array([[[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [0.0, 1.0, 0.0]]])
    assert (faces(scene_of([behind], camera, (8, 8), ["none"]), upto) == -1).all()


@pytest.mark.parametrize("upto", STAGES, ids=lambda stage: stage.label)
@pytest.mark.parametrize("seed", range(8))
def test_asked_about_some_samples_it_says_of_them_what_it_says_of_all(seed: int, upto: Cause) -> None:
    seen = random_view(seed)
    samples = np.random.default_rng(seed).integers(seen.width * seen.height, size=seed)
    some = predict(seen, upto, samples=samples)
    assert np.array_equal(some.face.ravel()[samples], faces(seen, upto).ravel()[samples])
