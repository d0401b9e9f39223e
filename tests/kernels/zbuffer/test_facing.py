"""Clusters that turn away are left out, and no others."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms.zbuffer import clusters_of
from hsr.kernels.projection import clip_rows
from hsr.kernels.zbuffer import facing
from hsr.problem.view import CULL, View
from tests.conftest import JIT


def culled(view: View, cull: str) -> View:
    flat = view.tessellated()
    return replace(flat, placements=tuple(replace(p, cull=CULL[cull]) for p in flat.placements))


def left_out(view: View) -> Any:
    """Which clusters of a view are left out."""
    clusters, extent = (
        clusters_of(view),
        np.tile([0.0, 1.0, 0.0, 1.0, 1.5], (clusters_of(view).low.shape[1], 1)),
    )
    assert clusters.normals is not None
    form = facing.determinant_of(view.perspective, clip_rows(view.clip_from_world, view.depth_row))
    with np.errstate(all="ignore"):
        facing.leave_out(
            (clusters.low, clusters.high), clusters.normals, clusters.culls, clusters.slack, form, extent
        )
    return extent[:, 1] <= extent[:, 0]


def turns(view: View) -> list[int]:
    """The sides that the triangles of the fans show, exactly: 1 the front, -1 the back."""
    rows = [[Fraction(float(x)) for x in view.clip_from_world[k]] for k in (0, 1, 3)]
    points = []
    for placement in view.placements:
        matrix = [[Fraction(float(x)) for x in row] for row in placement.world_from_object]
        polygons: Any = placement.shape.polygons
        for vertex in polygons.vertices:
            p = [Fraction(float(x)) for x in vertex] + [Fraction(1)]
            world = [sum(m * q for m, q in zip(row, p, strict=True)) for row in matrix]
            points.append([sum(c * q for c, q in zip(row, world, strict=True)) for row in rows])
    found = []
    for i, j, k in view.polygons.triangle_vertex:
        (a, b, c), (d, e, f), (g, h, w) = points[i], points[j], points[k]
        found.append(int(np.sign(a * (e * w - f * h) - b * (d * w - f * g) + c * (d * h - e * g))))
    return found


def patch(seed: int) -> View:
    """A rough patch of 8 triangles, seen all but edge-on."""
    random = np.random.default_rng(seed)
    x, y = (axis.ravel()[:, None] for axis in np.meshgrid([-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]))
    frame = np.eye(3) if random.random() < 0.5 else np.linalg.qr(random.normal(size=(3, 3)))[0]
    right, up, forward = frame
    eye = random.normal(size=3) * 10.0 ** random.integers(-2, 5)
    rough, tilt, aside = random.choice([-1.0, 0.0, 1.0], 3) * 10.0 ** random.uniform(-18.0, 0.0, 3)
    height = aside + y * tilt + rough * random.normal(size=(9, 1))
    vertices = eye + (5.0 + y) * forward + x * right + height * up
    faces = [face for k in (0, 1, 3, 4) for face in ([k, k + 1, k + 4], [k, k + 4, k + 3])]
    kind = str(random.choice(["perspective", "orthographic"]))
    lens = {"fov": 50.0} if kind == "perspective" else {"height": 3.0}
    place = {"eye": eye.tolist(), "target": (eye + forward + 0.2 * random.normal(size=3)).tolist()}
    camera = {"type": kind, "near": 1.0, "far": 9.0, **place, **lens}
    thing = {"name": "patch", "shape": "mesh", "vertices": vertices.tolist(), "faces": faces}
    return hsr.view(hsr.Scene.model_validate({"hsr": 1, "camera": [camera], "object": [thing]}), (8, 8))


@pytest.mark.parametrize("cull", ["back", "front"])
def test_what_is_left_out_is_culled(cull: str) -> None:
    hidden, asked = (-1 if cull == "back" else 1), 0
    for seed in range(400 if JIT else 60):
        view = culled(patch(seed), cull)
        out = left_out(view)
        assert len(out) == 1
        if out[0]:
            assert all(turn == hidden for turn in turns(view)), f"seed {seed}"
            asked += 1
    assert asked > (60 if JIT else 6)


@pytest.mark.parametrize("cull", ["back", "front"])
@pytest.mark.parametrize("camera", ["perspective", "orthographic"])
def test_of_a_ball_much_is_left_out(cull: str, camera: str) -> None:
    lens = {"fov": 30.0} if camera == "perspective" else {"height": 3.0}
    eye: dict[str, Any] = {
        "type": camera,
        "eye": [0, 0, 9],
        "target": [0, 0, 0],
        "near": 1,
        "far": 20,
        **lens,
    }
    ball = {"name": "ball", "shape": "sphere"}
    view = culled(
        hsr.view(hsr.Scene.model_validate({"hsr": 1, "camera": [eye], "object": [ball]}), (64, 64)), cull
    )
    out = left_out(view)
    assert 0.25 < out.mean() < 0.6


def test_clusters_of_both_kinds_are_looked_into() -> None:
    view = culled(patch(3), "back")
    mixed = clusters_of(view)._replace(culls=np.zeros(len(clusters_of(view).culls), np.int8))
    extent = np.ones((len(mixed.culls), 5))
    extent[:, 0] = 0.0
    form = facing.determinant_of(view.perspective, clip_rows(view.clip_from_world, view.depth_row))
    assert mixed.normals is not None
    facing.leave_out((mixed.low, mixed.high), mixed.normals, mixed.culls, mixed.slack, form, extent)
    assert (extent[:, 1] == 1.0).all()


def test_normals_that_are_not_certain_bound_nothing() -> None:
    vertices = np.array([[0.0, 1.0, 2.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    for scale in (1.0, 1e200, 1e-200):
        low, high = np.empty((3, 1)), np.empty((3, 1))
        with np.errstate(all="ignore"):
            facing.normal_boxes(scale * vertices, np.array([[0, 1, 2]], np.int32), np.zeros(3), low, high)
        assert (low == -np.inf).all() and (high == np.inf).all()


@pytest.mark.parametrize(("height", "out"), [(1e-3, True), (1e-12, False), (-1e-12, False), (-1e-3, False)])
def test_what_is_within_an_error_stays(height: float, out: bool) -> None:
    """A triangle that looks up, at a height seen from the origin; its corners may be off by 1e-9."""
    place, up = np.array([[0.0], [height], [-5.0]]), np.array([[0.0], [1.0], [0.0]])
    form, extent = (np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(4)), np.array([[0.0, 1.0, 0.0, 1.0, 1.5]])
    front = np.array([CULL["front"]], np.int8)
    facing.leave_out((place, place), (up, up), front, np.full(3, 1e-9), form, extent)
    assert (extent[0, 1] == 0.0) == out


def test_normals_are_as_uncertain_as_the_corners() -> None:
    vertices = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    low, high = np.empty((3, 1)), np.empty((3, 1))
    facing.normal_boxes(vertices, np.array([[0, 1, 2]], np.int32), np.full(3, 1e-9), low, high)
    normal = np.array([[0.0], [0.0], [1.0]])
    assert (low <= normal - 1e-9).all() and (high >= normal + 1e-9).all() and (high - low < 1e-7).all()
