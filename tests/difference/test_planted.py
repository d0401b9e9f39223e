"""Classic mistakes, handed in under the name of a method that does not make them: all are caught."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

import hsr
from hsr.algorithms import exact
from hsr.base.errors import UnavailableError
from hsr.difference.cause import causes
from hsr.mistakes.planted import MISTAKES
from hsr.mistakes.renderers import Buffer
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View
from tests.difference.planted import VIEWS

SHOWN_BY = {
    "pixel corner instead of centre": "soup",
    "lower pixel corner instead of centre": "soup",
    "inclusive edges": "prism",
    "<= for <": "prism",
    "flipped y": "soup",
    "no near clip": "soup",
    "z not divided": "soup",
    "truncating snap": "soup",
    "inverted culling": "soup",
    "unnormalised t": "soup",
    "16-bit depth": "close pair",
    "first instead of nearest hit": "soup",
    "> for <": "soup",
    "truncated bounding box": "soup",
}
"""A view in which each mistake shows."""

HONEST = (
    "scanline",
    "scanline-direct",
    "scanline-float32",
    "scanline-float32-direct",
    "zbuffer",
    "raycast",
    "raycast-plain",
    "raycast-single",
    "raycast-list",
)


@cache
def problem(name: str) -> tuple[View, VisibilityMap]:
    seen = VIEWS[name]()
    return seen, exact.render(seen, exact.Options())


@pytest.mark.parametrize("mistake", MISTAKES)
@pytest.mark.parametrize("method", ["scanline", "zbuffer", "raycast"])
def test_every_wrong_sample_of_a_mistake_is_unexplained(mistake: str, method: str) -> None:
    seen, truth = problem(SHOWN_BY[mistake])
    found = causes(seen, MISTAKES[mistake].render(seen, method), truth)
    assert found.unexplained == found.wrong > 0
    assert not found.reproduced


@pytest.mark.parametrize("mistake", MISTAKES)
def test_what_opengl_rounds_does_not_excuse_a_mistake(mistake: str) -> None:
    seen, truth = problem(SHOWN_BY[mistake])
    found = causes(seen, MISTAKES[mistake].render(seen, "opengl"), truth)
    assert found.unexplained > 0
    assert not found.reproduced


@pytest.mark.parametrize("name", VIEWS)
def test_the_renderer_without_a_mistake_is_right(visibility: Any, name: str) -> None:
    seen, truth = problem(name)
    visibility.agree({"renderer": Buffer().render(seen, "scanline")}, truth, scene=seen)


@pytest.mark.parametrize("name", VIEWS)
@pytest.mark.parametrize("method", HONEST)
def test_honest_methods_are_explained(name: str, method: str) -> None:
    seen, truth = problem(name)
    found = causes(seen, hsr.render(seen, method), truth)
    assert found.unexplained == 0
    assert found.reproduced


@pytest.mark.parametrize("name", VIEWS)
def test_opengl_is_explained_where_it_is_modelled(name: str) -> None:
    seen, truth = problem(name)
    try:
        answer = hsr.render(seen, "opengl")
    except UnavailableError as error:
        pytest.skip(str(error))
    if "llvmpipe" not in answer.notes["driver"] or "Mesa 22." not in answer.notes["driver"]:
        pytest.skip(f"not the driver that is modelled: {answer.notes['driver']}")
    found = causes(seen, answer, truth)
    assert found.unexplained == 0
    assert found.reproduced


@pytest.mark.visibility(allow={"input rounding", "transform", "traversal", "intersector"})
@pytest.mark.parametrize("name", VIEWS)
def test_embree_is_explained(visibility: Any, name: str) -> None:
    seen, truth = problem(name)
    visibility.agree({"embree": hsr.render(seen, "embree")}, truth, scene=seen)
