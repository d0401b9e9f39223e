"""Many methods on one view: what is run, what is skipped, who agrees."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hsr.algorithms import registry
from hsr.algorithms.registry import Method
from hsr.base.errors import MethodError, UnavailableError, ViewError
from hsr.base.store import Store
from hsr.difference import study as module
from hsr.difference.study import RECALLED, explained, study
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View
from hsr.scene.model import MatrixCamera

CUBE = [{"name": "box", "shape": "cube"}]


def whole_face(shift: int) -> Any:
    """Return a method that shows face 0 from column ``shift`` on."""

    def render(view: View, _options: Any) -> VisibilityMap:
        face = np.full((view.height, view.width), -1, dtype=np.int32)
        face[:, shift:] = 0
        return VisibilityMap(face, np.where(face < 0, np.inf, 2.0), "", {"columns": 1}, {"render": 0.5})

    return render


def refuse(error: Exception) -> Any:
    def render(_view: View, _options: Any) -> VisibilityMap:
        raise error

    return render


@dataclass(frozen=True)
class Options:
    """No options."""


def install(monkeypatch: pytest.MonkeyPatch, name: str, render: Any) -> None:
    monkeypatch.setitem(sys.modules, f"made_up_{name}", SimpleNamespace(Options=Options, render=render))


@pytest.fixture
def methods(monkeypatch: pytest.MonkeyPatch) -> dict[str, Method]:
    """Four made-up methods and ``opengl``, in place of the real ones."""
    renders = {
        "left": whole_face(0),
        "right": whole_face(2),
        "opengl": whole_face(0),
        "lame": refuse(MethodError("cannot handle parallel views")),
        "absent": refuse(UnavailableError("needs a driver; install one")),
    }
    for name, render in renders.items():
        install(monkeypatch, name, render)
    made = {name: Method(name, "", f"made_up_{name}", curved=name == "right") for name in renders}
    monkeypatch.setattr(registry, "methods", lambda: made)
    return made


@pytest.mark.usefixtures("methods")
def test_every_method_is_judged_against_the_reference(make_scene: Any) -> None:
    ran: list[str] = []
    found = study(make_scene(CUBE), ["right", "lame", "absent"], "left", (6, 3), progress=ran.append)
    assert ran == ["right", "lame", "absent", "left"] == list(found.methods)
    assert list(found.maps) == ["right", "left"] and list(found.differences) == ["right"]
    assert found.differences["right"].counts["missing"] == 6
    assert found.agreement.tolist() == [[0, 6], [6, 0]]
    assert found.skipped == {"lame": "cannot handle parallel views", "absent": "needs a driver; install one"}
    assert found.missing == {"absent"}
    assert found.reference == "left" and found.camera == "main"
    assert found.maps["right"].face.shape == (3, 6)


@pytest.mark.usefixtures("methods")
def test_without_its_reference_a_study_compares_nothing(make_scene: Any) -> None:
    found = study(make_scene(CUBE), ["left", "right"], "absent", (6, 3))
    assert found.reference is None and found.differences == {} and "absent" in found.skipped
    assert found.agreement.tolist() == [[0, 6], [6, 0]]


@pytest.mark.usefixtures("methods")
def test_tessellating_methods_are_named_where_it_matters(make_scene: Any) -> None:
    ball = [{"name": "ball", "shape": "sphere"}]
    assert study(make_scene(ball), ["left", "right"], "left", (4, 4)).tessellating == ("left",)
    assert study(make_scene(CUBE), ["left", "right"], "left", (4, 4)).tessellating == ()


def test_exhaustive_methods_sit_out_large_scenes(
    make_scene: Any, methods: dict[str, Method], monkeypatch: pytest.MonkeyPatch
) -> None:
    methods["left"] = replace(methods["left"], exhaustive=True)
    monkeypatch.setattr(module, "PATIENCE", 6 * 4 * 4)
    small, large = (study(make_scene(CUBE), ["left"], "right", (4, rows)) for rows in (4, 5))
    assert "left" in small.maps and "tests each of 6 faces at each sample" in large.skipped["left"]
    assert "left" in study(make_scene(CUBE), ["left"], "right", (4, 5), patient=True).maps


@pytest.mark.usefixtures("methods")
def test_names(make_scene: Any) -> None:
    assert study(make_scene(CUBE), ["left"], "left", (4, 4), name="cube").name == "cube"
    with pytest.raises(MethodError, match="no method is named 'lft'"):
        study(make_scene(CUBE), ["lft"], "left")
    with pytest.raises(MethodError, match="no method is named 'truth'"):
        study(make_scene(CUBE), ["left"], "truth")
    with pytest.raises(ViewError, match="no camera is named"):
        study(make_scene(CUBE), ["left"], "left", camera="back")


@pytest.mark.usefixtures("methods")
def test_json_is_stable(make_scene: Any) -> None:
    told = study(make_scene(CUBE), ["right", "absent"], "left", (6, 3), name="cube").to_json()
    assert told["name"] == "cube" and told["reference"] == "left"
    assert told["agreement"] == {"methods": ["right", "left"], "differing": [[0, 6], [6, 0]]}
    assert told["methods"]["right"]["work"] == {"columns": 1}
    assert json.loads(json.dumps(told)) == told


@pytest.mark.jit
def test_against_the_truth_every_wrong_sample_has_a_cause(make_scene: Any) -> None:
    scene = make_scene([{"name": "ball", "shape": "sphere"}])
    found = explained(study(scene, ["zbuffer", "raycast"], "exact", (160, 160)))
    assert found.causes["raycast"].wrong == 0
    assert set(found.causes["zbuffer"].counts) == {"tessellation"}
    assert found.causes["zbuffer"].wrong == found.differences["zbuffer"].different > 0
    assert found.to_json()["causes"]["zbuffer"]["unexplained"] == 0


def test_only_the_truth_knows_causes(make_scene: Any) -> None:
    found = explained(study(make_scene([{"name": "box", "shape": "cube"}]), ["raycast"], "zbuffer", (8, 8)))
    assert found.causes == {}


def test_no_method_profits_from_what_another_prepared(
    make_scene: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = []
    honest = Method.render

    def keep(self: Method, view: View, **options: Any) -> VisibilityMap:
        given.append(view.geometry)
        return honest(self, view, **options)

    monkeypatch.setattr(Method, "render", keep)
    monkeypatch.setattr(module, "_begun", [])
    study(make_scene([{"name": "cube", "shape": "cube"}]), ["backface", "painter"], "backface", (8, 8))
    assert len({id(geometry) for geometry in given}) == len(given) >= 4


def test_times_hold_no_loading_of_kernels(make_scene: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    loaded, drawn = 0, []
    honest = Method.render

    def draw(self: Method, view: View, **options: Any) -> VisibilityMap:
        nonlocal loaded
        drawn.append(view.width)
        loaded += view.width == 30 and drawn.count(30) == 1
        return honest(self, view, **options)

    monkeypatch.setattr(Method, "render", draw)
    monkeypatch.setattr(module, "kernels_loaded", lambda: loaded)
    monkeypatch.setattr(module, "_begun", [])
    for width in (20, 30, 40):
        study(make_scene(CUBE), ["painter"], "painter", (width, 9))
    assert drawn == [8, 20, 30, 30, 40]


def test_what_was_computed_is_recalled_with_its_note(make_scene: Any, tmp_path: Path) -> None:
    store, ran = Store(tmp_path), []
    how = partial(study, make_scene(CUBE), ["painter", "zbuffer"], "exact", store=store)
    first, again, other = how(size=(6, 3)), how(size=(6, 3), progress=ran.append), how(size=(6, 4))
    for name, answer in again.maps.items():
        assert np.array_equal(answer.face, first.maps[name].face)
        assert answer.seconds == first.maps[name].seconds and answer.notes[RECALLED]
        assert RECALLED not in first.maps[name].notes and RECALLED not in other.maps[name].notes
    first, again = explained(first, store), explained(again, store)
    assert again.to_json()["causes"] == first.to_json()["causes"]
    for name, causes in first.causes.items():
        assert np.array_equal(again.causes[name].cause, causes.cause)
    assert again.to_json()["methods"]["zbuffer"]["notes"][RECALLED] is True


@pytest.mark.usefixtures("methods")
def test_the_command_for_a_history_can_be_pasted(make_scene: Any) -> None:
    scene = make_scene(CUBE)
    assert study(scene, ["right"], "left", (8, 6)).command == ""
    scene = scene.located(Path(), "my scenes/it.toml")
    command = "hsr explain 'my scenes/it.toml' X,Y --size 8x6 -a right -a left"
    assert study(scene, ["right"], "left", (8, 6)).command == command
    moved = scene.camera[0].model_copy(update={"fov": 12.0})
    elsewhere = scene.model_copy(update={"camera": (moved,)})
    told = command.replace("8x6", "8x6 --fov 12")
    assert study(elsewhere, ["right"], "left", (8, 6)).command == told
    nowhere = scene.model_copy(update={"camera": (MatrixCamera(name="m", matrix=np.eye(4)),)})
    assert study(nowhere, ["right"], "left", (8, 6)).command == ""
