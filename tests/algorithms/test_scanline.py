"""The depth buffer on whole views."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms import scanline
from hsr.algorithms.prepare.depth_formats import FORMATS
from hsr.algorithms.registry import methods
from hsr.base.errors import MethodError
from hsr.difference.classes import depth_step
from hsr.problem.map import VisibilityMap

VARIANTS = [name for name, method in methods().items() if method.module == scanline.__name__]
EXACT = ["scanline", "scanline-direct", "scanline-bottom-left", "scanline-less-equal"]
FLOAT32 = ["scanline-float32", "scanline-float32-direct"]

ORTHOGRAPHIC = {"type": "orthographic", "eye": [0.0, 0.0, 5.0], "height": 4.0, "near": 0.0, "far": 20.0}


def triangles(name: str, vertices: Any, faces: Any, **keys: Any) -> dict[str, Any]:
    return {"name": name, "shape": "mesh", "vertices": vertices, "faces": faces, **keys}


def square(name: str, z: float, half: float = 1.0, **keys: Any) -> dict[str, Any]:
    steps = [{"scale": half}, {"translate": [0.0, 0.0, z]}]
    return {"name": name, "shape": "square", "transform": steps, **keys}


def random_soup(seed: int, count: int) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    middle = rng.uniform([-1.5, -1.5, -3], [1.5, 1.5, 1], (count, 1, 3))
    vertices = (middle + rng.uniform(-1, 1, (count, 3, 3))).reshape(-1, 3).tolist()
    return triangles("soup", vertices, np.arange(3 * count).reshape(-1, 3).tolist())


def by_rays(view: Any) -> tuple[np.ndarray, np.ndarray]:
    """Nearest triangle of every sample, by solving for each sample's ray: shares nothing with scan lines."""
    face, depth = np.full((view.height, view.width), -1), np.full((view.height, view.width), np.inf)
    for row, column in itertools.product(range(view.height), range(view.width)):
        x, y = (2 * column + 1) / view.width - 1, 1 - (2 * row + 1) / view.height
        origin = view.rays.origin @ [1.0, x, y]
        direction = view.rays.direction @ [1.0, x, y]
        for k, (a, b, c) in enumerate(view.triangles):
            u, v, t = np.linalg.solve(np.stack([b - a, c - a, -direction], axis=1), origin - a)
            inside = u >= 0 and v >= 0 and u + v <= 1 and view.near <= t <= view.far
            if inside and t < depth[row, column]:
                face[row, column], depth[row, column] = view.triangle_face[k], t
    return face, depth


@pytest.mark.parametrize("camera", [{"fov": 60.0}, {"fov": 60.0, "near": 3.5, "far": 6.0}, ORTHOGRAPHIC])
@pytest.mark.parametrize("method", EXACT)
def test_agrees_with_rays(make_scene: Any, method: str, camera: dict[str, Any]) -> None:
    view = hsr.view(make_scene([random_soup(1, 12)], **camera), (13, 11))
    answer = hsr.render(view, method)
    face, depth = by_rays(view)
    assert np.array_equal(answer.face, face) and (face >= 0).any() and (face < 0).any()
    assert answer.depth == pytest.approx(depth, rel=1e-9)


@pytest.mark.parametrize("method", EXACT + FLOAT32)
def test_camera_among_the_triangles(make_scene: Any, method: str) -> None:
    """Vertices behind the eye, on all sides, and far outside of the image."""
    view = hsr.view(make_scene([random_soup(2, 20)], eye=[0.1, 0.2, -0.5], near=0.01, fov=100.0), (12, 10))
    face, depth = by_rays(view)
    answer = hsr.render(view, method)
    assert np.array_equal(answer.face, face)
    assert answer.depth == pytest.approx(depth, rel=1e-9 if method in EXACT else 1e-2)


@pytest.mark.parametrize("method", EXACT + FLOAT32)
def test_ground_that_passes_under_the_eye(make_scene: Any, method: str) -> None:
    """A huge square below: the lower half of the image is ground, the horizon free."""
    ground = [[-1e7, -1.0, 1e7], [1e7, -1.0, 1e7], [1e7, -1.0, -1e7], [-1e7, -1.0, -1e7]]
    scene = make_scene(
        [triangles("ground", ground, [[0, 1, 2], [0, 2, 3]])], eye=[0.0, 0.0, 0.0], target=[0.0, 0.0, -1.0]
    )
    answer = hsr.render(scene, method, size=(9, 8))
    assert (answer.face[:4] == -1).all() and (answer.face[4:] >= 0).all()
    # Sample (r, c) sees y = -tan(22.5) (2 r + 1 - 8) / 8 at depth 1.
    expected = 8 / (np.tan(np.radians(22.5)) * (2 * np.arange(4, 8) - 7))
    relative = 1e-9 if method in EXACT else 1e-3
    assert answer.depth[4:] == pytest.approx(np.broadcast_to(expected[:, None], (4, 9)), rel=relative)


def test_near_and_far_planes_belong_to_the_view(make_scene: Any) -> None:
    camera = {**ORTHOGRAPHIC, "near": 4.0, "far": 6.0}
    for z, seen in [(1.0, True), (-1.0, True), (1.0 + 2**-20, False), (-1.0 - 2**-20, False)]:
        answer = hsr.render(make_scene([square("wall", z, 8.0)], **camera), "scanline", size=(4, 4))
        assert (answer.face >= 0).all() == (answer.face >= 0).any() == seen


def test_near_opens_a_cube(make_scene: Any) -> None:
    box = {"name": "box", "shape": "cube"}
    scene = make_scene([box], eye=[0.0, 0.0, 5.0], near=4.5)
    answer = hsr.render(scene, "scanline", size=(9, 9))
    assert answer.name_of(int(answer.face[4, 4])) == "box.back"
    assert answer.depth[4, 4] == pytest.approx(6.0)


# ---------------------------------------------------------------- culling


MIRROR = [{"scale": [-1.0, 1.0, 1.0]}]


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize(("cull", "name"), [("none", "front"), ("back", "front"), ("front", "back")])
@pytest.mark.parametrize("method", ["scanline", "scanline-bottom-left"])
def test_culling_is_that_of_the_scene(
    make_scene: Any, method: str, cull: str, name: str, mirrored: bool
) -> None:
    box = {"name": "box", "shape": "cube", "cull": cull, "transform": MIRROR if mirrored else []}
    for camera in ({"eye": [0.0, 0.0, 5.0]}, ORTHOGRAPHIC):
        answer = hsr.render(make_scene([box], **camera), method, size=(9, 9))
        assert answer.name_of(int(answer.face[4, 4])) == f"box.{name}"


def test_culling_a_closed_solid_changes_nothing(make_scene: Any) -> None:
    turn = [{"rotate_x": 31.0}, {"rotate_y": 17.0}]
    maps = [
        hsr.render(make_scene([{"name": "ball", "shape": "sphere", **how}]), "scanline", size=(40, 40))
        for how in ({"cull": "none", "transform": turn}, {"cull": "back", "transform": turn})
    ]
    assert np.array_equal(maps[0].face, maps[1].face) and np.array_equal(maps[0].depth, maps[1].depth)


# ---------------------------------------------------------------- order, equality, arithmetic


def test_order_of_objects_does_not_matter(make_scene: Any) -> None:
    names = ["a", "b", "c", "d"]
    things = {
        name: {
            "name": name,
            "shape": "cube",
            "transform": [
                {"rotate_y": 20.0 * k},
                {"rotate_x": 35.0},
                {"translate": [0.4 * k - 0.6, 0.0, -0.7 * k]},
            ],
        }
        for k, name in enumerate(names)
    }

    def named(order: list[str]) -> list[list[str]]:
        answer = hsr.render(make_scene([things[name] for name in order]), "scanline", size=(24, 24))
        return [[answer.name_of(int(face)) for face in row] for row in answer.face]

    assert named(names) == named(names[::-1]) == named(["c", "a", "d", "b"])


@pytest.mark.parametrize("method", VARIANTS)
def test_of_coinciding_faces_the_first_wins(make_scene: Any, method: str) -> None:
    answer = hsr.render(make_scene([square("a", 0.0), square("b", 0.0)]), method, size=(16, 16))
    assert set(np.unique(answer.face)) == {-1, 1 if method == "scanline-less-equal" else 0}


def test_a_polygon_is_its_triangles(make_scene: Any) -> None:
    corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]
    turn = [{"rotate_x": 40.0}, {"rotate_z": 25.0}]
    whole = {"name": "whole", "shape": "square", "transform": turn}
    halves = triangles("halves", corners, [[0, 1, 2], [0, 2, 3]], transform=turn)
    first, second = (hsr.render(make_scene([thing]), "scanline", size=(33, 33)) for thing in (whole, halves))
    assert np.array_equal(first.face >= 0, second.face >= 0)
    seen = first.face >= 0
    assert first.depth[seen] == pytest.approx(second.depth[seen], rel=1e-12)


def test_steppings_agree_to_rounding(make_scene: Any) -> None:
    view = hsr.view(make_scene([random_soup(4, 30)], fov=60.0), (60, 50))
    maps = {name: hsr.render(view, name) for name in ("scanline", "scanline-direct", *FLOAT32)}
    assert np.array_equal(maps["scanline"].face, maps["scanline-direct"].face)
    seen = maps["scanline"].face >= 0
    reference = maps["scanline-direct"].depth[seen]
    assert maps["scanline"].depth[seen] == pytest.approx(reference, rel=1e-11)
    for name in FLOAT32:
        assert (maps[name].face != maps["scanline"].face).mean() < 0.01


@pytest.mark.jit
def test_threads_do_not_matter(make_scene: Any) -> None:
    import numba

    view = hsr.view(make_scene([{"name": "t", "shape": "torus-knot"}]), (200, 150))
    before = numba.get_num_threads()
    try:
        maps: list[VisibilityMap] = []
        for threads in range(1, before + 1):
            numba.set_num_threads(threads)
            maps.append(hsr.render(view, "scanline-float32"))
    finally:
        numba.set_num_threads(before)
    assert all(np.array_equal(maps[0].depth, other.depth) for other in maps)
    assert all(np.array_equal(maps[0].face, other.face) for other in maps)


# ---------------------------------------------------------------- depth formats

RANGES = {
    "far": {"near": 1.0, "far": 10.0},
    "no far": {"near": 1.0},
    "parallel": {**ORTHOGRAPHIC, "near": 1.0, "far": 10.0},
}


@pytest.mark.parametrize(
    ("name", "range"), [pair for pair in itertools.product(FORMATS, RANGES) if pair != ("1/w", "parallel")]
)
def test_depths_are_rounded_as_the_format_says(make_scene: Any, name: str, range: str) -> None:
    """To the nearest of the numbers whose spacing the note tells: off by half of it at most."""
    wall = {"name": "wall", "shape": "square", "transform": [{"scale": 3.0}, {"rotate_y": 50.0}]}
    view = hsr.view(make_scene([wall], **RANGES[range]), (40, 30))
    exact = hsr.render(view, "scanline-direct")
    answer = hsr.render(view, "scanline-direct", depth_format=name)
    seen = exact.face == 0
    assert np.array_equal(answer.face, exact.face) and seen.any()
    steps = np.abs(answer.depth[seen] - exact.depth[seen]) / depth_step(answer, exact.depth[seen])
    assert steps.max() <= 0.501
    assert steps.max() > (0.1 if name != "float64" else -1.0)


@pytest.mark.parametrize("bits", [16, 24])
@pytest.mark.parametrize("kind", ["d", "w"])
def test_levels_are_those_of_the_formula(make_scene: Any, kind: str, bits: int) -> None:
    view = hsr.view(make_scene([{"name": "ball", "shape": "sphere"}], near=1.0, far=10.0), (40, 30))
    answer, exact = hsr.render(view, "scanline", depth_format=f"{kind}{bits}"), hsr.render(view, "scanline")
    seen = exact.face == 0

    def level(d: np.ndarray) -> np.ndarray:
        of_range = (1 - 1 / d) / (1 - 1 / 10) if kind == "d" else (d - 1) / (10 - 1)
        return of_range[seen] * (2**bits - 1)

    stored = level(answer.depth)
    assert stored == pytest.approx(np.rint(stored), abs=1e-6)
    assert np.abs(stored - level(exact.depth)).max() <= 0.5 + 1e-6
    assert len(np.unique(np.rint(stored))) > 100


@pytest.mark.parametrize(
    ("name", "tells_apart"),
    [
        ("float64", True),
        ("d16", False),
        ("d24", False),
        ("d32f", False),
        ("d32f-reversed", True),
        ("w16", False),
        ("w24", True),
        ("1/w", True),
    ],
)
def test_which_formats_tell_close_walls_apart(make_scene: Any, name: str, tells_apart: bool) -> None:
    """At distance 100, 0.001 apart: d24 and d32f have steps of 0.006 there, w24 and the others 0.0001."""
    camera = {"eye": [0.0, 0.0, 0.0], "target": [0.0, 0.0, -1.0], "near": 0.1, "far": 1000.0}
    walls = [square("far", -100.001, 90.0), square("near", -100.0, 90.0)]
    answer = hsr.render(make_scene(walls, **camera), "scanline", size=(8, 8), depth_format=name)
    assert np.unique(answer.face).tolist() == [int(tells_apart)]


@pytest.mark.parametrize("name", ["d32f-reversed", "1/w"])
def test_distant_depths_lose_no_digits(make_scene: Any, name: str) -> None:
    """A wall 10^12 times as far as near: its window depth is 1 to twelve digits, its distance is not lost."""
    camera = {"eye": [0.0, 0.0, 0.0], "target": [0.0, 0.0, -1.0], "near": 1e-3}
    wall = make_scene([square("wall", -1e9, 1e9)], **camera)
    answer = hsr.render(wall, "scanline", size=(4, 4), depth_format=name)
    assert answer.depth == pytest.approx(1e9, rel=2.0**-24)


def test_the_greatest_level_is_not_nearer_than_the_background(make_scene: Any) -> None:
    """d16 with near 0.05: what lies beyond 2 * 65535 * 0.05 is stored as 1."""
    for z, method, seen in (
        (-6000.0, "scanline-d16", True),
        (-7000.0, "scanline-d16", False),
        (-7000.0, "scanline", True),
    ):
        wall = make_scene([square("wall", z, 9000.0)], near=0.05)
        assert (hsr.render(wall, method, size=(4, 4)).face == 0).all() == seen


def test_linear_depth_without_a_far_plane_ends_behind_the_deepest_corner(make_scene: Any) -> None:
    walls = [square("a", 0.0), square("b", -95.0, 40.0)]
    answer = hsr.render(make_scene(walls, eye=[0.0, 0.0, 5.0], near=1.0), "scanline-w16", size=(16, 16))
    noted = answer.notes["depth_format"]
    assert (noted["stored"], noted["near"]) == ("linear", 1.0)
    assert noted["far"] == pytest.approx(1.0 + 99.0 * 65535 / 65534, rel=1e-12)
    assert answer.depth[answer.face == 0] == pytest.approx(5.0, abs=99.0 / 65534 / 2)
    assert answer.depth[answer.face == 1] == pytest.approx(100.0, abs=1e-9) and (answer.face == 1).any()


@pytest.mark.parametrize(
    ("method", "stored", "step", "bytes_each"),
    [
        ("scanline", "window", 2.0**-53, 8),
        ("scanline-float32", "window", 2.0**-24, 4),
        ("scanline-fixed", "window", 1 / (2**24 - 1), 4),
        ("scanline-d16", "window", 1 / (2**16 - 1), 2),
        ("scanline-d24", "window", 1 / (2**24 - 1), 4),
        ("scanline-d32f-reversed", "distance", 2.0**-23, 4),
        ("scanline-w16", "linear", 1 / (2**16 - 1), 2),
    ],
)
def test_depth_format_is_noted(
    make_scene: Any, method: str, stored: str, step: float, bytes_each: int
) -> None:
    answer = hsr.render(make_scene([square("a", 0.0)], near=0.5, far=99.0), method, size=(4, 4))
    noted = answer.notes["depth_format"]
    assert (noted["stored"], noted["step"], noted["near"], noted["far"]) == (stored, step, 0.5, 99.0)
    assert answer.work["buffer_bytes"] == 16 * (bytes_each + 4)


def test_one_over_w_needs_perspective(make_scene: Any) -> None:
    with pytest.raises(MethodError, match="1/w is the same everywhere in a parallel view; choose another"):
        hsr.render(make_scene([square("a", 0.0)], **ORTHOGRAPHIC), "scanline", depth_format="1/w")


# ---------------------------------------------------------------- snapping and fill rules

PIXELS = {**ORTHOGRAPHIC, "height": 8.0}
"""An image of 8 x 8 shows 8 x 8 units, pixel centres at odd halves."""


@pytest.mark.parametrize("bits", [4, 8, 12])
def test_snapped_corners_are_rounded_corners(make_scene: Any, bits: int) -> None:
    """On screens the same as that of a mesh whose corners have been rounded before."""
    rng = np.random.default_rng(bits)
    corners = rng.uniform(-4.0, 4.0, (30, 3))
    rounded = corners.copy()
    rounded[:, :2] = np.rint(corners[:, :2] * 2.0**bits) / 2.0**bits
    faces = np.arange(30).reshape(-1, 3).tolist()
    views = [
        hsr.view(make_scene([triangles("soup", points.tolist(), faces)], **PIXELS), (8, 8))
        for points in (corners, rounded)
    ]
    snapped, expected = (
        hsr.render(views[0], subpixel_bits=bits, method="scanline"),
        hsr.render(views[1], "scanline"),
    )
    assert np.array_equal(snapped.face, expected.face)
    assert np.array_equal(snapped.depth, expected.depth)
    assert not np.array_equal(snapped.depth, hsr.render(views[0], "scanline").depth)


@pytest.mark.parametrize(
    ("method", "rows"),
    [
        ("scanline", ["........", ".aaa....", ".aaa....", "........"]),
        ("scanline-bottom-left", ["........", "........", ".aaa....", ".aaa...."]),
    ],
)
def test_fill_rules_on_pixel_centres(make_scene: Any, method: str, rows: list[str]) -> None:
    """A rectangle from centre to centre: its left edge is inside, and its top edge or its bottom edge."""
    corners = [[-2.5, 2.5, 0.0], [-2.5, 0.5, 0.0], [0.5, 0.5, 0.0], [0.5, 2.5, 0.0]]
    sheet = triangles("sheet", corners, [[0, 1, 2], [0, 2, 3]])
    answer = hsr.render(make_scene([sheet], **PIXELS), method, size=(8, 8))
    assert ["".join(".aa"[face + 1] for face in row) for row in answer.face[:4]] == rows
    assert (answer.face[4:] == -1).all()


def test_fill_rules_differ_on_horizontal_edges_only(make_scene: Any) -> None:
    view = hsr.view(make_scene([random_soup(5, 30)], fov=60.0), (60, 50))
    above, below = hsr.render(view, "scanline"), hsr.render(view, "scanline-bottom-left")
    assert np.array_equal(above.face, below.face)
    seen = above.face >= 0
    assert below.depth[seen] == pytest.approx(above.depth[seen], rel=1e-11)


# ---------------------------------------------------------------- work and options


def test_work_is_free_unless_asked_for(make_scene: Any) -> None:
    view = hsr.view(make_scene([square("a", 0.0), square("b", 1.0)]), (16, 12))
    assert hsr.render(view, "scanline").work == {"polygons": 2, "buffer_bytes": 16 * 12 * (8 + 4)}
    assert hsr.render(view, "scanline-float32").work["buffer_bytes"] == 16 * 12 * (4 + 4)


def test_work_when_counted(make_scene: Any) -> None:
    """Two walls fill the image, the farther first; one is culled, one behind the eye, one edge-on."""
    things = [
        square("far", -1.0, 8.0),
        square("near", 1.0, 8.0),
        {**square("back", 0.0), "cull": "front"},
        square("behind", 9.0),
        {"name": "edge", "shape": "square", "transform": [{"rotate_y": 90.0}]},
    ]
    view = hsr.view(make_scene(things, eye=[0.0, 0.0, 5.0]), (8, 6))
    counted, plain = hsr.render(view, "scanline", count=True), hsr.render(view, "scanline")
    assert np.array_equal(counted.face, plain.face) and np.array_equal(counted.depth, plain.depth)
    assert counted.work == {
        "polygons": 5,
        "buffer_bytes": 8 * 6 * 12,
        "cut": 2,
        "clipped_away": 1,
        "missed": 0,
        "edge_on": 1,
        "culled": 1,
        "set_up": 2,
        "scan_lines": 12,
        "spans": 12,
        "fragments": 96,
        "depth_passed": 96,
        "depth_failed": 0,
        "overdraw": 48,
    }


def test_the_order_of_objects_is_the_order_of_overdraw(make_scene: Any) -> None:
    far, near = square("far", -1.0, 8.0), square("near", 1.0, 8.0)
    overdraw = [
        hsr.render(make_scene(list(pair)), "scanline", count=True, size=(8, 6)).work["overdraw"]
        for pair in ((far, near), (near, far))
    ]
    assert overdraw == [48, 0]


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("stepping", "sideways"),
        ("arithmetic", "float16"),
        ("guard_bits", 25),
        ("subpixel_bits", 5),
        ("fill_rule", "right"),
        ("depth_format", "d8"),
        ("depth_test", "greater"),
    ],
)
def test_refused_options_name_the_choices(option: str, value: Any) -> None:
    with pytest.raises(
        MethodError, match=f"scanline has no {option} {value!r}; (did you mean .*)?choose from "
    ):
        methods()["scanline"].options(**{option: value})


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"arithmetic": "fixed"}, "stored as d24, not incremental and float64"),
        ({"arithmetic": "fixed", "depth_format": "d32f"}, "stored as d24, not incremental and d32f"),
        (
            {"arithmetic": "fixed", "depth_format": "d24", "stepping": "direct"},
            "stored as d24, not direct and d24",
        ),
        ({"guard_bits": 4, "depth_format": "d24"}, "float64 has no guard bits"),
    ],
)
def test_options_that_do_not_go_together(options: dict[str, Any], said: str) -> None:
    with pytest.raises(MethodError, match=said) as refused:
        methods()["scanline"].options(**options)
    assert "\n" not in str(refused.value)
