"""Every method keeps what its row promises, and a method that does not is told which promise it breaks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms.registry import BUILT_IN, Method, method_named
from hsr.base.errors import UnavailableError, VisibilityError
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View
from hsr.testing import check_method
from hsr.testing.conformance import TRIALS, Trial

REACH = 1.0 / 20.0
"""Pixels that a sample is away from any edge, at least, where a trial says that none is close."""


@pytest.mark.parametrize("method", BUILT_IN, ids=lambda method: method.name)
def test_our_methods_keep_their_promises(method: Method) -> None:
    try:
        check_method(method)
    except UnavailableError as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("trial", [trial for trial in TRIALS if not trial.close], ids=lambda t: t.promise)
def test_no_sample_is_close_to_an_edge(trial: Trial) -> None:
    seen = trial.view().tessellated()
    truth = hsr.render(seen, "exact")
    for dx, dy in product((-REACH, REACH), repeat=2):
        matrix = seen.clip_from_world.copy()
        matrix[0] += 2.0 * dx / seen.width * matrix[3]
        matrix[1] += 2.0 * dy / seen.height * matrix[3]
        moved = hsr.render(replace(seen, clip_from_world=matrix), "exact")
        np.testing.assert_array_equal(moved.face, truth.face)


@pytest.mark.parametrize("trial", [trial for trial in TRIALS if trial.close], ids=lambda t: t.promise)
def test_close_trials_have_close_samples(trial: Trial) -> None:
    truth, seen = hsr.render(trial.view(), "exact"), trial.view()
    depths = truth.depth[truth.face >= 0]
    assert truth.work["ties"] or {seen.near, seen.far} & set(depths.tolist())


@dataclass(frozen=True)
class Options:
    """Of a method that is wrong on purpose."""


def broken(monkeypatch: pytest.MonkeyPatch, change: Any, **row: Any) -> Method:
    """Make a method that shows the truth, changed."""

    def render(view: View, _options: Options) -> VisibilityMap:
        truth = hsr.render(view, "exact")
        face, depth = change(truth.face.copy(), truth.depth.copy())
        return VisibilityMap(face, depth, "broken", seconds={"render": 0.0})

    monkeypatch.setitem(globals(), "render", render)
    return Method("broken", "the truth, changed", __name__, curved=True, **row)


def lost(face: Any, depth: Any) -> Any:
    """Lose the last sample that is covered."""
    row, column = np.argwhere(face >= 0)[-1] if (face >= 0).any() else (0, 0)
    face[row, column], depth[row, column] = -1, np.inf
    return face, depth


def test_a_right_method_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    check_method(broken(monkeypatch, lambda face, depth: (face, depth), certified=True))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            lost,
            r"hides its own back \(12x9\): sample \d+,\d+ shows background, the truth is box",
        ),
        (lambda face, depth: (face, depth + 1.0 * (face >= 0)), "another depth than that of the face"),
        (lambda face, depth: (face, np.where(face < 0, 9.0, depth)), r"a background that is not at \+inf"),
        (lambda face, depth: (face.astype(np.int64), depth), "are not int32 and float64"),
        (
            lambda face, depth: (np.where(face == 0, 100, face).astype(np.int32), depth),
            "a face that there is not",
        ),
        (lambda face, depth: (face, depth * np.random.default_rng().uniform(1, 2)), "another answer"),
    ],
)
def test_a_broken_promise_is_named(monkeypatch: pytest.MonkeyPatch, change: Any, said: str) -> None:
    with pytest.raises(VisibilityError, match=said) as caught:
        check_method(broken(monkeypatch, change))
    assert isinstance(caught.value, AssertionError) and str(caught.value).startswith("broken does not keep")


def test_only_a_certified_method_is_held_to_the_rule_of_ties(monkeypatch: pytest.MonkeyPatch) -> None:
    def last(face: Any, depth: Any) -> Any:
        # Of two faces that coincide everywhere the second is shown.
        return np.where((face == 0).all() and (depth == 5.0).all(), 1, face).astype(np.int32), depth

    check_method(broken(monkeypatch, last, resolves="nothing"))
    with pytest.raises(VisibilityError, match="of equal depths the lowest face is shown"):
        check_method(broken(monkeypatch, last, certified=True))


def test_a_method_is_named_or_given() -> None:
    check_method("exact")
    check_method(method_named("exact"))
