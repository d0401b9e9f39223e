"""Pictures of maps: colours worked out by hand on a cube, normals of every shape."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.errors import HsrError
from hsr.pages.shading import facing, shade
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View
from hsr.scene.model import Scene


def seen(
    thing: dict[str, Any], eye: list[float], lights: list[dict[str, Any]], side: int = 1, **more: Any
) -> View:
    """View one object that is ``side`` pixels wide, from ``eye``, lit by ``lights``."""
    camera = {"type": "perspective", "eye": eye, **more}
    tables = {"hsr": 1, "camera": [camera], "object": [{"name": "it", **thing}], "light": lights}
    return hsr.view(Scene.model_validate(tables), (side, side))


def centre(view: View, face: int, depth: float) -> list[int]:
    """Colour of a one-pixel map."""
    answer = VisibilityMap(np.array([[face]], np.int32), np.array([[depth]]), "by hand")
    return [int(channel) for channel in shade(answer, view)[0, 0]]


def srgb(linear: float) -> int:
    return round(255 * (1.055 * linear ** (1 / 2.4) - 0.055))


@pytest.mark.parametrize("size", [1e-85, 1.0, 1e85])
def test_a_mesh_of_any_size_looks_the_same(size: float) -> None:
    corners = [[-size, -size, 0.0], [size, -size, 0.0], [0.0, size, 0.0]]
    mesh = {"shape": "mesh", "vertices": corners, "faces": [[0, 1, 2]], "colour": [1.0, 1.0, 1.0]}
    view = seen(mesh, [0.0, 0.0, 2.0 * size], [], near=size)
    assert centre(view, 0, 2.0 * size) == [255, 255, 255]


CUBE = {"shape": "cube", "colour": [1.0, 1.0, 1.0]}
FRONT, TOP = 4, 0
OBLIQUE = [0.0, 3.0, 4.0]  # 5 from the origin; sees the front face at a cosine of 4 / 5


def test_without_lights_the_facing_ratio_decides() -> None:
    assert centre(seen(CUBE, [0.0, 0.0, 5.0], []), FRONT, 4.0) == [255] * 3
    assert centre(seen(CUBE, OBLIQUE, []), FRONT, 4.0) == [srgb(0.8)] * 3
    assert centre(seen(CUBE, OBLIQUE, []), TOP, 4.0) == [srgb(0.6)] * 3


def test_lambert_of_directional_and_ambient_light() -> None:
    ambient = {"type": "ambient", "colour": [0.25, 0.0, 0.5]}
    lamp = {"type": "directional", "direction": [0.0, -0.6, -0.8], "colour": [0.5, 0.5, 0.5]}
    view = seen(CUBE, OBLIQUE, [ambient, lamp])
    assert centre(view, FRONT, 4.0) == [srgb(0.25 + 0.4), srgb(0.4), srgb(0.5 + 0.4)]
    assert centre(view, TOP, 4.0) == [srgb(0.25 + 0.3), srgb(0.3), srgb(0.5 + 0.3)]


def test_light_from_behind_adds_nothing() -> None:
    lamp = {"type": "directional", "direction": [0.0, 0.0, 1.0]}
    assert centre(seen(CUBE, [0.0, 0.0, 5.0], [lamp]), FRONT, 4.0) == [0, 0, 0]


def test_point_light_shines_from_its_place() -> None:
    lamp = {"type": "point", "position": [0.0, 4.0, 4.0], "colour": [1.0, 1.0, 1.0]}
    # From (0, 0, 1) the light is toward (0, 4, 3) / 5.
    assert centre(seen(CUBE, [0.0, 0.0, 5.0], [lamp]), FRONT, 4.0) == [srgb(0.6)] * 3


def test_full_light_gives_colours_as_written() -> None:
    thing = {"shape": "cube", "colour": [0.9, 0.5, 0.2]}
    lamp = {"type": "ambient", "colour": [1.0, 1.0, 1.0]}
    assert centre(seen(thing, [0.0, 0.0, 5.0], [lamp]), FRONT, 4.0) == [230, 128, 51]


def test_too_much_light_is_cut_off() -> None:
    lamps = [{"type": "ambient", "colour": [1.0, 1.0, 1.0]}] * 3
    assert centre(seen(CUBE, [0.0, 0.0, 5.0], lamps), FRONT, 4.0) == [255] * 3


def test_both_sides_of_a_face_are_lit_alike() -> None:
    square = {"shape": "square", "colour": [1.0, 1.0, 1.0]}
    assert centre(seen(square, [0.0, 0.0, -5.0], []), 0, 5.0) == [255] * 3


def test_background_is_as_written() -> None:
    assert centre(seen(CUBE, [0.0, 0.0, 5.0], []), -1, math.inf) == [255, 255, 255]


TILTED = [{"rotate_x": 60.0}]


@pytest.mark.parametrize(
    ("thing", "face", "depth", "cosine"),
    [
        ({"shape": "sphere"}, 0, 4.0, 1.0),
        ({"shape": "sphere", "transform": [{"scale": [5.0, 3.0, 1.0]}]}, 0, 4.0, 1.0),
        ({"shape": "cylinder", "transform": TILTED}, 2, 4.0, 0.5),
        ({"shape": "cylinder", "transform": TILTED}, 1, 5.0, 0.5),
        ({"shape": "cylinder", "transform": [{"rotate_x": 90.0}]}, 0, 4.0, 1.0),
        ({"shape": "cylinder", "top": 0.0, "transform": [{"rotate_x": 90.0}]}, 0, 4.0, math.sqrt(0.5)),
        ({"shape": "cylinder", "top": 2.0, "transform": TILTED}, 2, 4.0, 0.5),
        (
            {"shape": "cube", "transform": [{"scale": [1.0, 1.0, 4.0]}, *TILTED]},
            0,
            4.0,
            math.sqrt(0.75),
        ),
    ],
)
def test_normals_of_shapes(thing: dict[str, Any], face: int, depth: float, cosine: float) -> None:
    view = seen({"colour": [1.0, 1.0, 1.0], **thing}, [0.0, 0.0, 5.0], [])
    assert centre(view, face, depth) == [srgb(cosine)] * 3


def test_normals_are_carried_by_the_inverse_transpose() -> None:
    # A ball squeezed to half along z: at (x, 0, z) = (0.6, 0, 0.4) the normal is along (0.6, 0, 1.6).
    thing = {"shape": "sphere", "colour": [1.0, 1.0, 1.0], "transform": [{"scale": [1.0, 1.0, 0.5]}]}
    view = seen(thing, [0.6, 0.0, 5.0], [], target=[0.6, 0.0, 0.0])
    assert centre(view, 0, 4.6) == [srgb(1.6 / math.hypot(0.6, 1.6))] * 3


def test_a_ball_darkens_toward_its_rim_on_all_sides_alike() -> None:
    view = seen({"shape": "sphere"}, [0.0, 0.0, 5.0], [], side=9, fov=20.0)
    answer = VisibilityMap(np.zeros((9, 9), np.int32), np.full((9, 9), 4.3), "by hand")
    picture = shade(answer, view).astype(int)
    assert (picture[4, 4] > picture[4, 6]).all() and (picture[4, 6] > picture[4, 8]).all()
    for mirrored in (picture[::-1], picture[:, ::-1], picture.transpose(1, 0, 2)):
        assert abs(picture - mirrored).max() <= 1


@pytest.mark.parametrize(
    ("thing", "eye", "expected"),
    [
        ({"shape": "cube"}, [0.3, 0.4, 5.0], {1}),
        ({"shape": "cube", "transform": [{"scale": [-1.0, 1.0, 1.0]}]}, [0.3, 0.4, 5.0], {1}),
        ({"shape": "square"}, [0.3, 0.4, -5.0], {-1}),
        ({"shape": "sphere"}, [0.3, 0.4, 5.0], {1}),
        ({"shape": "sphere", "transform": [{"scale": [9.0, 9.0, -9.0]}]}, [0.3, 0.4, 5.0], {-1}),
        ({"shape": "cylinder"}, [0.3, 0.4, 5.0], {1}),
        ({"shape": "cylinder"}, [0.3, 0.4, -5.0], {1}),
        (
            {"shape": "cylinder", "transform": [{"scale": 20.0}, {"translate": [0.0, 0.0, -10.0]}]},
            [0.3, 0.4, 5.0],
            {-1},
        ),
    ],
)
def test_the_side_that_is_seen(
    thing: dict[str, Any], eye: list[float], expected: set[int], make_scene: Any
) -> None:
    view = hsr.view(make_scene([{"name": "thing", **thing}], eye=eye), (24, 24))
    seen = hsr.render(view, "exact")
    side = facing(seen, view)
    assert np.array_equal(side == 0, seen.face < 0) and set(side[side != 0].tolist()) == expected


def test_many_objects_keep_their_own_colours(make_scene: Any) -> None:
    colours = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
    things = [{"name": f"s{k}", "shape": "square", "colour": list(c)} for k, c in enumerate(colours)]
    view = hsr.view(make_scene(things, eye=[0.0, 0.0, 100.0], fov=1.0), (3, 2))
    face = np.array([[2, 0, 1], [0, -1, 2]], np.int32)
    picture = shade(VisibilityMap(face, np.where(face < 0, np.inf, 100.0), "by hand"), view)
    shown = np.where((face < 0)[..., None], 1.0, np.array(colours)[face])
    assert np.array_equal(picture > 128, shown > 0.5)


def test_map_and_view_must_have_one_size() -> None:
    answer = VisibilityMap(np.zeros((2, 3), np.int32), np.ones((2, 3)), "by hand")
    with pytest.raises(HsrError, match="cannot shade a 3x2 map with a 1x1 view"):
        shade(answer, seen(CUBE, [0.0, 0.0, 5.0], []))
