"""The oracle as a method."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from hsr.algorithms.exact import Options, render
from hsr.problem.map import load_map
from hsr.problem.view import view

PARALLEL = {"type": "orthographic", "eye": [0.0, 0.0, 3.0], "height": 4.0, "far": 9.0}


def test_the_map_tells_who_may_own_a_tie(make_scene: Any, tmp_path: Path) -> None:
    twice = [{"name": name, "shape": "square"} for name in ("a", "b")]
    answer = render(view(make_scene(twice, **PARALLEL), (4, 4)), Options())
    assert answer.method == "exact"
    assert answer.work == {"uncertain": 4, "ties": 4}
    assert answer.admissible is not None
    assert answer.admissible.sample.tolist() == [5, 6, 9, 10]
    assert answer.admissible.faces(5) == {0, 1}
    assert answer.admissible.faces(4) == frozenset()

    answer.save(tmp_path / "map.npz")
    read = load_map(tmp_path / "map.npz").admissible
    assert read is not None
    assert read.faces(10) == {0, 1}


def test_spheres_are_round(make_scene: Any) -> None:
    ball = make_scene([{"name": "ball", "shape": "sphere"}], **PARALLEL)
    answer = render(view(ball, (64, 64)), Options())
    i, j = np.meshgrid(*[(np.arange(64) - 31.5) / 16.0] * 2)
    inside = i**2 + j**2 < 1.0
    assert ((answer.face == 0) == inside).all()
    expected = 3.0 - np.sqrt(1.0 - (i**2 + j**2)[inside])
    np.testing.assert_allclose(answer.depth[inside], expected, rtol=1e-15)
