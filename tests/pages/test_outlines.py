"""The projected edges of faces, where they are known by heart, and against the exact map."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import hsr
from hsr.pages.outlines import outlines
from hsr.problem.view import View
from hsr.scene.shapes.shape import ARCS

PARALLEL = {"type": "orthographic", "eye": [0.0, 0.0, 6.0], "height": 4.0, "far": 20.0}


def seen_by(make_scene: Any, camera: dict[str, Any], *things: dict[str, Any]) -> View:
    named = [{"name": f"thing{k}", **thing} for k, thing in enumerate(things)]
    return hsr.view(make_scene(named, **camera), (40, 40))


def edges(view: View, *faces: int) -> set[frozenset[tuple[float, float]]]:
    points, ends = outlines(view, np.array(faces, dtype=np.int32))
    assert len(np.unique(points, axis=0)) == len(points)
    return {frozenset((float(x), float(y)) for x, y in points[pair]) for pair in ends}


def test_a_square_has_four_sides_on_the_screen(make_scene: Any) -> None:
    view = seen_by(make_scene, PARALLEL, {"shape": "square"})
    corners = [(10.0, 10.0), (30.0, 10.0), (30.0, 30.0), (10.0, 30.0)]
    sides = {frozenset([a, b]) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)}
    assert edges(view, 0) == sides


def test_faces_share_an_edge_once(make_scene: Any) -> None:
    camera = {"type": "perspective", "eye": [3.0, 2.0, 5.0]}
    view = seen_by(make_scene, camera, {"shape": "cube"})
    assert [len(edges(view, *range(n))) for n in (1, 2, 6)] == [4, 8, 12]
    assert len(edges(view, 0, 2)) == 7 and edges(view) == set()


def test_near_cuts_off(make_scene: Any) -> None:
    things = {"shape": "square", "transform": [{"rotate_x": 90.0}]}
    camera = {
        "type": "orthographic",
        "eye": [0.0, 0.5, 6.0],
        "target": [0.0, 0.5, 0.0],
        "height": 4.0,
        "near": 6.0,
        "far": 20.0,
    }
    ((a, b),) = (sorted(edge) for edge in edges(seen_by(make_scene, camera, things), 0) if len(edge) == 2)
    assert (a, b) == ((10.0, 25.0), (30.0, 25.0))  # seen edge-on; only what lies behind z = 0 is left
    assert edges(seen_by(make_scene, camera | {"near": 8.0}, things), 0) == set()


def test_a_ball_is_bounded_by_a_circle(make_scene: Any) -> None:
    view = seen_by(make_scene, PARALLEL, {"shape": "sphere"})
    points, ends = outlines(view, np.array([0], dtype=np.int32))
    assert len(ends) == ARCS
    assert np.hypot(*(points - 20.0).T) == pytest.approx(np.full(len(points), 10.0), abs=1e-4)


def test_from_inside_nothing_bounds_a_ball(make_scene: Any) -> None:
    camera = {"type": "perspective", "eye": [0.0, 0.0, 0.0], "target": [0.0, 0.0, -1.0], "near": 0.1}
    assert edges(seen_by(make_scene, camera, {"shape": "sphere"}), 0) == set()


@pytest.mark.parametrize("camera", [{"type": "perspective"}, PARALLEL], ids=["perspective", "parallel"])
@pytest.mark.parametrize(
    "shape",
    [
        {"shape": "sphere"},
        {"shape": "cylinder"},
        {"shape": "cylinder", "top": 0.0},
        {"shape": "cylinder", "top": 1.5},
    ],
)
def test_outlines_go_between_covered_samples_and_others(
    camera: dict[str, Any], shape: dict[str, Any], make_scene: Any
) -> None:
    turns = [{"rotate_x": 50.0}, {"rotate_y": 20.0}]
    thing = {**shape, "transform": [{"scale": [1.2, 0.7, 1.3 if "top" in shape else 1.0]}, *turns]}
    view = seen_by(make_scene, camera | {"eye": [1.0, 2.0, 6.0]}, thing)
    face = hsr.render(view, "exact").face
    points, ends = outlines(view, np.arange(view.faces, dtype=np.int32))
    along = np.linspace(0.0, 1.0, 100)[:, None, None]
    dense = (points[ends[:, 0]] * (1.0 - along) + points[ends[:, 1]] * along).reshape(-1, 2)
    rows, columns = np.nonzero((face[:, :-1] < 0) != (face[:, 1:] < 0))
    assert len(rows) > 20
    for row, column in zip(rows, columns, strict=True):  # an edge crosses from one centre to the next
        near = np.abs(dense[:, 1] - (row + 0.5)) < 0.1
        assert ((dense[near, 0] > column + 0.3) & (dense[near, 0] < column + 1.7)).any()
