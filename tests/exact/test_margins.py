"""How close a decision was."""

from __future__ import annotations

import math

import pytest

from hsr.base.errors import ViewError
from hsr.exact.margins import margins, pixels_to_zero
from hsr.problem.view import view
from tests.exact.hard import scene

DOWN = {"type": "orthographic", "eye": [0.0, 0.0, 3.0], "height": 4.0, "far": 9.0}


def test_distances_to_edges_and_the_gap_in_depth() -> None:
    corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, 1.0, 0.0]]
    wall = {"shape": "mesh", "vertices": corners, "faces": [[0, 1, 2]]}
    behind = {"shape": "square", "transform": [{"scale": 4.0}, {"translate": [0.0, 0.0, -(2.0**-40)]}]}
    close = margins(view(scene([wall, behind], DOWN), (4, 4)), 2, 1)
    assert [face.face for face in close.faces][:2] == [0, 1]
    # The sample is half a pixel from the legs, and the diagonal runs at half a diagonal's distance.
    assert close.faces[0].edges == pytest.approx((0.5**0.5, 0.5, 0.5))
    assert close.faces[0].depth == 3.0
    assert close.gap == 2.0**-40


def test_the_outline_of_a_sphere() -> None:
    seen = view(scene([{"shape": "sphere"}], DOWN), (64, 64))
    inside, outside = margins(seen, 32, 46), margins(seen, 32, 48)
    assert inside.faces[0].edges[0] == pytest.approx(1.5, abs=0.1)
    assert inside.gap > 0.5
    assert outside.faces[0].edges[0] == pytest.approx(-0.5, abs=0.1)
    assert outside.faces[0].depth is None


@pytest.mark.parametrize(
    ("value", "square", "distance"),
    [(-6, 9, -1.0), (0, 0, math.inf), (-1, 0, -math.inf), (2**600, 9, math.inf), (-(2**600), 9, -math.inf)],
    ids=["near", "flat, zero", "flat, below zero", "far", "far below zero"],
)
def test_values_far_from_zero_are_infinitely_far(value: int, square: int, distance: float) -> None:
    assert pixels_to_zero(value, square) == distance


def test_there_must_be_such_a_sample() -> None:
    with pytest.raises(ViewError, match="row 4, column 0: the image is 4x4"):
        margins(view(scene([{"shape": "cube"}], DOWN), (4, 4)), 4, 0)
