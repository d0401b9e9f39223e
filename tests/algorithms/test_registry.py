"""Methods by name, and what every one of them promises."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms import registry
from hsr.algorithms.registry import BUILT_IN, Method, methods
from hsr.base.errors import MethodError, UnavailableError, ViewError
from hsr.difference.classes import depth_step
from hsr.problem.map import VisibilityMap

NOT_RECORDED = ("exact", "painter", "opengl", "embree")

CUBE = [{"name": "box", "shape": "cube"}]


def render_or_skip(scene: Any, name: str, **options: Any) -> VisibilityMap:
    try:
        return hsr.render(scene, name, **options)
    except UnavailableError as error:
        pytest.skip(str(error))


def test_names_differ() -> None:
    assert len({method.name for method in BUILT_IN}) == len(BUILT_IN)


@pytest.mark.parametrize("method", BUILT_IN, ids=lambda method: method.name)
def test_every_method_answers_with_a_whole_map(method: Method, make_scene: Any) -> None:
    view = hsr.view(make_scene(CUBE), size=(17, 13))
    answer = render_or_skip(view, method.name)
    assert answer.face.shape == answer.depth.shape == (13, 17)
    assert answer.face.dtype == np.int32 and answer.depth.dtype == np.float64
    assert answer.face.min() == -1 and 0 <= answer.face.max() < view.faces
    assert np.array_equal(answer.face < 0, np.isinf(answer.depth))
    assert answer.depth.min() > view.near
    assert answer.method == method.name
    assert answer.manifest == view.manifest and answer.hashes == view.hashes
    assert "render" in answer.seconds and all(isinstance(n, int) for n in answer.work.values())


@pytest.mark.parametrize("method", BUILT_IN, ids=lambda method: method.name)
def test_every_method_sees_the_front_of_a_cube(method: Method, make_scene: Any) -> None:
    answer = render_or_skip(make_scene(CUBE, eye=[0.0, 0.0, 5.0]), method.name, size=(9, 9))
    assert answer.name_of(int(answer.face[4, 4])) == "box.front"
    (step,) = depth_step(answer, np.array([4.0]))
    assert answer.depth[4, 4] == pytest.approx(4.0, rel=1e-6, abs=step)


@pytest.mark.parametrize("method", BUILT_IN, ids=lambda method: method.name)
def test_one_pixel_image(method: Method, make_scene: Any) -> None:
    answer = render_or_skip(make_scene(CUBE, eye=[0.1, 0.2, 5.0]), method.name, size=(1, 1))
    assert answer.name_of(int(answer.face[0, 0])) == "box.front"


@pytest.mark.parametrize("method", BUILT_IN, ids=lambda method: method.name)
def test_the_background_is_empty(method: Method, make_scene: Any) -> None:
    scene = make_scene(CUBE, eye=[0.0, 0.0, 5.0], target=[0.0, 0.0, 9.0])
    answer = render_or_skip(scene, method.name, size=(8, 8))
    assert (answer.face == -1).all() and np.isinf(answer.depth).all()


@pytest.mark.parametrize("method", BUILT_IN, ids=lambda method: method.name)
def test_same_input_same_map(method: Method, make_scene: Any) -> None:
    view = hsr.view(make_scene(CUBE), size=(40, 30))
    first, second = (render_or_skip(view, method.name) for _ in range(2))
    assert np.array_equal(first.face, second.face) and np.array_equal(first.depth, second.depth)


def test_unknown_method_lists_the_known_ones(make_scene: Any) -> None:
    with pytest.raises(MethodError, match=r"no method is named 'zbufer'; did you mean 'zbuffer'\?$"):
        hsr.render(make_scene(CUBE), "zbufer")
    with pytest.raises(MethodError, match="no method is named 'magic'; there are exact, backface, painter"):
        hsr.render(make_scene(CUBE), "magic")


def test_unknown_option_lists_the_known_ones(make_scene: Any) -> None:
    with pytest.raises(
        MethodError, match=r"scanline has no option 'steping'; did you mean 'stepping'\? it has stepping"
    ):
        hsr.render(make_scene(CUBE), "scanline", steping="direct")


def test_refused_option_value(make_scene: Any) -> None:
    with pytest.raises(MethodError, match="stepping"):
        hsr.render(make_scene(CUBE), "scanline", stepping="sideways")


def test_size_belongs_to_a_scene(make_scene: Any) -> None:
    with pytest.raises(MethodError, match="a view has its size and camera"):
        hsr.render(hsr.view(make_scene(CUBE)), "zbuffer", size=(8, 8))


@pytest.mark.parametrize("size", [(0, 8), (8, 0), (-1, 8), (8, 100_000)])
def test_size_out_of_range(make_scene: Any, size: tuple[int, int]) -> None:
    with pytest.raises(ViewError, match="width and height must be from 1 to 16384"):
        hsr.render(make_scene(CUBE), "zbuffer", size=size)


def test_unknown_camera_lists_the_known_ones(make_scene: Any) -> None:
    with pytest.raises(ViewError, match="no camera is named 'left'; the scene has main"):
        hsr.render(make_scene(CUBE), "zbuffer", camera="left")


def test_other_packages_register_methods(monkeypatch: pytest.MonkeyPatch, make_scene: Any) -> None:
    ours = Method("theirs", "somebody else's", "hsr.algorithms.scanline")

    class Entry:
        name, value = "theirs", "their.package:method"

        def load(self) -> Any:
            return ours

    monkeypatch.setattr(
        registry, "entry_points", lambda group: [Entry()] if group == "hsr.algorithms" else []
    )
    methods.cache_clear()
    try:
        assert hsr.render(make_scene(CUBE), "theirs", size=(8, 8)).method == "theirs"
        monkeypatch.setattr(Entry, "load", lambda _self: "not a method")
        methods.cache_clear()
        with pytest.raises(MethodError, match=r"their\.package:method must be an hsr\.Method, not str"):
            hsr.render(make_scene(CUBE), "theirs", size=(8, 8))
        assert "theirs" in registry.default_methods()
    finally:
        methods.cache_clear()


def test_a_path_is_no_scene() -> None:
    with pytest.raises(MethodError, match=r"takes a scene or a view, not str; read a file by hsr\.load"):
        hsr.render("scenes/cube.toml", "zbuffer")  # type: ignore[arg-type]


def test_the_default_is_one_of_each_family_and_every_peer(monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("paint", "paint-quick", "paint-list", "brush-gold")
    made = {name: Method(name, "", "nowhere", exhaustive=name.endswith("list")) for name in names}
    made["brush-gold"] = replace(made["brush-gold"], needs="gold")
    made["brush-old"] = replace(made["brush-gold"], asked_only=True)
    monkeypatch.setattr(registry, "methods", lambda: made)
    assert registry.default_methods() == ["paint", "paint-list", "brush-gold"]


def test_the_certified_are_two() -> None:
    assert registry.certified_methods() == ("zbuffer", "raycast")


@pytest.mark.parametrize("method", BUILT_IN, ids=lambda method: method.name)
def test_what_a_row_names_is_there(method: Method) -> None:
    method.options()
    assert (method.load_pipeline() is None) == (method.name == "exact")
    assert (method.load_probe() is None) == (method.name.partition("-")[0] in NOT_RECORDED)


def test_a_row_with_an_unknown_word_is_refused() -> None:
    with pytest.raises(MethodError, match="brush: growth 'fast' is none of"):
        Method("brush", "", "nowhere", growth="fast")
    with pytest.raises(MethodError, match=r"hsr\.algorithms\.scanline has no PIPELINE, which the row"):
        Method("brush", "", "nowhere", pipeline="hsr.algorithms.scanline").load_pipeline()
