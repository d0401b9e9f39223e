"""Which triangles a ray may meet: none that it does meet is left out."""

from __future__ import annotations

import numpy as np

from hsr.models.embree.lines import may_meet
from hsr.models.embree.pipeline import _exact_hit


def test_a_far_origin_leaves_no_triangle_out_whose_edge_the_ray_meets() -> None:
    random = np.random.default_rng(0)
    met = 0
    for _ in range(2000):
        corners = random.integers(-7, 8, size=(3, 3)).astype(np.float32)
        toward = random.integers(-3, 4, size=3)
        middle = (corners[0] + corners[1]) / 2
        origin = (middle - 2.0 ** random.integers(16, 24) * toward).astype(np.float32)
        direction = toward.astype(np.float32)
        if _exact_hit(corners, origin, direction)[0] >= 0:
            met += 1
            assert may_meet(corners[None], origin, direction)[0], (corners, origin, direction)
    assert met > 500


def test_what_is_passed_by_is_left_out() -> None:
    corners = np.eye(3, dtype=np.float32)[None]
    assert may_meet(corners, np.zeros(3, np.float32), np.ones(3, np.float32))[0]
    assert not may_meet(corners, np.zeros(3, np.float32), np.array([1, -1, 1], np.float32))[0]
