"""Which faces are near which samples, against their corners' places on the screen."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hsr.difference.nearby import faces_nearby
from hsr.problem.view import View, view

THINGS: list[dict[str, Any]] = [
    {"shape": "cube", "name": "box", "transform": [{"rotate_y": 30.0}, {"translate": [-1.0, 0.0, 0.0]}]},
    {"shape": "menger", "name": "sponge", "level": 1, "transform": [{"rotate_x": 20.0}]},
    {"shape": "sphere", "name": "ball"},
    {"shape": "fir", "name": "tree", "transform": [{"scale": 3.0}, {"translate": [0.4, -1.5, 3.9]}]},
    {"shape": "cube", "name": "behind", "transform": [{"translate": [0.0, 0.0, 9.0]}]},
]
"""The tree reaches through the plane of an eye at z = 4; the last cube is behind it."""


def screen_boxes(seen: View) -> list[tuple[int, Any]]:
    """Faces of polygons, and their corners on the screen; None if not all are in front of the eye."""
    boxes: list[tuple[int, Any]] = []
    for placement in seen.placements:
        polygons = placement.shape.polygons
        if polygons is None:
            continue
        points = np.column_stack([polygons.vertices, np.ones(len(polygons.vertices))])
        x, y, _, w = seen.clip_from_world @ placement.world_from_object @ points.T
        for k in range(len(polygons)):
            loop = polygons.corner[polygons.start[k] : polygons.start[k + 1]]
            if (w[loop] < 0).all():
                continue
            down, right = 1 - y[loop] / w[loop], 1 + x[loop] / w[loop]
            places = np.stack([down * seen.height / 2, right * seen.width / 2])
            ahead = (w[loop] > 0).all()
            boxes.append((placement.first + int(polygons.face[k]), places if ahead else None))
    return boxes


@pytest.mark.parametrize("count", [1, 30, 1200])
def test_pairs_are_those_of_boxes_a_pixel_wider(count: int, make_scene: Any) -> None:
    seen = view(make_scene(THINGS, eye=[0.3, 0.4, 4.0]), (40, 30))
    samples = np.sort(np.random.default_rng(count).permutation(1200)[:count])
    nearby = faces_nearby(seen, samples)
    found = set(zip(nearby.sample.tolist(), nearby.origin[nearby.face].tolist(), strict=True))
    expected = set()
    spot = np.column_stack(np.divmod(samples, 40)) + 0.5
    for face, places in screen_boxes(seen):
        inside = np.full(len(spot), True)
        if places is not None:
            inside = ((places.min(1) <= spot + 1) & (places.max(1) >= spot - 1)).all(axis=1)
        expected |= {(sample, face) for sample in samples[inside].tolist()}
    assert found == expected
    assert np.array_equal(nearby.samples, samples)
    assert [placement.name for placement in nearby.view.placements if placement.shape.curved] == ["ball"]


def test_a_sample_has_the_same_faces_with_others_and_alone(make_scene: Any) -> None:
    seen = view(make_scene(THINGS, eye=[0.3, 0.4, 4.0]), (40, 30))
    together = faces_nearby(seen, np.arange(0, 1200, 7))
    for sample in range(0, 1200, 70):
        alone = faces_nearby(seen, np.array([sample]))
        faces = together.origin[together.face[together.sample == sample]]
        assert faces.tolist() == alone.origin[alone.face].tolist()
