"""One line of sight against the oracle of the whole image, and against distances known beforehand."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from hsr.base.errors import ViewError
from hsr.difference.nearby import check_sample, faces_nearby
from hsr.difference.sightline import _form_distance, pixels_to_zero, sightline, sightlines
from hsr.exact.decide import Piece
from hsr.exact.infinitesimals import NOTHING, I, J, Surd, constant
from hsr.exact.oracle import truth
from hsr.problem.map import BACKGROUND
from hsr.problem.view import View, view
from tests.exact.extreme import EXTREME, extreme

PARALLEL = {"type": "orthographic", "eye": [0.0, 0.0, 10.0], "height": 8.0, "near": 0.0, "far": 16.0}
"""With 8 x 8 samples: of (row r, column c) at x = c - 3.5, y = 3.5 - r; a pixel is one unit."""

CROWD: list[dict[str, Any]] = [
    {"shape": "cube", "name": "box", "transform": [{"rotate_y": 30.0}, {"translate": [-1.0, 0.0, 0.0]}]},
    {"shape": "sphere", "name": "ball", "cull": "front", "transform": [{"translate": [0.7, 0.4, 0.3]}]},
    {"shape": "cylinder", "name": "can", "transform": [{"rotate_x": 50.0}, {"translate": [0.0, -0.8, 0.5]}]},
    {"shape": "menger", "name": "sponge", "level": 1, "transform": [{"scale": 0.7}, {"rotate_x": 20.0}]},
    {"shape": "fir", "name": "tree", "transform": [{"scale": 3.0}, {"translate": [0.4, -1.5, 3.9]}]},
]
"""The tree reaches behind the eye of a camera at z = 4."""


def mesh(*corners: Any, **keys: Any) -> dict[str, Any]:
    faces = [[k, k + 1, k + 2] for k in range(0, len(corners), 3)]
    return {"shape": "mesh", "name": "m", "vertices": list(corners), "faces": faces, **keys}


def triangle_view(make_scene: Any, *objects: dict[str, Any], **camera: Any) -> View:
    return view(make_scene(list(objects), **{**PARALLEL, **camera}), (8, 8))


@pytest.mark.jit
@pytest.mark.parametrize("camera", [{"eye": [0.3, 0.4, 4.0], "near": 2.9, "far": 5.0}, PARALLEL])
def test_the_owner_is_that_of_the_whole_image(camera: dict[str, Any], make_scene: Any) -> None:
    seen = view(make_scene(CROWD, **camera), (40, 30))
    whole = truth(seen)
    for row, column in np.random.default_rng(0).integers(0, [30, 40], (60, 2)).tolist():
        here = sightline(seen, x=column, y=row)
        assert here.owner == whole.face[row, column]
        assert here.admissible == (whole.admissible.faces(row * 40 + column) or {here.owner})
        if here.owner >= 0:
            layer = here.of(here.owner)
            assert layer is not None and layer.depth is not None and not layer.removed
            assert float(layer.depth) == pytest.approx(whole.depth[row, column], rel=1e-15)


def test_nearby_keeps_every_face_the_sample_shows(make_scene: Any) -> None:
    seen = view(make_scene(CROWD, eye=[0.3, 0.4, 4.0]), (40, 30))
    nearby = faces_nearby(seen, np.array([15 * 40 + 20]))
    assert nearby.view.faces == len(nearby.origin) < seen.faces
    assert sightline(nearby.view, x=20, y=15).owner == nearby.origin.tolist().index(
        sightline(seen, x=20, y=15).owner
    )


def test_distances_facing_and_order(make_scene: Any) -> None:
    # The sample (row 3, column 3) is at (-0.5, 0.5).
    front = mesh((-2.0, 0.0, 1.0), (2.0, 0.0, 1.0), (-2.0, 4.0, 1.0))
    back = mesh((-2.0, 0.25, -2.0), (-2.0, 4.0, -2.0), (2.0, 0.25, -2.0), name="back")
    missing = mesh((-2.0, 1.25, 3.0), (2.0, 1.25, 3.0), (0.0, 4.0, 3.0), name="missing")
    seen = triangle_view(make_scene, back, missing, front)
    layers = sightline(seen, x=3, y=3).layers
    assert [layer.face for layer in layers] == [2, 0, 1]
    assert [layer.facing for layer in layers] == ["front", "back", "front"]
    assert [layer.depth for layer in layers] == [Fraction(9), Fraction(12), None]
    assert layers[0].edges == pytest.approx({"edge 0": 0.5, "edge 1": 2.0 / 2.0**0.5, "edge 2": 1.5})
    assert layers[1].nearest_edge == ("edge 2", 0.25)
    assert layers[2].nearest_edge == ("edge 0", -0.75)


def test_more_than_a_pixel_away_is_not_told(make_scene: Any) -> None:
    seen = triangle_view(make_scene, mesh((-2.0, 1.5, 3.0), (2.0, 1.5, 3.0), (0.0, 4.0, 3.0)))
    assert sightline(seen, x=3, y=3).layers == ()


@pytest.mark.parametrize(
    ("keys", "z", "removed"),
    [({"cull": "back"}, 1.0, ""), ({"cull": "front"}, 1.0, "culled"), ({}, 11.0, "near"), ({}, -7.0, "far")],
)
def test_what_is_culled_or_clipped_is_told(
    keys: dict[str, Any], z: float, removed: str, make_scene: Any
) -> None:
    seen = triangle_view(make_scene, mesh((-2.0, 0.0, z), (2.0, 0.0, z), (-2.0, 4.0, z), **keys))
    here = sightline(seen, x=3, y=3)
    (layer,) = here.layers
    assert layer.covered and layer.removed == removed
    assert here.owner == (-1 if removed else 0)


def test_both_sides_of_a_sphere_and_its_outline(make_scene: Any) -> None:
    ball = {"shape": "sphere", "name": "ball", "transform": [{"scale": 2.0}, {"translate": [-0.5, 0.5, 0.0]}]}
    seen = triangle_view(make_scene, ball)
    front, back = sightline(seen, x=4, y=3).layers  # one unit to the right of the middle
    assert (front.facing, back.facing) == ("front", "back")
    assert [float(layer.depth or 0) for layer in (front, back)] == pytest.approx([10 - 3**0.5, 10 + 3**0.5])
    # To first order: (r^2 - x^2) / 2 x, with r = 2 and x = 1.
    assert front.edges == pytest.approx({"outline": 1.5})


def test_the_rims_of_a_cylinder(make_scene: Any) -> None:
    can = {"shape": "cylinder", "name": "can", "transform": [{"rotate_x": -90.0}, {"scale": [2.0, 3.0, 2.0]}]}
    # Its side is seen from y = 0 to y = 3; row 2 is at y = 1.5, row 4 at y = -0.5.
    seen = triangle_view(make_scene, can)
    side = sightline(seen, x=3, y=2).of(0)
    assert side is not None and side.edges["base rim"] == pytest.approx(1.5)
    assert side.edges["cap rim"] == pytest.approx(1.5)
    below = sightline(seen, x=3, y=4).of(0)
    assert below is not None and not below.covered and below.nearest_edge == ("base rim", pytest.approx(-0.5))


def test_edge_on_faces_are_told_and_cover_nothing(make_scene: Any) -> None:
    seen = triangle_view(make_scene, mesh((-2.0, 0.5, 0.0), (2.0, 0.5, 0.0), (0.0, 0.5, 3.0)))
    (layer,) = sightline(seen, x=3, y=3).layers
    assert layer.facing == "edge-on" and not layer.covered


def test_ties_are_told(make_scene: Any) -> None:
    # Both triangles have the sample on their common side.
    left = mesh((-0.5, -3.0, 0.0), (-0.5, 3.0, 0.0), (-3.0, 0.0, 0.0))
    right = mesh((-0.5, -3.0, 0.0), (3.0, 0.0, 0.0), (-0.5, 3.0, 0.0), name="right")
    here = sightline(triangle_view(make_scene, left, right), x=3, y=3)
    assert (here.owner, here.admissible) == (1, {0, 1})


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (
            [(-3.0, 0.5, 0.0), (3.0, 0.5, 0.0), (0.0, 3.0, 0.0)],
            [(-3.0, 0.5, 0.0), (0.0, -3.0, 0.0), (3.0, 0.5, 0.0)],
        ),
        (
            [(-0.5, -3.0, 0.0), (-0.5, 3.0, 0.0), (-3.0, 0.0, 0.0)],
            [(-0.5, -3.0, 0.0), (3.0, 0.0, 0.0), (-0.5, 3.0, 0.0)],
        ),
    ],
)
def test_a_side_through_the_sample_belongs_to_what_is_below_and_to_the_right(
    one: list[Any], other: list[Any], make_scene: Any
) -> None:
    seen = triangle_view(make_scene, mesh(*one), mesh(*other, name="other"))
    assert [layer.covered for layer in map(sightline(seen, x=3, y=3).of, (0, 1)) if layer] == [False, True]


def agrees(seen: View) -> None:
    """Check some samples against the whole image."""
    whole = truth(seen)
    for sample, found in sightlines(faces_nearby(seen, np.arange(0, whole.face.size, 7))).items():
        owner = found.of(found.owner)
        assert found.owner == whole.face.flat[sample]
        assert found.owner == BACKGROUND or (owner is not None and owner.covered)


@pytest.mark.parametrize("name", EXTREME)
def test_extreme_numbers_do_not_overflow(name: str) -> None:
    agrees(EXTREME[name]())


def test_extreme_views_do_not_overflow() -> None:
    for seed in range(20):
        agrees(extreme(seed, curved=True))


def test_distances_to_a_form_are_those_of_its_gradient() -> None:
    # -1 + 2 (i + j) / j at (3, 4) is 2.5, and its gradient (2 / 4, -6 / 16) is 0.625 long, by half pixels.
    quotient = Piece(0, (), Surd(I + J, NOTHING, NOTHING, J))
    assert _form_distance(quotient, (constant(-1), constant(2)), 3, 4) == pytest.approx(2.0)
    # sqrt(i^2 + j^2) - 6 is -1, and its gradient 1 long.
    root = Piece(0, (), Surd(NOTHING, constant(1), I * I + J * J, constant(1)))
    assert _form_distance(root, (constant(-6), constant(1)), 3, 4) == pytest.approx(-0.5)


@pytest.mark.parametrize(
    ("value", "square", "distance"),
    [(-6, 9, -1.0), (0, 0, math.inf), (-1, 0, -math.inf), (2**600, 9, math.inf), (-(2**600), 9, -math.inf)],
    ids=["near", "flat, zero", "flat, below zero", "far", "far below zero"],
)
def test_values_far_from_zero_are_infinitely_far(value: int, square: int, distance: float) -> None:
    assert pixels_to_zero(value, square) == distance


def test_an_empty_line_of_sight(make_scene: Any) -> None:
    here = sightline(
        triangle_view(make_scene, mesh((2.0, 2.0, 0.0), (3.0, 2.0, 0.0), (2.0, 3.0, 0.0))), x=0, y=7
    )
    assert (here.owner, here.admissible, here.layers) == (-1, {-1}, ())


@pytest.mark.parametrize(("row", "column"), [(-1, 0), (0, 8), (8, 0)])
def test_a_sample_outside_is_one_line(row: int, column: int, make_scene: Any) -> None:
    seen = triangle_view(make_scene, mesh((2.0, 2.0, 0.0), (3.0, 2.0, 0.0), (2.0, 3.0, 0.0)))
    with pytest.raises(ViewError, match=f"no sample at column {column}, row {row}: the image is 8x8"):
        check_sample(seen, column, row)
