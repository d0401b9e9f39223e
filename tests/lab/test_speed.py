"""Methods judged and timed: made-up ones for the rules, two real ones once."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms import registry
from hsr.algorithms.registry import Method, methods
from hsr.base.errors import MethodError, UnavailableError
from hsr.lab import machine, speed
from hsr.lab.regression import changes
from hsr.lab.results import Results
from hsr.lab.speed import Case, fresh, make_case, measure, verdict
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View

CUBE = [{"name": "cube", "shape": "cube"}]


@dataclass(frozen=True)
class Options:
    """No options."""


def painted(view: View, seconds: float = 0.001) -> VisibilityMap:
    """Answer right by exact arithmetic, with times of our own."""
    truth = registry.BUILT_IN[0].render(view)
    return VisibilityMap(truth.face, truth.depth, "", {"faces": 6}, {"prepare": 0.5, "render": seconds})


def half(view: View, _: Options) -> VisibilityMap:
    """Show the upper half only, half a unit too deep."""
    answer = painted(view)
    answer.face[view.height // 2 :], answer.depth[view.height // 2 :] = -1, np.inf
    answer.depth[: view.height // 2] += 0.5
    return answer


class Fragile:
    """Works so many times, then breaks."""

    def __init__(self, times: int) -> None:
        self.left = times

    def __call__(self, view: View, _: Options) -> VisibilityMap:
        self.left -= 1
        if self.left < 0:
            raise ZeroDivisionError
        return painted(view)


def raising(error: Exception) -> Any:
    def render(_view: View, _options: Options) -> VisibilityMap:
        raise error

    return render


@pytest.fixture
def register(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Register made-up methods: ``register(name=render)``."""

    def install(**renders: Any) -> None:
        for name, render in renders.items():
            module = SimpleNamespace(Options=Options, render=render)
            monkeypatch.setitem(sys.modules, f"made_up_{name}", module)
            monkeypatch.setitem(methods(), name, Method(name, "", f"made_up_{name}"))

    return install


@pytest.fixture
def cube(make_scene: Any) -> Case:
    return make_case("cube", make_scene(CUBE), (16, 16))


def test_stages_are_kept_turn_by_turn(register: Any, cube: Case) -> None:
    register(right=lambda view, _: painted(view), half=half)
    order: list[str] = []
    found = measure([cube], ["right", "half"], 4, progress=order.append)
    assert order == ["cube 16x16: judging", *(f"cube 16x16: turn {k} of 4" for k in (1, 2, 3, 4))]
    right, wrong = found.rows
    assert right.id == "cube/16x16/scene/right"
    assert right.times["render"].samples == (1.0,) * 4 and right.times["prepare"].median == 500.0
    assert right.times["total"].median == 501.0
    assert right.work == {"faces": 6} and right.buffer_bytes == 16 * 16 * 12
    assert right.verdict is not None and (right.verdict.wrong, right.verdict.causes) == (0, {})
    assert wrong.verdict is not None and wrong.verdict.causes == {"unexplained": wrong.verdict.wrong}
    assert wrong.verdict.wrong == wrong.verdict.largest_cluster > 20 and wrong.verdict.clusters == 1
    depth = wrong.verdict.depth
    assert (depth.max, depth.median) == (pytest.approx(0.5), pytest.approx(0.5))
    assert depth.max_ulp == pytest.approx(0.5 / np.spacing(3.0)), "the cube lies between 2 and 4 units away"


def test_those_that_fail_keep_a_row(register: Any, cube: Case) -> None:
    register(
        missing=raising(UnavailableError("missing: needs a driver;\ninstall one")),
        lame=raising(MethodError("cannot handle\nthis")),
        broken=raising(ValueError()),
        fragile=Fragile(4),  # warm-up, judging, two turns
        right=lambda view, _: painted(view),
    )
    found = measure([cube], ["missing", "lame", "broken", "fragile", "right"], 3)
    assert {row.method: row.absent for row in found.rows} == {
        "missing": "needs a driver; install one",
        "lame": "cannot handle this",
        "broken": "it broke down: ValueError",
        "fragile": "it broke down: ZeroDivisionError",
        "right": "",
    }
    assert all(row.times == {} and row.verdict is None for row in found.rows if row.absent)


def test_a_slow_method_has_three_turns(register: Any, cube: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(speed, "SHARE", 2.5)
    register(slow=lambda view, _: painted(view, 5.0), quick=lambda view, _: painted(view, 0.1))
    slow, quick = measure([cube], ["slow", "quick"], 6).rows
    assert len(slow.times["render"].samples) == 3
    assert len(quick.times["render"].samples) == 5, "its share is used up after five turns of 0.6 s"


def test_exhaustive_methods_sit_out_what_takes_too_long(register: Any, cube: Case) -> None:
    register(list=lambda view, _: painted(view))
    methods()["list"] = replace(methods()["list"], exhaustive=True)
    tests = 6 * 16 * 16
    assert measure([cube], ["list"], 3, patience=tests).rows[0].absent == ""
    assert "test each of 6 faces" in measure([cube], ["list"], 3, patience=tests - 1).rows[0].absent


def test_unknown_methods_stop_the_run(cube: Case) -> None:
    with pytest.raises(MethodError, match="no method is named 'nope'"):
        measure([cube], ["nope"])


def test_culling_replaces_that_of_the_scene(make_scene: Any) -> None:
    scene = make_scene([{**CUBE[0], "cull": "front"}])
    culled = {
        cull: make_case("c", scene, (8, 8), cull).view.placements[0].cull
        for cull in ("scene", "none", "back")
    }
    assert culled == {"scene": 2, "none": 0, "back": 1}


def test_every_turn_has_a_view_of_its_own(register: Any, cube: Case) -> None:
    given: list[View] = []

    def keep(view: View, _: Options) -> VisibilityMap:
        given.append(view)
        return painted(view)

    register(keeper=keep)
    measure([cube], ["keeper"], 3)
    full = [view for view in given if view.width == 16]
    assert len(full) == 4 and len({id(view.geometry) for view in [cube.view, *full]}) == 5


def test_nothing_prepared_is_used_again(make_scene: Any) -> None:
    seen = make_case("c", make_scene(CUBE), (8, 8)).view
    prepared = seen.polygons
    anew = fresh(seen)
    assert anew.geometry is not seen.geometry and anew.polygons is not prepared
    assert anew.hashes == seen.hashes


def test_a_view_of_nothing_has_no_depth_error(make_scene: Any) -> None:
    away = [{**CUBE[0], "transform": [{"translate": [90.0, 0.0, 0.0]}]}]
    seen = make_case("c", make_scene(away), (8, 8)).view
    truth = hsr.render(seen, "exact")
    found = verdict(seen, truth, truth)
    assert found.depth.samples == 0 and found.depth.max == 0.0 and found.wrong == 0


@pytest.mark.jit
def test_two_real_methods(scenes: Path) -> None:
    case = make_case("solids", hsr.load(scenes / "solids.toml"), (16, 16))
    found = measure([case], ["zbuffer", "raycast"], 3)
    zbuffer, raycast = found.rows
    assert zbuffer.absent == raycast.absent == ""
    assert raycast.verdict is not None and raycast.verdict.wrong == 0
    assert set(raycast.times) == {"prepare", "build", "render", "total"}
    assert all(sample > 0.0 for sample in zbuffer.times["render"].samples)
    assert zbuffer.warm_up is not None and zbuffer.warm_up > 0.0
    assert found.machine.threads == zbuffer.threads
    assert found.machine.environment["LP_NUM_THREADS"] == str(found.machine.threads)


def test_a_planted_slow_down_is_caught(register: Any, cube: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    """Sleep 50 ms, then 60: by the clock, and as if no other program ran."""
    monkeypatch.setattr(machine, "STAT", Path("no such file"))
    monkeypatch.setattr(speed, "yardstick", lambda: 1.0)

    def sleeping(seconds: float) -> Any:
        def render(view: View, _: Options) -> VisibilityMap:
            answer = painted(view)
            start = time.perf_counter()
            time.sleep(seconds)
            answer.seconds.clear()
            answer.seconds["render"] = time.perf_counter() - start
            return answer

        return render

    def run(seconds: float) -> Results:
        register(sleeper=sleeping(seconds))
        return measure([cube], ["sleeper"], 9)

    before = run(0.05)
    assert [change.verdict for change in changes(before, run(0.06))] == ["slower"]
    assert [change.verdict for change in changes(before, run(0.05))] == ["same"]
