"""Exact decisions against answers written by hand, brute force in fractions, and the oracle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal, localcontext
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

import hsr
from hsr.base.arrays import Array
from hsr.certify import Resolved, decision, first_pieces, resolve
from hsr.certify.curved import rounded
from hsr.certify.frame import integers
from hsr.exact.oracle import truth
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View, view
from tests.conftest import SCENES
from tests.exact import brute
from tests.exact.cones import CONES as CONE_VIEWS
from tests.exact.hard import CONES, CURVED, PLANAR, hard_view, loose_view, scene

Maker = Callable[[int, tuple[str, ...]], View]

LOOKING_DOWN = {"type": "orthographic", "eye": [0.0, 0.0, 3.0], "height": 4.0, "near": 0.0, "far": 9.0}
"""The samples of 4 x 4 are at x, y = -1.5, -0.5, 0.5, 1.5; those of 5 x 5 at -1.6, -0.8, 0, 0.8, 1.6."""


def seen(objects: list[dict[str, Any]], side: int = 4, **camera: Any) -> View:
    return view(scene(objects, {**LOOKING_DOWN, **camera}), (side, side))


def asked(view: View, candidates: Array, shuffle: int = 0) -> Resolved:
    """Decide every sample, all of ``candidates`` unsure at each, in some order."""
    samples = view.width * view.height
    sample = np.repeat(np.arange(samples), len(candidates))
    piece = np.tile(candidates.astype(np.int32), samples)
    order = np.random.default_rng(shuffle).permutation(len(sample))
    return resolve(view, sample[order], piece[order], np.zeros(len(sample), dtype=bool))


def everything(view: View) -> Resolved:
    return asked(view, np.arange(first_pieces(view.geometry)[-1]))


def owners(view: View) -> list[list[int]]:
    return everything(view).face.reshape(view.height, view.width).tolist()


def moved(*by: float, shape: str = "square", **keys: Any) -> dict[str, Any]:
    return {"shape": shape, "transform": [{"translate": list(by)}], **keys}


def sheared(x: float, y: float) -> dict[str, Any]:
    """The square |x|, |y| <= 1 in the plane of these slopes of z."""
    matrix = np.eye(4)
    matrix[2, :2] = x, y
    return {"shape": "square", "transform": [{"matrix": matrix.tolist()}]}


# ---------------------------------------------------------------- what goes in and comes out


def test_pieces_are_numbered_object_by_object() -> None:
    shapes = ["square", "sphere", "cylinder", "cube"]
    assert first_pieces(seen([{"shape": shape} for shape in shapes]).geometry) == [0, 2, 3, 6, 18]
    flat = seen([{"shape": shape} for shape in shapes]).tessellated()
    assert first_pieces(flat.geometry)[-1] == len(flat.polygons.triangle_vertex)


def test_samples_come_back_once_and_ascending() -> None:
    view_ = seen([{"shape": "square"}])
    found = resolve(
        view_,
        np.array([9, 0, 5, 9, 5, 9]),
        np.array([1, 0, 0, 0, 1, 1], dtype=np.int32),
        np.zeros(6, dtype=bool),
    )
    assert found.sample.tolist() == [0, 5, 9]
    assert found.face.tolist() == [-1, 0, 0]
    assert found.depth.tolist() == [np.inf, 3.0, 3.0]
    assert (found.sample.dtype, found.face.dtype, found.depth.dtype) == (np.int64, np.int32, np.float64)


def test_nothing_asked_is_nothing_found() -> None:
    none = np.zeros(0, dtype=np.int32)
    found = resolve(seen([{"shape": "square"}]), none, none, none.astype(bool))
    assert [len(column) for column in (found.sample, found.face, found.depth)] == [0, 0, 0]


def test_what_is_sure_is_not_asked_again() -> None:
    # Only the first sample is outside the square; the claim that it is inside is taken at its word.
    view_ = seen([{"shape": "square"}])
    sample, piece = np.array([0, 5]), np.array([0, 0], dtype=np.int32)
    assert resolve(view_, sample, piece, np.array([True, True])).face.tolist() == [0, 0]


@pytest.mark.parametrize("camera", [LOOKING_DOWN, {"type": "perspective", "eye": [0.0, 0.0, 3.0]}])
def test_what_is_sure_all_along_a_row_is_as_if_it_were_not(camera: dict[str, Any]) -> None:
    # Two triangles of one slanting plane cover the image; a third is before part of it.
    corners = [[-90.0, -90.0, -45.0], [90.0, -90.0, 9.0], [0.0, 90.0, 18.0]]
    slanting = {"shape": "mesh", "vertices": corners, "faces": [[0, 1, 2], [0, 1, 2]]}
    view_ = view(scene([slanting, sheared(0.25, 0.5)], camera), (7, 4))
    sample, piece = np.repeat(np.arange(28), 2), np.tile(np.array([1, 0], np.int32), 28)
    # Some samples have a third candidate, which is not sure.
    sample, piece = np.append(sample, [8, 9, 10, 20]), np.append(piece, np.full(4, 3, np.int32))
    unsure = resolve(view_, sample, piece, np.zeros(60, bool))
    sure = resolve(view_, sample, piece, piece < 2)
    assert sure.sample.tolist() == list(range(28))
    assert (sure.face[8], sure.face[10]) == (0, 2)
    assert len(set(sure.depth.round(9))) > 7
    assert (sure.face == unsure.face).all()
    assert (sure.depth == unsure.depth).all()


@pytest.mark.parametrize("shapes", [PLANAR, CURVED, CONES], ids=["planar", "curved", "cones"])
def test_small_chunks_give_the_same_answer(shapes: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    view_ = hard_view(5, shapes)
    whole = everything(view_)
    monkeypatch.setattr(decision, "CHUNK", 7)
    monkeypatch.setattr(decision, "KEPT", 2)
    cut = everything(view_)
    for column in ("sample", "face", "depth"):
        assert (getattr(whole, column) == getattr(cut, column)).all()


# ---------------------------------------------------------------- planar, by hand


def test_samples_on_an_edge_go_to_the_right_and_down() -> None:
    # Of the rim, through rows and columns 0 and 2, top and left belong to the square.
    assert owners(seen([moved(-0.5, 0.5, 0.0)])) == [
        [0, 0, -1, -1],
        [0, 0, -1, -1],
        [-1, -1, -1, -1],
        [-1, -1, -1, -1],
    ]


def test_two_triangles_share_each_sample_of_their_edge_once() -> None:
    corners = [[-2, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]]
    halves = {"shape": "mesh", "vertices": corners, "faces": [[0, 1, 2], [0, 2, 3]]}
    # The diagonal runs through samples; to the right of them is the lower half.
    assert owners(seen([halves])) == [[1, 1, 1, 0], [1, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0]]


@pytest.mark.parametrize(
    ("slope", "inside"),
    [
        # Depth 3 - x / 2 falls to the right: at x = 0 it is about to be nearer than 3.
        ((0.5, 0.0), {"near": [[0, -1, -1]] * 3, "far": [[-1, 0, 0]] * 3}),
        # Depth 3 - y / 2 grows downwards.
        ((0.0, 0.5), {"near": [[-1] * 3, [0] * 3, [0] * 3], "far": [[0] * 3, [-1] * 3, [-1] * 3]}),
        # Closed where the whole face is at that depth.
        ((0.0, 0.0), {"near": [[0] * 3] * 3, "far": [[0] * 3] * 3}),
    ],
    ids=["falling to the right", "growing downwards", "constant"],
)
@pytest.mark.parametrize("limit", ["near", "far"])
def test_near_and_far_are_decided_in_the_limit(slope: Any, inside: Any, limit: str) -> None:
    face = np.array(owners(seen([sheared(*slope)], 5, **{limit: 3.0})))
    assert face[1:4, 1:4].tolist() == inside[limit]


@pytest.mark.parametrize("sure", [True, False])
@pytest.mark.parametrize(
    ("slopes", "sample", "owner"),
    [
        ([(0.5, 0.25), (0.5, 0.25)], 7, 0),
        # They cross in the column x = 0; to the right of it the one that rises is nearer.
        ([(-0.5, 0.0), (0.5, 0.0)], 7, 1),
        ([(0.5, 0.0), (-0.5, 0.0)], 7, 0),
        # They cross in the row y = 0; below it the one that rises less is nearer.
        ([(0.0, 0.5), (0.0, 0.25)], 11, 1),
        ([(0.0, 0.25), (0.0, 0.5)], 11, 0),
    ],
)
def test_of_two_planes_at_one_depth(slopes: Any, sample: int, owner: int, sure: bool) -> None:
    # Samples 7 and 11 of 5 x 5 are at (0, 0.8) and (-0.8, 0), within the upper left triangles 1 and 3.
    view_ = seen([sheared(*slope) for slope in slopes], 5)
    piece, claim = np.array([3, 1], dtype=np.int32), np.array([sure, sure])
    assert resolve(view_, np.array([sample, sample]), piece, claim).face.tolist() == [owner]


def test_a_difference_beyond_float64_counts() -> None:
    lifted = moved(0.0, 0.0, 2.0**-60)
    found = everything(seen([{"shape": "square"}, lifted], 5))
    assert found.face[12] == 1
    assert found.depth[12] == 3.0


@pytest.mark.parametrize("camera", [LOOKING_DOWN, {"type": "perspective", "eye": [0.0, 0.0, 5.0]}])
def test_a_face_seen_edge_on_covers_nothing(camera: dict[str, Any]) -> None:
    for axis in "xy":
        edge_on = {"shape": "square", "transform": [{f"rotate_{axis}": 90.0}]}
        view_ = view(scene([edge_on], camera), (5, 5))
        assert (everything(view_).face == -1).all()


@pytest.mark.parametrize("scale", [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, -1.0], [-1.0, 1.0, -1.0]])
@pytest.mark.parametrize(("cull", "owner", "depth"), [("none", 4, 2.0), ("back", 4, 2.0), ("front", 5, 4.0)])
def test_mirroring_does_not_change_what_is_culled(scale: Any, cull: str, owner: int, depth: float) -> None:
    # The front of a cube is at z = 1; turned over along z, its back is.
    view_ = seen([{"shape": "cube", "cull": cull, "transform": [{"scale": scale}]}], 5)
    found = everything(view_)
    turned = scale[2] < 0
    assert (found.face[12], found.depth[12]) == (owner ^ turned, depth)


def test_corners_behind_the_eye() -> None:
    eye = {
        "type": "perspective",
        "eye": [0.0, 1.0, 0.0],
        "target": [0.0, 1.0, -1.0],
        "near": 0.125,
        "far": 32.0,
    }
    # One corner is behind the eye; a division by its w would put the triangle above the horizon.
    corners = [[0.0, -1.0, 8.0], [9.0, -1.0, -8.0], [-9.0, -1.0, -8.0]]
    view_ = view(scene([{"shape": "mesh", "vertices": corners, "faces": [[0, 1, 2]]}], eye), (6, 6))
    face = np.array(owners(view_))
    assert (face[:3] == -1).all()
    assert (face[4:] == 0).any()
    assert face.tolist() == brute.over_all(view_, brute.owner)


# ---------------------------------------------------------------- by what must not matter


@pytest.mark.parametrize("shapes", [PLANAR, CURVED, CONES], ids=["planar", "curved", "cones"])
def test_the_scale_of_clip_space_does_not_matter(shapes: tuple[str, ...]) -> None:
    for seed in range(10):
        view_ = hard_view(seed, shapes)
        found, scaled = (
            everything(view_),
            everything(replace(view_, clip_from_world=4.0 * view_.clip_from_world)),
        )
        assert (found.face == scaled.face).all()
        assert (found.depth == scaled.depth).all()


# ---------------------------------------------------------------- curved, by hand


def test_an_outline_through_samples_follows_the_limit() -> None:
    # The outline of the ball about (1, 1) runs through four samples. Only from the left one does a step
    # to the right lead into it; above, it leaves before d leads down.
    ball = moved(-0.5, 0.5, 0.0, shape="sphere")
    assert np.argwhere(np.array(owners(seen([ball]))) == 0).tolist() == [[1, 0], [1, 1]]
    found = everything(seen([ball]))
    assert found.depth.reshape(4, 4)[1, :2].tolist() == [3.0, 2.0]


@pytest.mark.parametrize(("cull", "face", "depth"), [("none", 2, 2.0), ("back", 2, 2.0), ("front", 1, 3.0)])
def test_a_cylinder_along_its_axis_shows_no_side(cull: str, face: int, depth: float) -> None:
    found = everything(seen([moved(-0.5, 0.5, 0.0, shape="cylinder", cull=cull)]))
    assert np.flatnonzero(found.face >= 0).tolist() == [4, 5]
    assert set(found.face) == {face, -1}
    assert found.depth[5] == depth


def test_rims_hit_exactly() -> None:
    # The axis runs along x from -0.5 to 0.5, the outline of the side from y = -0.5 to 1.5: all through
    # samples. Base and cap are seen edge-on.
    turned = {
        "shape": "cylinder",
        "transform": [{"rotate_y": 90.0}, {"translate": [-0.5, 0.5, 0.0]}],
    }
    view_ = seen([turned])
    assert owners(view_) == [[-1, 0, -1, -1], [-1, 0, -1, -1], [-1, -1, -1, -1], [-1, -1, -1, -1]]
    assert owners(view_) == brute.over_all(view_, brute.owner)


@pytest.mark.parametrize("name", CONE_VIEWS)
def test_cones_are_what_they_are_by_brute_force(name: str) -> None:
    found, exact = everything(CONE_VIEWS[name]), truth(CONE_VIEWS[name])
    assert owners(CONE_VIEWS[name]) == exact.face.tolist()
    assert found.depth.reshape(exact.depth.shape) == pytest.approx(exact.depth, rel=2.0**-52)


@pytest.mark.parametrize(("name", "depth"), [("parallel, downward", 3.0), ("from above", 2.0)])
def test_beside_a_line_on_a_cone_its_apex_is_met(name: str, depth: float) -> None:
    # In the middle the equation of the hit is 0 / 0; to the right and below, it is hit close to the apex.
    view_ = CONE_VIEWS[f"along a generator of 0.0, left, {name}"]
    assert (everything(view_).face[12], everything(view_).depth[12]) == (0, depth)
    assert (truth(view_).face[2, 2], truth(view_).depth[2, 2]) == (0, depth)


@pytest.mark.parametrize(("cull", "owner"), [("none", 0), ("back", -1), ("front", 0)])
def test_an_eye_inside_a_sphere_sees_its_back(cull: str, owner: int) -> None:
    eye = {"type": "perspective", "eye": [0.0, 0.0, 0.25], "near": 0.125}
    found = everything(view(scene([{"shape": "sphere", "cull": cull}], eye), (3, 3)))
    assert found.face[4] == owner
    assert found.depth[4] == (1.25 if owner == 0 else np.inf)


def test_an_eye_on_the_axis_of_a_cylinder_sees_its_side_around_the_base() -> None:
    eye = {"type": "perspective", "eye": [0.0, 0.0, 0.75], "near": 0.125, "fov": 126.0}
    view_ = view(scene([{"shape": "cylinder"}], eye), (5, 5))
    face = np.array(owners(view_))
    assert face[2].tolist() == [0, 1, 1, 1, 0]
    assert face.tolist() == brute.over_all(view_, brute.owner)


@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
@pytest.mark.parametrize("cull", ["none", "back", "front"])
def test_an_eye_on_the_surface(shape: str, cull: str) -> None:
    eye = {
        "type": "perspective",
        "eye": [1.0, 0.0, 0.0],
        "target": [0.0, 0.25, 0.5],
        "near": 0.125,
        "fov": 120.0,
    }
    view_ = view(scene([{"shape": shape, "cull": cull}], eye), (5, 5))
    assert owners(view_) == brute.over_all(view_, brute.owner)


@pytest.mark.parametrize("camera", [LOOKING_DOWN, {"type": "perspective", "eye": [0.0, 0.0, 3.0]}])
def test_touching_surfaces(camera: dict[str, Any]) -> None:
    # A plane on top of a ball, a ball in a cylinder as wide, a rim on a plane: each touches at samples.
    lying = [{"translate": [0.0, 0.0, -0.5]}, {"rotate_x": 90.0}]
    pairs: list[tuple[list[dict[str, Any]], int]] = [
        ([{"shape": "sphere"}, moved(0.0, 0.0, 1.0)], 1),
        ([{"shape": "sphere"}, {"shape": "cylinder", "transform": lying}], 1),
        ([{"shape": "cylinder", "transform": lying}, moved(0.0, 0.0, 1.0)], 3),
    ]
    for pair, owner in pairs:
        view_ = view(scene(pair, camera), (3, 3))
        assert owners(view_)[1][1] == owner
        assert owners(view_) == brute.over_all(view_, brute.owner)


def test_of_coinciding_curved_faces_the_lowest_owns() -> None:
    ball = {"shape": "sphere"}
    mirrored = {"shape": "sphere", "transform": [{"scale": [-1.0, 1.0, 1.0]}, {"rotate_z": 90.0}]}
    for pair in ([ball, mirrored], [mirrored, ball]):
        assert set(everything(seen(pair)).face) == {0, -1}
    longer = {"shape": "cylinder", "transform": [{"scale": [1.0, 1.0, 2.0]}, {"rotate_x": -90.0}]}
    shorter = {"shape": "cylinder", "transform": [{"rotate_x": -90.0}]}
    assert [row[2] for row in owners(seen([longer, shorter], 5))] == [0, 0, -1, -1, -1]
    assert [row[2] for row in owners(seen([shorter, longer], 5))] == [3, 0, -1, -1, -1]


# ---------------------------------------------------------------- by brute force


@pytest.mark.parametrize("make", [hard_view, loose_view], ids=["on a grid", "anywhere"])
@pytest.mark.parametrize("shapes", [PLANAR, CURVED, CONES], ids=["planar", "curved", "cones"])
@pytest.mark.parametrize("seed", range(1000, 1006))
def test_owners_by_brute_force(make: Maker, shapes: tuple[str, ...], seed: int) -> None:
    view_ = make(seed, shapes)
    assert owners(view_) == brute.over_all(view_, brute.owner)


@pytest.mark.parametrize("make", [hard_view, loose_view], ids=["on a grid", "anywhere"])
@pytest.mark.parametrize("seed", range(2000, 2005))
def test_depths_of_planes_are_correctly_rounded(make: Maker, seed: int) -> None:
    view_ = make(seed, PLANAR)
    found = everything(view_)
    for sample in np.flatnonzero(found.face >= 0):
        _, depth = brute.nearest(view_, *divmod(int(sample), view_.width))[0]
        above, below = (Fraction(brute.Germ.of(germ).terms[0, 0, 0]) for germ in (depth.p, depth.s))
        assert found.depth[sample] == float(above / below)


# ---------------------------------------------------------------- by the oracle


def agrees(answer: VisibilityMap, found: Resolved) -> None:
    assert (found.face == answer.face.ravel()).all()
    # The oracle's depths are within 0.51 ulp of the true ones.
    depth = answer.depth.ravel()[found.face >= 0]
    assert (np.abs(found.depth[found.face >= 0] - depth) <= np.spacing(np.abs(depth))).all()


@pytest.mark.jit
@pytest.mark.parametrize("make", [hard_view, loose_view], ids=["on a grid", "anywhere"])
@pytest.mark.parametrize("shapes", [PLANAR, CURVED, CONES], ids=["planar", "curved", "cones"])
def test_many_views(make: Maker, shapes: tuple[str, ...]) -> None:
    for seed in range(3000, 3100):
        view_ = make(seed, shapes)
        agrees(truth(view_), everything(view_))


@pytest.mark.jit
@pytest.mark.parametrize("name", sorted(file.stem for file in SCENES.glob("*.toml")))
def test_built_in_scenes(name: str) -> None:
    exact = view(hsr.load(SCENES / f"{name}.toml"), (16, 12))
    for view_ in {exact, exact.tessellated()}:
        answer = truth(view_)
        agrees(answer, asked(view_, shown_and_others(view_, answer)))


def shown_and_others(view_: View, answer: VisibilityMap, others: int = 100) -> Array:
    """Return the pieces of the faces that the oracle shows, and some more."""
    count = first_pieces(view_.geometry)[-1]
    shown = np.isin(faces_of_pieces(view_), answer.face)
    more = np.random.default_rng(0).choice(count, min(count, others), replace=False)
    return np.union1d(np.flatnonzero(shown), more)


def faces_of_pieces(view_: View) -> Array:
    faces = []
    for placement in view_.placements:
        polygons = placement.shape.polygons
        own = np.arange(placement.shape.faces) if polygons is None else polygons.triangle_face
        faces.append(placement.first + own)
    return np.concatenate(faces)


# ---------------------------------------------------------------- numbers


def test_integers_keep_every_bit() -> None:
    numbers = [0.1, -3.0, 2.0**-1074, 1e300]
    whole, unit = integers(numbers)
    assert [Fraction(n, unit) for n in whole] == [Fraction(x) for x in numbers]
    assert integers([0.5, -3.0])[0] == [1, -6]


whole = some.integers(-(10**30), 10**30)


@given(p=whole, q=whole, r=some.integers(0, 10**30), s=some.integers(1, 10**30))
def test_roots_are_correctly_rounded(p: int, q: int, r: int, s: int) -> None:
    with localcontext(prec=400):
        assert rounded(p, q, r, s) == float((p + q * Decimal(r).sqrt()) / s)


def test_roots_that_cancel_are_correctly_rounded() -> None:
    # 10^40 - sqrt(10^80 - 1) is a little more than 1 / (2 10^40); with - 0 it is nothing at all.
    with localcontext(prec=400):
        assert rounded(10**40, -1, 10**80 - 1, 1) == float(10**40 - Decimal(10**80 - 1).sqrt()) == 5e-41
    assert rounded(10**40, -1, 10**80, 1) == 0.0
