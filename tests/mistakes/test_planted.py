"""The renderer in which mistakes are planted, and the checks that must notice them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.errors import ViewError
from hsr.mistakes.planted import MISTAKES, planted
from hsr.mistakes.renderers import Buffer
from hsr.problem.view import View
from hsr.testing.judging import Subject, let_through
from hsr.testing.limits import Limits

TURNED = [{"rotate_x": 20.0}, {"rotate_y": 35.0}]
WALL = {"name": "wall", "shape": "square", "transform": [{"scale": 1.7}, {"rotate_y": -50.0}]}


@pytest.fixture(params=["plain", "mirrored", "culled", "mirrored and culled", "parallel"])
def view(request: pytest.FixtureRequest, make_scene: Any) -> View:
    kind = request.param
    flip = [{"scale": [-1.0, 1.0, 1.0]}] if "mirrored" in kind else []
    box = {"name": "box", "shape": "cube", "transform": flip + TURNED}
    box |= {"cull": "front"} if "culled" in kind else {}
    camera = {"type": "orthographic", "height": 5.0, "far": 9.0} if kind == "parallel" else {"far": 9.0}
    return hsr.view(make_scene([box, WALL], **camera), (32, 24))


def test_without_a_mistake_it_is_right(visibility: Any, view: View) -> None:
    visibility.agree({"renderer": Buffer().render(view, "renderer")}, hsr.render(view, "exact"))


def test_a_planted_mistake_changes_what_it_changes(view: View) -> None:
    truth = hsr.render(view, "exact")
    flipped = planted("flipped y", truth, view)
    assert np.array_equal(flipped.face, truth.face[::-1])  # as the renderer is right everywhere
    assert flipped.method == truth.method and (flipped.face != truth.face).any()


def test_a_strict_check_overlooks_nothing_that_shows(view: View) -> None:
    truth = hsr.render(view, "exact")
    assert let_through(truth, truth, Limits(), Subject(view)) == {}
    lax = let_through(truth, truth, Limits(max_diff_ratio=1.0), Subject(view))
    assert {"flipped y", "pixel corner instead of centre", "truncating snap"} <= set(lax) <= set(MISTAKES)
    assert lax["flipped y"] > 32


def test_curved_shapes_must_be_tessellated(make_scene: Any) -> None:
    round_view = hsr.view(make_scene([{"name": "ball", "shape": "sphere"}]), (16, 16))
    with pytest.raises(ViewError, match="object 'ball' is curved"):
        Buffer().render(round_view, "")
    assert (planted("flipped y", hsr.render(round_view, "exact"), round_view).face >= -1).all()
