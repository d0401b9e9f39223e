from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.errors import MethodError, NoOpenGLError
from hsr.gl.depth import DEPTH_BUFFERS
from tests.gl.brute_force import assert_agrees
from tests.gl.conftest import opened


@pytest.fixture(autouse=True, scope="module")
def _needs_opengl() -> None:
    opened("auto").release()


CAMERAS: dict[str, dict[str, Any]] = {
    "to infinity": {"near": 0.5},
    "near and far cut": {"near": 4.6, "far": 6.0},
    "inside the scene": {"eye": [0.3, 0.2, 0.4], "near": 0.05, "fov": 90.0},
    "parallel": {"type": "orthographic", "height": 5.0, "near": -1.0, "far": 5.5},
}


def objects(cull: str = "none") -> list[dict[str, Any]]:
    turned = [{"rotate_x": 20.0}, {"rotate_y": 35.0}]
    return [
        {"name": "cube", "shape": "cube", "cull": cull, "transform": turned},
        {"name": "wall", "shape": "square", "transform": [{"scale": 1.7}, {"rotate_y": -50.0}]},
        {"name": "ball", "shape": "sphere", "cull": cull, "transform": [{"translate": [0.9, 0.7, 0.6]}]},
        {"name": "can", "shape": "cylinder", "transform": [{"scale": [-0.5, 0.5, 2.0]}, *turned]},
    ]


@pytest.mark.parametrize("cull", ["none", "back", "front"])
@pytest.mark.parametrize("camera", CAMERAS)
def test_agrees_with_brute_force_where_no_edge_is_near(make_scene: Any, camera: str, cull: str) -> None:
    scene = make_scene(objects(cull), **CAMERAS[camera]).model_copy(update={"segments": 12})
    view = hsr.view(scene, (40, 30))
    answer = hsr.render(view, "opengl")
    # Of a depth z a step of 24 bits is at most step * z**2 / near, two steps with the driver's
    # arithmetic; near = 0.05 and z = 3 make 4e-6 of z.
    assert_agrees(answer.face, answer.depth, view, relative=1e-5)


@pytest.mark.parametrize("camera", ["to infinity", "near and far cut", "parallel"])
@pytest.mark.parametrize("kept", DEPTH_BUFFERS)
def test_every_depth_format_draws_the_same(make_scene: Any, kept: str, camera: str) -> None:
    scene = make_scene(objects(), **CAMERAS[camera]).model_copy(update={"segments": 12})
    view = hsr.view(scene, (40, 30))
    try:
        answer = hsr.render(view, "opengl", depth_format=kept)
    except NoOpenGLError as error:
        pytest.skip(str(error))
    # Two steps of 16 bits, 2 step z**2 / near; near = 0.5 and z = 6 make 4e-4 of z.
    assert_agrees(answer.face, answer.depth, view, relative=5e-4)


@pytest.mark.parametrize(
    ("kept", "apart"), [("d24", 0), ("d32f", 0), ("d32f-reversed-ndc", 0), ("d32f-reversed", 1)]
)
def test_only_reversed_floats_from_0_to_1_resolve_what_is_far(make_scene: Any, kept: str, apart: int) -> None:
    """Two walls 1000 near distances away, 2**-9 apart: 32 spacings of float32, a thirtieth of a D24 step."""
    walls = [
        {"name": name, "shape": "square", "transform": [{"scale": 2000.0}, {"translate": [0.0, 0.0, z]}]}
        for name, z in (("far", -1000.0 - 2.0**-9), ("near", -1000.0))
    ]
    scene = make_scene(walls, eye=[0.0, 0.0, 0.0], target=[0.0, 0.0, -1.0], near=1.0)
    try:
        answer = hsr.render(scene, "opengl", size=(8, 8), depth_format=kept)
    except NoOpenGLError as error:
        pytest.skip(str(error))
    assert (answer.face == apart).all()


def test_says_what_drew_and_how_long_it_took(make_scene: Any) -> None:
    answer = hsr.render(make_scene([{"name": "cube", "shape": "cube"}], near=0.5), "opengl", size=(8, 8))
    assert answer.method == "opengl"
    assert answer.work == {"triangles": 12, "vertices": 8}
    assert set(answer.seconds) == {"prepare", "render", "read"}
    assert answer.notes["backend"] in ("osmesa", "egl")
    assert answer.notes["driver"] and answer.notes["subpixel_bits"] >= 4
    assert answer.notes["depth_format"]["step"] == 1.0 / (2**24 - 1)
    assert (answer.notes["depth_format"]["near"], answer.notes["depth_format"]["far"]) == (0.5, None)


def test_the_backend_can_be_chosen(make_scene: Any) -> None:
    view = hsr.view(make_scene(objects()), (64, 48))
    maps = []
    for backend in ("osmesa", "egl"):
        opened(backend).release()
        maps.append(hsr.render(view, "opengl", backend=backend))
        assert maps[-1].notes["backend"] == backend
    if maps[0].notes["driver"] == maps[1].notes["driver"]:
        np.testing.assert_array_equal(maps[0].face, maps[1].face)
        np.testing.assert_array_equal(maps[0].depth, maps[1].depth)


def test_an_unknown_depth_format_is_refused(make_scene: Any) -> None:
    with pytest.raises(MethodError, match="opengl has no depth_format 'd8'; choose from d16, d24, d32f"):
        hsr.render(make_scene(objects()), "opengl", size=(8, 8), depth_format="d8")


def test_an_unknown_backend_is_refused() -> None:
    with pytest.raises(
        MethodError, match=r"no backend 'glx'; did you mean 'egl'\? choose from auto, osmesa, egl"
    ):
        hsr.methods()["opengl"].options(backend="glx")


@pytest.mark.skipif(sys.platform != "linux", reason="reads memory and handles in /proc")
def test_thousands_of_renders_leave_no_trace(make_scene: Any) -> None:
    view = hsr.view(make_scene([{"name": "cube", "shape": "cube"}]), (16, 16))

    def traces() -> tuple[int, int]:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * 4096, len(list(Path("/proc/self/fd").iterdir()))

    for _ in range(300):
        hsr.render(view, "opengl")
    memory, handles = traces()
    for _ in range(3000):
        hsr.render(view, "opengl")
    later_memory, later_handles = traces()
    assert later_handles == handles
    # The 16 x 16 samples and 12 triangles of one render are 2.5 kB: 3000 of them would be 7.5 MB.
    assert later_memory - memory < 2**21
