from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib.metadata import PackagePath, PathDistribution
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms import embree
from hsr.base.errors import MethodError, UnavailableError
from hsr.embree import library, packets
from tests.gl.brute_force import assert_agrees


def test_without_embreex_it_says_what_to_install(make_scene: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "embreex", None)
    with pytest.raises(UnavailableError, match=r"pip install 'hsr-lab\[embree\]'"):
        hsr.render(make_scene([{"name": "cube", "shape": "cube"}]), "embree", size=(4, 4))


@pytest.fixture
def _installed() -> None:
    pytest.importorskip("embreex", reason="embreex is not installed")


METHODS = ("embree", "embree-packets", "embree-single")
LIBRARY = METHODS[1:]


def test_an_unknown_interface_is_refused() -> None:
    with pytest.raises(
        MethodError, match="embree has no interface 'sideways'; choose from embreex, single, packets"
    ):
        embree.Options("sideways")


CAMERAS: dict[str, dict[str, Any]] = {
    "to infinity": {"near": 0.5},
    "near and far cut": {"near": 4.6, "far": 6.0},
    "inside the scene": {"eye": [0.3, 0.2, 0.4], "near": 0.05, "fov": 90.0},
    "parallel": {"type": "orthographic", "height": 5.0, "near": -1.0, "far": 5.5},
}


def scene_with(make_scene: Any, camera: str, cull: str) -> hsr.Scene:
    turned = [{"rotate_x": 20.0}, {"rotate_y": 35.0}]
    objects = [
        {"name": "cube", "shape": "cube", "cull": cull, "transform": turned},
        {"name": "wall", "shape": "square", "transform": [{"scale": 1.7}, {"rotate_y": -50.0}]},
        {"name": "can", "shape": "cylinder", "cull": cull, "transform": [{"scale": [-0.5, 0.5, 2.0]}]},
    ]
    made: hsr.Scene = make_scene(objects, **CAMERAS[camera]).model_copy(update={"segments": 12})
    return made


@pytest.mark.usefixtures("_installed")
@pytest.mark.parametrize("cull", ["none", "back", "front"])
@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("method", METHODS)
def test_agrees_with_brute_force_where_no_edge_is_near(
    make_scene: Any, method: str, camera: str, cull: str
) -> None:
    view = hsr.view(scene_with(make_scene, camera, cull), (40, 30))
    answer = hsr.render(view, method)
    # A few roundings of float32 against distances of the size of the scene.
    assert_agrees(answer.face, answer.depth, view, relative=1e-5)


@pytest.mark.usefixtures("_installed")
def test_an_image_in_bands_is_the_image(make_scene: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    view = hsr.view(make_scene([{"name": "cube", "shape": "cube"}]), (16, 13))
    whole = hsr.render(view, "embree")
    monkeypatch.setattr(embree, "RAYS_AT_ONCE", 16 * 5)
    bands = hsr.render(view, "embree")
    np.testing.assert_array_equal(bands.face, whole.face)
    np.testing.assert_array_equal(bands.depth, whole.depth)


@pytest.mark.usefixtures("_installed")
@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("method", LIBRARY)
@pytest.mark.parametrize("size", [(1, 1), (3, 130), (41, 30)])
def test_the_library_traces_the_rays_that_embreex_does(
    make_scene: Any, method: str, camera: str, size: tuple[int, int]
) -> None:
    """Sizes that are no multiples of a packet's, and more rows of packets than shares."""
    view = hsr.view(scene_with(make_scene, camera, "none"), size)
    answer, expected = hsr.render(view, method), hsr.render(view, "embree")
    np.testing.assert_array_equal(answer.depth, expected.depth)
    # Of equally near triangles the last counts, and packets come to them in another order.
    if method == "embree-single":
        np.testing.assert_array_equal(answer.face, expected.face)


@pytest.mark.usefixtures("_installed")
def test_the_rays_of_a_packet_are_those_handed_to_embreex(make_scene: Any) -> None:
    """To the last bit of every origin and direction, in perspective and in parallel views."""
    for camera in CAMERAS:
        view = hsr.view(scene_with(make_scene, camera, "none"), (9, 7))
        _, origins, directions = next(embree.rays(view))
        packet = packets.packets_of(16)[0]
        packets._fill(packet, embree._sight(view), 4, 2, 3)
        for row, expected in ((packets.ORIGIN, origins), (packets.DIRECTION, directions)):
            square = expected.reshape(7, 9, 3)[2:6, 3:7].reshape(16, 3)
            np.testing.assert_array_equal(packet[row : row + 3], square.T)


@pytest.mark.usefixtures("_installed")
@pytest.mark.parametrize("method", LIBRARY)
def test_the_library_says_its_version_and_threads(make_scene: Any, method: str) -> None:
    answer = hsr.render(make_scene([{"name": "cube", "shape": "cube"}]), method, size=(8, 6))
    assert answer.method == method
    assert answer.notes["driver"].startswith("Embree 4.4.")
    assert answer.notes["threads"] >= 1
    assert answer.work == {"rays": 48, "triangles": 12}
    assert set(answer.seconds) == {"prepare", "build", "render"}


@pytest.fixture
def _fresh_library() -> Iterator[None]:
    for kept in (library.library, library.device):
        kept.cache_clear()
    yield
    for kept in (library.library, library.device):
        kept.cache_clear()


@pytest.mark.usefixtures("_fresh_library")
@pytest.mark.parametrize("found", [None, [], [PackagePath("numpy/nothing-embree4.so")]])
def test_without_its_library_it_says_what_to_install(
    make_scene: Any, monkeypatch: pytest.MonkeyPatch, found: list[PackagePath] | None
) -> None:
    for file in found or ():
        file.dist = PathDistribution(Path("nowhere"))
    monkeypatch.setattr(library, "files", lambda _name: found)
    with pytest.raises(UnavailableError, match=r"no library of Embree 4 .* pip install 'hsr-lab\[embree\]'"):
        hsr.render(make_scene([{"name": "cube", "shape": "cube"}]), "embree-packets", size=(4, 4))


@pytest.mark.usefixtures("_installed", "_fresh_library")
def test_another_version_of_the_library_is_refused(make_scene: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "VERSION", "4.5")
    with pytest.raises(UnavailableError, match=r"holds Embree 4\.4\.0, but only 4\.5 is known"):
        hsr.render(make_scene([{"name": "cube", "shape": "cube"}]), "embree-single", size=(4, 4))


@pytest.mark.usefixtures("_installed")
def test_what_the_library_cannot_do_is_an_error() -> None:
    device = library.device(1)
    library.library().rtcNewGeometry(device, 1234)
    with pytest.raises(MethodError, match="Embree fails"):
        library._check(device)


@pytest.mark.usefixtures("_installed")
def test_says_what_was_traced_and_how_long_it_took(make_scene: Any) -> None:
    answer = hsr.render(make_scene([{"name": "can", "shape": "cylinder"}]), "embree", size=(8, 6))
    assert answer.method == "embree"
    assert answer.work == {"rays": 48, "triangles": 2 * 48 + 2 * 46}
    assert set(answer.seconds) == {"prepare", "build", "render"}
    assert answer.notes["driver"].startswith("embreex ")
    assert answer.notes["depth_format"]["stored"] == "distance"
    assert answer.face.dtype == np.int32 and answer.depth.dtype == np.float64


@pytest.mark.usefixtures("_installed")
@pytest.mark.parametrize("method", METHODS)
def test_a_scene_of_which_nothing_is_left_is_background(make_scene: Any, method: str) -> None:
    away = {"name": "wall", "shape": "square", "cull": "back", "transform": [{"rotate_y": 180.0}]}
    answer = hsr.render(make_scene([away]), method, size=(8, 8))
    assert (answer.face == -1).all() and np.isposinf(answer.depth).all()
    assert answer.work["triangles"] == 0


@pytest.mark.usefixtures("_installed")
def test_coordinates_beyond_float32_are_one_clear_line(make_scene: Any) -> None:
    huge = {"name": "cube", "shape": "cube", "transform": [{"scale": 1e39}]}
    with pytest.raises(MethodError, match="beyond float32"):
        hsr.render(make_scene([huge]), "embree", size=(4, 4))
