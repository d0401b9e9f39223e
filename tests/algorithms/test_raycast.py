"""Ray casting by single rays: three ways through the objects, one answer, and the right one."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import hsr
from hsr.algorithms import raycast
from hsr.algorithms.raycast import CHOICES, Options
from hsr.algorithms.registry import BUILT_IN
from hsr.base.errors import MethodError
from hsr.scene.model import Scene
from hsr.scene.shapes import Kind

SINGLE = tuple(way for way in CHOICES["acceleration"] if way != "tiles")

SQUARE = {"name": "square", "shape": "square"}
CUBE = {"name": "cube", "shape": "cube"}
SPHERE = {"name": "sphere", "shape": "sphere"}
CYLINDER = {"name": "cylinder", "shape": "cylinder"}
CONE = {"name": "cone", "shape": "cylinder", "top": 0.0}
BUCKET = {"name": "bucket", "shape": "cylinder", "top": 1.5}


def cast(view, acceleration="hierarchy"):
    return raycast.render(view, Options(acceleration))


def agreed(view):
    """Return the map of the plain list, after every other way has given the same one."""
    expected = cast(view, "none")
    for acceleration in SINGLE:
        answer = cast(view, acceleration)
        assert (answer.face == expected.face).all(), acceleration
        assert (answer.depth == expected.depth).all(), acceleration
    return expected


def mesh(seed, n, spread=0.4):
    random = np.random.default_rng(seed)
    centre = random.normal(size=(n, 1, 3))
    vertices = (centre + random.normal(scale=spread, size=(n, 3, 3))).reshape(-1, 3)
    faces = np.arange(3 * n).reshape(n, 3)
    return {"name": "mesh", "shape": "mesh", "vertices": vertices.tolist(), "faces": faces.tolist()}


EYES = {
    "perspective": {},
    "amid": {"eye": [0.1, 0.2, 0.3], "target": [1.0, 0.0, -1.0], "near": 0.05, "fov": 90.0},
    "finite": {"near": 4.0, "far": 5.5},
    "orthographic": {"type": "orthographic", "height": 4.0, "near": -1.0, "far": 20.0},
    "orthographic-cut": {"type": "orthographic", "height": 4.0, "near": 4.5, "far": 5.5},
}


@pytest.mark.parametrize("eye", EYES)
@pytest.mark.parametrize("cull", ["none", "back", "front"])
@pytest.mark.jit
def test_all_ways_agree_on_random_triangles_with_and_without_corners_behind_the_eye(make_scene, eye, cull):
    for seed in range(4):
        scene = make_scene([mesh(seed, 60, 1.0) | {"cull": cull}], **EYES[eye])
        agreed(hsr.view(scene, (37, 29)))


@pytest.mark.parametrize("eye", EYES)
def test_all_ways_agree_on_generic_shapes(make_scene, eye):
    turned = [{"rotate_x": 30.0}, {"rotate_y": 20.0}]
    objects = [
        CUBE | {"transform": [{"scale": [0.5, 0.25, 1.0]}, *turned, {"translate": [1.0, 0.5, 0.0]}]},
        SPHERE | {"transform": [{"scale": [0.5, 1.0, 0.5]}, {"translate": [-1.0, 0.0, -0.5]}]},
        CYLINDER | {"transform": [*turned, {"scale": 0.5}], "cull": "back"},
        CONE | {"transform": [*turned, {"scale": [0.5, -0.5, 1.0]}, {"translate": [0.2, 0.4, 0.5]}]},
        BUCKET | {"transform": [{"scale": 0.4}, *turned, {"translate": [-0.4, 0.7, 0.5]}], "cull": "front"},
        SQUARE | {"transform": [{"scale": 3.0}, {"rotate_x": -80.0}, {"translate": [0.0, -1.0, 0.0]}]},
        mesh(1, 5),
    ]
    answer = agreed(hsr.view(make_scene(objects, **EYES[eye]), (21, 18)))
    assert (answer.face >= 0).any()


@pytest.mark.jit
def test_all_ways_agree_on_the_built_in_scenes(scenes):
    for path in sorted(scenes.glob("*.toml")):
        scene = hsr.load(path)
        for camera in scene.camera:
            view = hsr.view(scene, (33, 27), camera.name)
            if view.faces < 20_000:
                agreed(view)


@pytest.mark.jit
def test_it_agrees_with_the_depth_buffer_on_planar_scenes(make_scene):
    for seed in range(3):
        view = hsr.view(make_scene([mesh(seed, 300), CUBE | {"transform": [{"rotate_y": 25.0}]}]), (150, 110))
        answer, peer = cast(view), hsr.render(view, "scanline-direct")
        assert (answer.face == peer.face).all()
        shown = answer.face >= 0
        assert answer.depth[shown] == pytest.approx(peer.depth[shown], rel=1e-12)


@pytest.mark.jit
def test_a_mesh_of_planes_is_the_same_solid(make_scene):
    """Rays carried into the cube's frame see what the transformed triangles of the cube show."""
    steps = [{"scale": [1.0, 0.3, 2.0]}, {"rotate_z": 33.0}, {"rotate_x": 41.0}]
    solid = hsr.view(make_scene([CUBE | {"transform": steps}]), (200, 160))
    shape = dataclasses.replace(solid.placements[0].shape, kind=Kind.MESH)
    placement = dataclasses.replace(solid.placements[0], shape=shape)
    triangles = dataclasses.replace(solid, placements=(placement,))
    one, two = cast(solid), cast(triangles)
    assert (one.face == two.face).all()
    shown = one.face >= 0
    assert one.depth[shown] == pytest.approx(two.depth[shown], rel=1e-13)


def sphere_mesh(rows, columns):
    latitude = np.pi * np.arange(rows + 1) / rows
    longitude = 2.0 * np.pi * np.arange(columns) / columns
    ring = np.stack(
        [
            np.outer(np.sin(latitude), np.cos(longitude)),
            np.outer(np.sin(latitude), np.sin(longitude)),
            np.outer(np.cos(latitude), np.ones(columns)),
        ],
        axis=2,
    )
    ring[0], ring[-1] = [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]
    vertices = ring.reshape(-1, 3)
    faces = []
    for i in range(rows):
        for j in range(columns):
            a, b = i * columns + j, i * columns + (j + 1) % columns
            c, d = a + columns, b + columns
            faces += [f for f, real in (((a, c, d), i < rows - 1), ((a, d, b), i > 0)) if real]
    return vertices, faces


@pytest.mark.jit
def test_no_ray_from_inside_a_closed_mesh_escapes_through_a_vertex_or_an_edge(make_scene):
    vertices, faces = sphere_mesh(20, 40)
    pairs = {tuple(sorted(p)) for f in faces for p in zip(f, (*f[1:], f[0]), strict=True)}
    targets = np.concatenate([vertices, [(vertices[i] + vertices[j]) / 2.0 for i, j in pairs]])
    eye = np.array([0.1, -0.2, 0.3])
    thing = {"name": "ball", "shape": "mesh", "vertices": vertices.tolist(), "faces": faces}
    view = hsr.view(make_scene([thing], near=0.01), (1, 1))
    misses = 0
    for target in targets[:: len(targets) // 700]:
        forward = (target - eye) / np.linalg.norm(target - eye)
        side = np.cross(forward, [0.3, 0.5, 0.8])
        up = np.cross(side, forward)
        rows = [np.append(row, -row @ eye) for row in (side, up, forward)]
        clip = np.stack([rows[0], rows[1], rows[2], rows[2]])
        aimed = dataclasses.replace(view, clip_from_world=clip, depth_row=rows[2])
        misses += sum(int(cast(aimed, way).face[0, 0] < 0) for way in ("tiles", "hierarchy"))
    assert misses == 0


def lattice(make_scene, objects, size):
    """See objects so that samples lie at odd multiples of 1/2 in x and y."""
    camera = {"type": "orthographic", "eye": [0.0, 0.0, 8.0], "height": float(size), "far": 20.0}
    return hsr.view(make_scene(objects, **camera), (size, size))


def test_samples_on_shared_edges_belong_to_the_right_and_lower_triangle(make_scene):
    """Two rectangles, cut into triangles, meet on a row or a column of samples."""
    points = [[-1.5, 1.5, 0], [0.5, 1.5, 0], [1.5, 1.5, 0], [-1.5, -1.5, 0], [0.5, -1.5, 0], [1.5, -1.5, 0]]
    faces = [[0, 3, 4], [0, 4, 1], [1, 4, 5], [1, 5, 2]]
    thing = {"name": "pair", "shape": "mesh", "vertices": points, "faces": faces}
    answer = agreed(lattice(make_scene, [thing], 4))
    assert (answer.face // 2).tolist() == [
        [0, 0, 1, -1],
        [0, 0, 1, -1],
        [0, 0, 1, -1],
        [-1, -1, -1, -1],
    ]


def test_of_equal_depths_the_lower_face_wins_and_borders_of_generic_shapes_are_closed(make_scene):
    twice = [SQUARE | {"name": "a", "transform": [{"scale": 1.5}]}, SQUARE | {"name": "b"}]
    answer = agreed(lattice(make_scene, twice[::-1], 4))
    assert answer.face.tolist() == [[1, 1, 1, 1], [1, 0, 0, 1], [1, 0, 0, 1], [1, 1, 1, 1]]
    assert (agreed(lattice(make_scene, twice, 4)).face == 0).all()
    assert (answer.depth == 8.0).all()


@pytest.mark.parametrize(
    ("near", "far", "face"), [(2.0, 9.0, 4), (7.0, 9.0, 4), (7.5, 9.0, 5), (9.5, 10.0, -1)]
)
@pytest.mark.parametrize("acceleration", CHOICES["acceleration"])
def test_near_within_a_solid_shows_its_inside_and_near_and_far_are_closed(
    make_scene, near, far, face, acceleration
):
    scene = make_scene([CUBE], eye=[0.0, 0.0, 8.0], near=near, far=far)
    assert cast(hsr.view(scene, (1, 1)), acceleration).face[0, 0] == face


@pytest.mark.parametrize("thing", [CUBE, SPHERE, CYLINDER, CONE, BUCKET], ids=lambda thing: thing["name"])
@pytest.mark.parametrize("mirror", [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]])
def test_culling_leaves_the_outside_or_the_inside_of_a_solid(make_scene, thing, mirror):
    depth = {}
    for cull in ("none", "back", "front"):
        objects = [thing | {"cull": cull, "transform": [{"scale": mirror}]}]
        view = hsr.view(make_scene(objects, eye=[0.0, 0.0, 8.0]), (1, 1))
        depth[cull] = agreed(view).depth[0, 0]
    assert depth["none"] == depth["back"] == 7.0
    assert depth["front"] == (9.0 if thing["shape"] != "cylinder" else 8.0)


@pytest.mark.parametrize("mirror", [[1, 1, 1], [-1, 1, 1], [1, 1, -1]])
def test_culling_a_square_is_culling_its_triangles(make_scene, mirror):
    corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
    as_mesh = {
        "name": "mesh",
        "shape": "mesh",
        "vertices": [[float(x) for x in corner] for corner in corners],
        "faces": [[0, 1, 2], [0, 2, 3]],
    }
    for cull in ("back", "front"):
        shown = []
        for thing in (SQUARE, as_mesh):
            steps = [{"scale": [float(x) for x in mirror]}, {"rotate_y": 30.0}]
            view = hsr.view(make_scene([thing | {"cull": cull, "transform": steps}]), (3, 3))
            shown.append(bool((agreed(view).face >= 0).any()))
        assert shown[0] == shown[1]
        assert shown[0] == ((mirror[2] > 0) == (cull == "back"))


def test_a_matrix_camera_sees_what_its_twin_sees(make_scene):
    objects = [CUBE | {"transform": [{"rotate_y": 25.0}]}, mesh(3, 20)]
    twin = hsr.view(make_scene(objects, near=1.0, far=50.0), (20, 16))
    matrix = (3.0 * twin.clip_from_world).tolist()
    view = hsr.view(with_matrix(objects, matrix), (20, 16))
    answer, expected = agreed(view), agreed(twin)
    assert (answer.face == expected.face).all()
    shown = answer.face >= 0
    assert answer.depth[shown] == pytest.approx(expected.depth[shown], rel=1e-12)


def with_matrix(objects, matrix):
    camera = {"type": "matrix", "matrix": matrix}
    return Scene.model_validate({"hsr": 1, "camera": [camera], "object": objects})


def test_depth_is_along_the_view_axis(make_scene):
    wall = SQUARE | {"transform": [{"scale": 10.0}]}
    answer = agreed(hsr.view(make_scene([wall], eye=[0.0, 0.0, 3.0], fov=90.0), (8, 8)))
    assert answer.depth == pytest.approx(np.full((8, 8), 3.0), rel=1e-15)


@pytest.mark.jit
def test_a_thin_ellipsoid_is_its_own_extent(make_scene):
    """Extents hold what an ill-conditioned transform makes of their shapes."""
    steps = [{"scale": [1.0, 1.0, 2.0**-30]}, {"rotate_x": 50.0}, {"rotate_y": 20.0}]
    agreed(hsr.view(make_scene([SPHERE | {"transform": steps}]), (80, 80)))


def test_work_is_counted_and_does_not_change_the_answer(make_scene):
    view = hsr.view(make_scene([mesh(1, 40), CUBE]), (12, 10))
    tests = {}
    for acceleration in SINGLE:
        counted = raycast.render(view, Options(acceleration, count=True))
        assert (counted.face == cast(view).face).all()
        assert counted.work["rays"] == 120
        tests[acceleration] = counted.work["face tests"]
    assert tests["none"] == 120 * 41
    assert tests["none"] > tests["extents"] > tests["hierarchy"] > 0
    assert cast(view).work == {}


@pytest.mark.jit
def test_the_answer_does_not_depend_on_the_number_of_threads(make_scene):
    import numba

    view = hsr.view(make_scene([mesh(2, 400)]), (90, 70))
    expected = cast(view)
    before = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        answer = cast(view)
    finally:
        numba.set_num_threads(before)
    assert answer.face.tobytes() == expected.face.tobytes()
    assert answer.depth.tobytes() == expected.depth.tobytes()


def test_hierarchies_are_built_once_a_scene(make_scene):
    scene = make_scene([mesh(5, 50)])
    one, other = hsr.view(scene, (4, 4)), hsr.view(scene, (5, 3))
    assert raycast._shapes(one) is raycast._shapes(other)


# ---------------------------------------------------------------- variants to study


STUDIED = [
    m for m in BUILT_IN if m.module == raycast.__name__ and m.settings.get("acceleration") == "hierarchy"
]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"acceleration": "octree"}, "choose from tiles, hierarchy, extents, none"),
        ({"test": "plucker"}, "choose from screen, edge-planes, moller-trumbore, woop"),
        ({"arithmetic": "float16"}, "choose from float64, float32"),
        ({"slabs": "padded"}, "choose from robust, naive"),
        ({"test": "woop"}, "choose acceleration 'hierarchy'"),
        ({"slabs": "naive"}, "choose acceleration 'hierarchy'"),
        ({"acceleration": "none", "certified": False}, "single rays are never certified"),
        ({"acceleration": "none", "arithmetic": "float32"}, "choose another test for float32"),
        ({"acceleration": "none", "slabs": "naive"}, "choose acceleration 'extents'"),
    ],
)
def test_unknown_options_and_those_that_do_not_combine_are_refused(options, message):
    with pytest.raises(MethodError, match=message):
        Options(**options)


@pytest.mark.parametrize("method", STUDIED, ids=lambda method: method.name)
@pytest.mark.parametrize("eye", EYES)
@pytest.mark.parametrize("cull", ["none", "back", "front"])
def test_the_variants_agree_where_rounding_decides_nothing(make_scene, method, eye, cull):
    """Near and far, both kinds of projection, mirrored objects, culling: the rules are the same for all."""
    mirrored = [{"scale": [-0.5, 0.5, 0.5]}, {"rotate_y": 20.0}]
    objects = [
        mesh(6, 12, 1.0) | {"cull": cull, "transform": mirrored},
        CUBE | {"cull": cull, "transform": [{"scale": 0.4}, {"rotate_x": 30.0}, {"rotate_z": 20.0}]},
        SPHERE | {"cull": cull, "transform": [{"scale": [0.5, 1.0, 0.5]}, {"translate": [-1.0, 0.0, -0.5]}]},
        CYLINDER | {"cull": cull, "transform": [{"scale": 0.5}, {"translate": [0.7, 0.9, 0.1]}]},
        CONE | {"cull": cull, "transform": [{"scale": 0.5}, {"translate": [-0.7, 0.9, 0.1]}]},
        SQUARE | {"cull": cull, "transform": [{"scale": 3.0}, {"rotate_x": -80.0}]},
    ]
    view = hsr.view(make_scene(objects, **EYES[eye]), (13, 11))
    answer, expected = method.render(view), cast(view, "none")
    assert (answer.face == expected.face).all()
    shown = answer.face >= 0
    assert shown.any()
    precise = "float32" not in method.name
    assert answer.depth[shown] == pytest.approx(expected.depth[shown], rel=1e-13 if precise else 1e-5)


@pytest.mark.jit
@pytest.mark.parametrize("method", STUDIED, ids=lambda method: method.name)
def test_the_hierarchy_leaves_out_nothing_that_the_list_finds(make_scene, method):
    """But by naive slabs, or where rounding moves a hit beside its triangle: neither is so here."""
    view = hsr.view(make_scene([mesh(8, 80, 1.0), CUBE], **EYES["amid"]), (40, 30))
    plain = method.settings | {"acceleration": "none", "slabs": "robust"}
    answer, expected = method.render(view), raycast.render(view, Options(**plain))
    assert (answer.face == expected.face).all()
    assert (answer.depth == expected.depth).all()


@pytest.mark.parametrize("test", ["edge-planes", "moller-trumbore", "woop"])
def test_in_space_a_sample_on_an_edge_belongs_to_both_triangles(make_scene, test):
    """The lower face wins, so that the right and lower borders are closed, too."""
    points = [[-1.5, 1.5, 0], [0.5, 1.5, 0], [1.5, 1.5, 0], [-1.5, -1.5, 0], [0.5, -1.5, 0], [1.5, -1.5, 0]]
    faces = [[0, 3, 4], [0, 4, 1], [1, 4, 5], [1, 5, 2]]
    thing = {"name": "pair", "shape": "mesh", "vertices": points, "faces": faces}
    view = lattice(make_scene, [thing], 4)
    answer = raycast.render(view, Options("none", test=test))
    assert (answer.face // 2).tolist() == [[0, 0, 0, 1]] * 4
    assert (answer.depth == 8.0).all()


WALL = {
    "name": "wall",
    "shape": "mesh",
    "vertices": [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0]],
    "faces": [[0, 1, 2]],
}


@pytest.mark.parametrize("test", ["screen", "edge-planes", "moller-trumbore", "woop"])
@pytest.mark.parametrize(
    ("near", "far", "shown"),
    [(8.0, 9.0, True), (7.0, 8.0, True), (8.0 + 2.0**-40, 9.0, False), (7.0, 7.5, False)],
)
def test_near_and_far_are_closed_whatever_the_test(make_scene, test, near, far, shown):
    view = hsr.view(make_scene([WALL], eye=[0.0, 0.0, 8.0], near=near, far=far), (1, 1))
    assert (raycast.render(view, Options("none", test=test)).face[0, 0] == 0) == shown


@pytest.mark.parametrize("thing", [WALL, CUBE, SPHERE], ids=lambda thing: thing["shape"])
def test_in_float32_every_depth_is_a_float32_number(make_scene, thing):
    tilted = [{"scale": 0.37}, {"rotate_x": 33.0}, {"rotate_y": 21.0}]
    view = hsr.view(make_scene([thing | {"transform": tilted}], **EYES["orthographic"]), (9, 9))
    answer = raycast.render(view, Options("none", test="woop", arithmetic="float32"))
    assert (answer.face >= 0).any()
    assert (answer.depth == answer.depth.astype(np.float32)).all()
    assert answer.notes["depth_format"]["step"] == 2.0**-23


def test_coordinates_beyond_float32_are_one_clear_line(make_scene):
    far_away = [[1e39, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    thing = {"name": "huge", "shape": "mesh", "vertices": far_away, "faces": [[0, 1, 2]]}
    view = hsr.view(make_scene([thing]), (2, 2))
    with pytest.raises(MethodError, match="beyond float32"):
        raycast.render(view, Options("none", test="woop", arithmetic="float32"))


@pytest.mark.parametrize("test", ["edge-planes", "moller-trumbore", "woop"])
def test_the_work_of_a_ray_is_that_of_its_hierarchy_whatever_the_test(make_scene, test):
    view = hsr.view(make_scene([mesh(1, 40), CUBE]), (12, 10))
    of_screen = raycast.render(view, Options("hierarchy", count=True)).work
    of_space = raycast.render(view, Options("hierarchy", count=True, test=test)).work
    assert of_space["rays"] == 120
    assert of_space == of_screen


def test_far_is_a_plane_and_infinity_is_the_background(make_scene):
    answer = agreed(hsr.view(make_scene([SPHERE], eye=[0.0, 0.0, 5.0]), (3, 3)))
    assert answer.face[0, 0] == -1
    assert answer.depth[0, 0] == math.inf
