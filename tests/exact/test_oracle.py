"""The oracle against brute force, against itself, and against answers written by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from hsr.base.arrays import Floats
from hsr.base.errors import ViewError
from hsr.exact.oracle import owners, truth
from hsr.problem.map import VisibilityMap
from hsr.problem.view import Placement, View, view
from hsr.scene.shapes import Kind, Polygons, Shape
from tests.exact import brute
from tests.exact.hard import CONES, CURVED, PLANAR, hard_view, loose_view, on_grid, scene

Maker = Callable[[int, tuple[str, ...]], View]

LOOKING_DOWN = {"type": "orthographic", "eye": [0.0, 0.0, 3.0], "height": 4.0, "far": 9.0}


def seen(objects: list[dict[str, Any]], side: int = 4, **camera: Any) -> View:
    return view(scene(objects, {**LOOKING_DOWN, **camera}), (side, side))


def ties(answer: VisibilityMap) -> dict[tuple[int, int], set[int]]:
    """The admissible faces of the tied samples, by row and column."""
    told, width = answer.admissible, answer.face.shape[1]
    return {divmod(int(sample), width): set(told.faces(int(sample))) for sample in told.sample}


def admissible_everywhere(answer: VisibilityMap) -> list[list[set[int]]]:
    tied = ties(answer)
    return [
        [tied.get((r, c), {int(face)}) for c, face in enumerate(row)] for r, row in enumerate(answer.face)
    ]


# ---------------------------------------------------------------- by hand


def test_samples_on_the_rim_of_a_square_go_to_the_left_and_top() -> None:
    # The rim runs through samples: those of rows and columns 1 and 3.
    answer = truth(seen([{"shape": "square", "transform": [{"translate": [-0.5, 0.5, 0.0]}]}], 4))
    assert (answer.face == 0).astype(int).tolist() == [
        [1, 1, 0, 0],
        [1, 1, 0, 0],
        [0, 0, 0, 0],
        [0, 0, 0, 0],
    ]
    assert set(ties(answer)) == {(r, c) for r in (0, 1, 2) for c in (0, 1, 2)} - {(1, 1)}
    assert all(faces == {0, -1} for faces in ties(answer).values())


def test_coinciding_faces_are_all_admissible_and_the_lowest_owns() -> None:
    answer = truth(seen([{"shape": "square"}, {"shape": "square"}]))
    assert answer.face[1, 1] == 0
    assert ties(answer)[1, 1] == {0, 1}
    assert answer.work["uncertain"] == 4


def test_crossing_faces_tie_on_the_line_they_share() -> None:
    # z = x / 2 and z = -x / 2 cross in the column x = 0; to the right of it the first is nearer.
    shears = [np.eye(4), np.eye(4)]
    shears[0][2, 0], shears[1][2, 0] = 0.5, -0.5
    answer = truth(seen([{"shape": "square", "transform": [{"matrix": m.tolist()}]} for m in shears], 5))
    assert answer.face[2].tolist() == [-1, 1, 0, 0, -1]
    assert ties(answer)[2, 2] == {0, 1}
    assert answer.depth[2].tolist() == [np.inf, 3 - 0.4, 3.0, 3 - 0.4, np.inf]


def test_a_hidden_face_does_not_own_the_edge_it_shares() -> None:
    # The left side of the cube, seen edge-on by a parallel camera, and its back share their edges
    # with the front in projection; only the front is seen.
    answer = truth(seen([{"shape": "cube", "transform": [{"translate": [-0.5, 0.5, 0.0]}]}], 4))
    front = 4
    assert answer.face.tolist() == [[4, 4, -1, -1], [4, 4, -1, -1], [-1, -1, -1, -1], [-1, -1, -1, -1]]
    assert ties(answer)[0, 1] == {front, -1}


def test_near_and_far_are_closed() -> None:
    touching = truth(seen([{"shape": "square"}], near=3.0))
    assert (touching.face[1:3, 1:3] == 0).all()
    assert (truth(seen([{"shape": "square"}], near=-1.0, far=3.0)).face[1:3, 1:3] == 0).all()
    assert (truth(seen([{"shape": "square"}], near=np.nextafter(3.0, 4.0))).face == -1).all()


def test_a_sphere_is_seen_from_within_and_culled_by_the_side_that_is_hit() -> None:
    eye = {"type": "perspective", "eye": [0.0, 0.0, 0.5], "near": 0.125}
    for cull, owner in (("none", 0), ("back", -1), ("front", 0)):
        inside = truth(view(scene([{"shape": "sphere", "cull": cull}], eye), (3, 3)))
        assert inside.face[1, 1] == owner
    assert inside.depth[1, 1] == 1.5


def test_tangent_lines_of_sight_follow_the_limit() -> None:
    # The sphere is centred on the sample (1, 1), and its outline runs through four others. Only from
    # the left one does a step to the right lead into it: above, it leaves before d leads down.
    answer = truth(seen([{"shape": "sphere", "transform": [{"translate": [-0.5, 0.5, 0.0]}]}], 4))
    assert np.argwhere(answer.face == 0).tolist() == [[1, 0], [1, 1]]
    assert ties(answer) == {spot: {0, -1} for spot in ((0, 1), (1, 0), (1, 2), (2, 1))}


def test_planes_closer_than_float64_can_tell() -> None:
    # Depth 3 - 2^-53 rounds to 3: the second square is nearer all the same.
    lifted = {"shape": "square", "transform": [{"translate": [0.0, 0.0, 2.0**-53]}]}
    assert (truth(seen([{"shape": "square"}, lifted])).face[1:3, 1:3] == 1).all()
    assert (truth(seen([lifted, {"shape": "square"}])).face[1:3, 1:3] == 0).all()


def test_planes_that_cross_at_an_angle_float64_cannot_tell() -> None:
    shears = [np.eye(4), np.eye(4)]
    shears[0][2, 0], shears[1][2, 0] = 2.0**-60, -(2.0**-60)
    answer = truth(seen([{"shape": "square", "transform": [{"matrix": m.tolist()}]} for m in shears], 8))
    assert answer.face[4].tolist() == [-1, -1, 1, 1, 0, 0, -1, -1]
    assert not ties(answer)


@pytest.mark.parametrize("cull", ["none", "back", "front"])
@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
def test_an_eye_on_the_surface(shape: str, cull: str) -> None:
    eye = {
        "type": "perspective",
        "eye": [1.0, 0.0, 0.0],
        "target": [0.0, 0.25, 0.5],
        "near": 0.125,
        "fov": 120.0,
    }
    view_ = view(scene([{"shape": shape, "cull": cull}], eye), (5, 5))
    answer = truth(view_)
    assert answer.face.tolist() == brute.over_all(view_, brute.owner)
    assert (answer.face >= 0).any() == (cull != "back")


def test_corners_behind_the_eye() -> None:
    eye = {
        "type": "perspective",
        "eye": [0.0, 1.0, 0.0],
        "target": [0.0, 1.0, -1.0],
        "near": 0.125,
        "far": 32.0,
    }
    # The first is behind the eye and above it; what is seen of the triangle runs downward all the same.
    corners = [[0.0, 1.0625, 1.0], [9.0, -3.0, -20.0], [-9.0, -3.0, -20.0]]
    ground = {"shape": "mesh", "vertices": corners, "faces": [[0, 1, 2]]}
    view_ = view(scene([ground], eye), (6, 6))
    answer = truth(view_)
    assert answer.face.tolist() == brute.over_all(view_, brute.owner)
    assert 0 < (answer.face == 0).sum() < 36


def test_a_camera_without_forward_is_refused() -> None:
    good = seen([{"shape": "square"}])
    with pytest.raises(ViewError, match="does not grow"):
        truth(replace(good, clip_from_world=-good.clip_from_world))
    with pytest.raises(ViewError, match="singular"):
        truth(replace(good, clip_from_world=np.diag([1.0, 0.0, 1.0, 1.0])))


# ---------------------------------------------------------------- by brute force


@pytest.mark.parametrize("shapes", [PLANAR, CURVED, CONES], ids=["planar", "curved", "cones"])
@pytest.mark.parametrize("seed", range(12))
def test_owners_where_everything_is_on_a_grid(shapes: tuple[str, ...], seed: int) -> None:
    view = hard_view(seed, shapes)
    assert truth(view).face.tolist() == brute.over_all(view, brute.owner)


@pytest.mark.parametrize("shapes", [PLANAR, CURVED, CONES], ids=["planar", "curved", "cones"])
@pytest.mark.parametrize("seed", range(20, 26))
def test_owners_where_nothing_is(shapes: tuple[str, ...], seed: int) -> None:
    view = loose_view(seed, shapes)
    assert truth(view).face.tolist() == brute.over_all(view, brute.owner)


@pytest.mark.parametrize(
    ("shapes", "seed"), [(PLANAR, 3), (PLANAR, 14), (CURVED, 9), (CURVED, 15), (CONES, 4), (CONES, 16)]
)
def test_admissible_owners(shapes: tuple[str, ...], seed: int) -> None:
    view = hard_view(seed, shapes, side=3)
    assert admissible_everywhere(truth(view)) == brute.over_all(view, brute.admissible)


def test_a_tessellated_view_is_that_of_its_polygons() -> None:
    view = hard_view(2, ("sphere", "cylinder"))
    flat = view.tessellated()
    assert truth(flat).face.tolist() == brute.over_all(flat, brute.owner)


# ---------------------------------------------------------------- by what must not matter


anywhere = pytest.mark.parametrize("make", [hard_view, loose_view], ids=["on a grid", "anywhere"])
any_shapes = pytest.mark.parametrize("shapes", [PLANAR, CURVED, CONES], ids=["planar", "curved", "cones"])


def answers(view: View) -> tuple[list[list[int]], list[list[set[int]]], list[list[float]]]:
    answer = truth(view)
    return answer.face.tolist(), admissible_everywhere(answer), answer.depth.tolist()


def of_few_bits(numbers: Floats) -> Floats:
    return numbers.astype(np.float32).astype(np.float64)


def reshaped(view: View, change: Any) -> View:
    """The same view with the polygons of every shape changed."""

    def changed(placement: Placement) -> Placement:
        shape = placement.shape
        if shape.polygons is None:
            return placement
        return replace(placement, shape=replace(shape, polygons=change(shape.polygons)))

    return replace(view, placements=tuple(changed(placement) for placement in view.placements))


@anywhere
@pytest.mark.parametrize("seed", range(300, 320))
def test_turning_corners_round_changes_nothing(make: Maker, seed: int) -> None:
    view = make(seed, ("mesh", "flat"))

    def turned(polygons: Polygons) -> Polygons:
        return replace(polygons, corner=np.roll(polygons.corner.reshape(-1, 3), 1, axis=1).ravel())

    assert answers(reshaped(view, turned)) == answers(view)


@anywhere
@pytest.mark.parametrize("seed", range(400, 420))
def test_splitting_faces_changes_nothing(make: Maker, seed: int) -> None:
    # Halfway between corners of few bits nothing is rounded.
    view = reshaped(make(seed, ("mesh", "flat")), lambda p: replace(p, vertices=of_few_bits(p.vertices)))

    def split(polygons: Polygons) -> Polygons:
        corners = polygons.vertices[polygons.corner.reshape(-1, 3)]
        middle = (corners[:, 1] + corners[:, 2]) / 2
        halves = np.stack([corners[:, 0], corners[:, 1], middle, corners[:, 0], middle, corners[:, 2]], 1)
        loops = np.arange(6 * len(corners)).reshape(-1, 3)
        return Polygons.of(halves.reshape(-1, 3), loops.tolist(), np.repeat(polygons.face, 2).tolist())

    assert answers(reshaped(view, split)) == answers(view)


@anywhere
@any_shapes
@pytest.mark.parametrize("seed", range(500, 510))
@pytest.mark.parametrize("power", [-300, 40])
def test_scaling_by_a_power_of_two_scales_depths(
    make: Maker, shapes: tuple[str, ...], seed: int, power: int
) -> None:
    view = make(seed, shapes)
    factor = 2.0**power
    grown = replace(
        view,
        clip_from_world=view.clip_from_world * [1.0, 1.0, 1.0, factor],
        depth_row=view.depth_row * [1.0, 1.0, 1.0, factor],
        near=view.near * factor,
        far=view.far * factor,
        placements=tuple(
            replace(p, world_from_object=np.vstack([factor * p.world_from_object[:3], [0, 0, 0, 1]]))
            for p in view.placements
        ),
    )
    one, other = truth(view), truth(grown)
    assert admissible_everywhere(one) == admissible_everywhere(other)
    assert (one.face == other.face).all()
    assert (one.depth * factor == other.depth).all()


@anywhere
@any_shapes
@pytest.mark.parametrize("seed", range(600, 615))
def test_moving_the_image_by_a_pixel_moves_the_answer(
    make: Maker, shapes: tuple[str, ...], seed: int
) -> None:
    wide = replace(make(seed, shapes), width=8, height=8)
    wide = replace(wide, clip_from_world=of_few_bits(wide.clip_from_world))
    to_the_right, down = np.eye(4), np.eye(4)
    to_the_right[0, 3], down[1, 3] = 2.0 / 8, -2.0 / 8
    still, right, below = (
        truth(replace(wide, clip_from_world=by @ wide.clip_from_world))
        for by in (np.eye(4), to_the_right, down)
    )
    assert (right.face[:, 1:] == still.face[:, :-1]).all()
    assert (below.face[1:] == still.face[:-1]).all()


def mirror_image(view: View) -> View:
    """The view with left and right exchanged."""
    return replace(
        view,
        clip_from_world=np.diag([-1.0, 1.0, 1.0, 1.0]) @ view.clip_from_world,
        placements=tuple(replace(p, mirrored=not p.mirrored) for p in view.placements),
    )


@anywhere
@any_shapes
@pytest.mark.parametrize("seed", range(700, 715))
def test_a_mirror_image_has_the_mirrored_owners(make: Maker, shapes: tuple[str, ...], seed: int) -> None:
    view = make(seed, shapes)
    one, other = admissible_everywhere(truth(view)), admissible_everywhere(truth(mirror_image(view)))
    assert one == [row[::-1] for row in other]


@any_shapes
@pytest.mark.parametrize("seed", range(720, 726))
def test_ties_of_a_mirror_image_go_to_the_limit_from_the_left(shapes: tuple[str, ...], seed: int) -> None:
    view = hard_view(seed, shapes)

    def owner_to_the_left(view: View, row: int, column: int) -> int:
        return next((face for face, _ in brute.nearest(view, row, column, (-1, 0))), -1)

    assert truth(mirror_image(view)).face[:, ::-1].tolist() == brute.over_all(view, owner_to_the_left)


@anywhere
@any_shapes
@pytest.mark.parametrize("seed", range(800, 815))
def test_the_order_of_objects_only_decides_what_coincides(
    make: Maker, shapes: tuple[str, ...], seed: int
) -> None:
    view = make(seed, shapes)
    first = np.cumsum([0, *(p.shape.faces for p in view.placements[::-1])])
    backwards = replace(
        view,
        placements=tuple(
            replace(p, first=int(f)) for p, f in zip(view.placements[::-1], first, strict=False)
        ),
    )
    number = {-1: -1}
    for old, new in zip(view.placements, backwards.placements[::-1], strict=True):
        number |= {old.first + k: new.first + k for k in range(old.shape.faces)}
    renamed = [
        [{number[face] for face in faces} for faces in row] for row in admissible_everywhere(truth(view))
    ]
    assert renamed == admissible_everywhere(truth(backwards))


@pytest.mark.parametrize("turned", [False, True], ids=["on a grid", "anywhere"])
@pytest.mark.parametrize("seed", range(900, 920))
def test_what_is_added_behind_everything_stays_hidden(turned: bool, seed: int) -> None:
    random = np.random.default_rng(seed)
    turns = [{f"rotate_{axis}": float(random.uniform(0, 360))} for axis in "xyz"] if turned else []
    wall = {"shape": "square", "transform": [{"scale": 4.0}, {"translate": [0.0, 0.0, 1.0]}]}
    steps = [{"scale": 0.5}, *turns, {"translate": on_grid(random, -2, 0, 3)}]
    behind = {"shape": str(random.choice(["cube", "sphere", "cylinder"])), "transform": steps}
    assert answers(seen([wall, behind])) == answers(seen([wall]))


@anywhere
@any_shapes
@pytest.mark.parametrize("seed", range(950, 965))
def test_of_some_samples_it_says_what_it_says_of_all(make: Maker, shapes: tuple[str, ...], seed: int) -> None:
    view = make(seed, shapes)
    random = np.random.default_rng(seed)
    samples = random.integers(view.width * view.height, size=random.integers(6))
    assert owners(view, samples).tolist() == truth(view).face.ravel()[samples].tolist()


def test_a_plane_too_steep_for_float64_is_no_trouble() -> None:
    vertices = np.array([[-1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0 + 2.0**-1060, 0.0, 1.0e10]])
    shape = Shape(Kind.MESH, "mesh", Polygons.of(vertices, [(0, 2, 1)]))
    view = seen([{"shape": "square"}])
    needle = replace(view.placements[0], shape=shape, first=1)
    steep = replace(view, near=-1e12, placements=(*view.placements, needle))
    assert truth(steep).face.tolist() == brute.over_all(steep, brute.owner)
