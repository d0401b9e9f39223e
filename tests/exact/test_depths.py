"""Depths of owners: within 0.51 ulp of the true ones."""

from __future__ import annotations

from fractions import Fraction
from math import inf, ulp

import numpy as np
import pytest

from hsr.exact.depths import depth_quotient, depths_of
from hsr.exact.oracle import truth
from hsr.exact.problem import problem_of
from hsr.problem.view import view
from tests.exact.hard import CONES, CURVED, PLANAR, hard_view, loose_view, scene


@pytest.mark.parametrize("shapes", [PLANAR, CURVED, CONES], ids=["planar", "curved", "cones"])
@pytest.mark.parametrize("seed", range(120, 126))
def test_doubled_precision_agrees_with_integers(shapes: tuple[str, ...], seed: int) -> None:
    view = (hard_view if seed % 2 else loose_view)(seed, shapes)
    problem = problem_of(view, np.arange(view.width * view.height))
    grid = [tuple(int(x) for x in problem.frame.at(np.array(k))) for k in range(view.width * view.height)]
    for number in range(len(problem.triangles) + len(problem.rounds)):
        piece = problem.piece(number)
        there = [all(polynomial(*spot) > 0 for polynomial in piece.extent) for spot in grid]
        depths = depths_of(problem, np.where(there, number, -1).astype(np.int32))
        for spot, depth, is_there in zip(grid, depths.tolist(), there, strict=True):
            if is_there:
                truth = Fraction(*depth_quotient(problem.frame, piece, *spot))
                assert abs(Fraction(depth) - truth) <= Fraction(0.51) * Fraction(ulp(depth))
            else:
                assert depth == inf


def test_a_depth_of_nothing() -> None:
    # Cancels away in any precision; integers know that nothing is left.
    camera = {"type": "orthographic", "eye": [0.0, 0.0, 0.0], "target": [1.0, 1.0, 1.0], "height": 2.0}
    ramp = {"shape": "square", "transform": [{"rotate_x": 10.0}]}
    answer = truth(view(scene([ramp], {**camera, "near": -1.0, "far": 1.0}), (3, 3)))
    assert answer.depth[1, 1] == 0.0
