"""Generated meshes: their numbers, their winding, and what is known of their shape."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from hsr.base.arrays import Array, Floats, Ints
from hsr.scene.files import shape_of
from hsr.scene.model import Object
from hsr.scene.shapes import Polygons, fir, menger, teapot, terrain, torus_knot


def sides(polygons: Polygons) -> Counter[tuple[int, int]]:
    """Count the directed sides of all polygons."""
    loops = np.split(polygons.corner, polygons.start[1:-1])
    return Counter((int(a), int(b)) for loop in loops for a, b in zip(loop, np.roll(loop, -1), strict=True))


def is_closed(polygons: Polygons) -> bool:
    """Whether each side is walked as often one way as the other."""
    count = sides(polygons)
    return all(count[b, a] == times for (a, b), times in count.items())


def normals(polygons: Polygons) -> Floats:
    """Area vectors (n, 3) of the fan triangles."""
    a, b, c = np.moveaxis(polygons.vertices[polygons.triangle_vertex], 1, 0)
    return np.asarray(np.cross(b - a, c - a) / 2.0)


def volume(vertices: Floats, triangles: Array) -> float:
    """Signed volume, about the middle of the vertices: positive if the triangles face outward."""
    a, b, c = np.moveaxis(vertices[triangles] - vertices[np.unique(triangles)].mean(axis=0), 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def components(polygons: Polygons) -> list[Ints]:
    """Triangles of each connected part."""
    triangles, count = polygons.triangle_vertex, len(polygons.vertices)
    links = coo_array((np.ones(len(triangles)), triangles[:, :2].T), (count, count))
    links += coo_array((np.ones(len(triangles)), triangles[:, 1:].T), (count, count))
    parts, label = connected_components(links, directed=False)
    return [triangles[label[triangles[:, 0]] == part] for part in range(parts)]


def as_set(points: Floats) -> set[tuple[float, ...]]:
    return {tuple(point) for point in (points.reshape(-1, points.shape[-1]) + 0.0).tolist()}


# ---------------------------------------------------------------- all of them

ANY: TypeAdapter[Object] = TypeAdapter(Object)

THINGS: list[tuple[dict[str, Any], Polygons]] = [
    ({"shape": "teapot", "detail": 3}, teapot.polygons(3)),
    (
        {"shape": "torus-knot", "p": 3, "q": 4, "segments": 40, "sides": 5, "thickness": 0.2},
        torus_knot.polygons(3, 4, 40, 5, 0.2),
    ),
    (
        {"shape": "terrain", "detail": 3, "roughness": 0.4, "height": 0.2, "seed": 9},
        terrain.polygons(3, 0.4, 0.2, 9),
    ),
    ({"shape": "menger", "level": 1}, menger.polygons(1)),
    ({"shape": "fir", "tiers": 3, "sides": 7}, fir.polygons(3, 7)),
]


@pytest.mark.parametrize(("table", "expected"), THINGS, ids=[table["shape"] for table, _ in THINGS])
def test_a_description_gives_its_shape_to_the_byte(table: dict[str, Any], expected: Polygons) -> None:
    thing = ANY.validate_python({"name": "thing", **table})
    made = shape_of(thing, Path()).polygons
    assert made is not None
    assert made.vertices.tobytes() == expected.vertices.tobytes()
    assert made.corner.tobytes() == expected.corner.tobytes()


@pytest.mark.parametrize("polygons", [made for _, made in THINGS], ids=[t["shape"] for t, _ in THINGS])
def test_meshes_are_of_the_promised_types_and_use_every_vertex(polygons: Polygons) -> None:
    assert polygons.vertices.dtype == np.float64 and np.isfinite(polygons.vertices).all()
    assert {polygons.corner.dtype, polygons.start.dtype, polygons.face.dtype} == {np.dtype(np.int32)}
    assert np.unique(polygons.corner).tolist() == list(range(len(polygons.vertices)))
    assert len(as_set(polygons.vertices)) == len(polygons.vertices)
    assert polygons.face.tolist() == list(range(len(polygons)))
    assert max(sides(polygons).values()) == 1
    assert np.linalg.norm(normals(polygons), axis=1).min() > 1e-6


@pytest.mark.parametrize(
    "table",
    [{"shape": "teapot", "detail": 1}, {"shape": "torus-knot", "p": 2, "q": 4}],
    ids=["flat handle", "curve over itself"],
)
def test_what_would_coincide_with_itself_is_refused(table: dict[str, Any]) -> None:
    with pytest.raises(ValidationError, match=r"greater than or equal to 2|common factor"):
        ANY.validate_python({"name": "thing", **table})


# ---------------------------------------------------------------- teapot


def test_the_teapot_has_the_32_patches_and_290_points_of_the_published_list() -> None:
    patches = teapot.patches()
    assert patches.shape == (32, 4, 4, 3)
    points = as_set(patches)
    assert len(points) == 290
    # One point of each part, as (x, y, z) of the list with its z up: (x, z, -y) here.
    assert {(1.4, 2.4, 0.784), (0.0, 3.15, 0.0), (-2.65, 0.9375, 0.3), (3.525, 2.49375, 0.25)} <= points


def test_the_teapot_is_its_own_mirror_image_and_the_pot_its_own_quarter_turn() -> None:
    patches = teapot.patches()
    assert as_set(patches * [1.0, 1.0, -1.0]) == as_set(patches)
    pot = patches[:24]
    assert as_set(pot[..., [2, 1, 0]] * [-1.0, 1.0, 1.0]) == as_set(pot)


@pytest.mark.parametrize("detail", [2, 5, 8])
def test_the_teapot_stands_on_the_ground_and_has_its_known_extent(detail: int) -> None:
    polygons = teapot.polygons(detail)
    assert len(polygons) == 64 * detail**2 - 8 * detail
    low, high = polygons.vertices.min(axis=0), polygons.vertices.max(axis=0)
    assert low.tolist() == [-3.0, 0.0, -2.0]
    assert high[1:].tolist() == [3.15, 2.0] and 3.42 < high[0] < 3.44


def test_pot_lid_handle_and_spout_face_outward() -> None:
    detail = 8
    polygons, patch = teapot.polygons(detail), 2 * detail**2
    # In the order of the patches; pot and lid each end in a point where triangles are left out.
    counts = [16 * patch - 4 * detail, 8 * patch - 4 * detail, 4 * patch, 4 * patch]
    parts = np.split(polygons.triangle_vertex, np.cumsum(counts)[:-1])
    volumes = [volume(polygons.vertices, part) for part in parts]
    assert min(volumes) > 0.2


def test_the_open_ends_of_the_teapot_are_those_of_lid_pot_handle_and_spout() -> None:
    detail = 4
    count = sides(teapot.polygons(detail))
    border = sum((b, a) not in count for a, b in count)
    # A round of the rim, a round of the lid; two ends each of handle and spout, of two patches.
    assert border == (4 + 4 + 2 * 2 + 2 * 2) * detail


# ---------------------------------------------------------------- torus knot


@pytest.mark.parametrize(("p", "q"), [(2, 3), (3, 2), (1, 1), (5, 4)])
def test_the_knot_is_a_closed_tube_of_the_volume_that_pappus_gives(p: int, q: int) -> None:
    segments, corners, thickness = 600, 12, 0.1
    polygons = torus_knot.polygons(p, q, segments, corners, thickness)
    assert len(polygons) == 2 * segments * corners
    assert is_closed(polygons) and len(components(polygons)) == 1
    rings = polygons.vertices.reshape(segments, corners, 3)
    centre = rings.mean(axis=1)
    assert np.allclose(np.linalg.norm(rings - centre[:, None], axis=2), thickness, rtol=1e-12, atol=0.0)
    length = np.linalg.norm(centre - np.roll(centre, 1, axis=0), axis=1).sum()
    section = corners / 2 * np.sin(2 * np.pi / corners) * thickness**2
    assert volume(polygons.vertices, polygons.triangle_vertex) == pytest.approx(length * section, rel=4e-3)


def test_the_knot_winds_p_times_around_the_axis_and_q_times_around_the_core() -> None:
    p, q = 3, 5
    centre = torus_knot.polygons(p, q, 400, 8, 0.1).vertices.reshape(400, 8, 3).mean(axis=1)

    def turns(x: Array, y: Array) -> int:
        angle = np.unwrap(np.arctan2(y, x), period=2 * np.pi)
        return int(np.rint((angle[-1] - angle[0]) / (2 * np.pi)))

    x, y, z = centre.T
    assert (turns(x, y), turns(np.hypot(x, y) - 2.0, z)) == (p, q)


# ---------------------------------------------------------------- terrain


def heights(detail: int, roughness: float, height: float, seed: int) -> Floats:
    side = 2**detail + 1
    return terrain.polygons(detail, roughness, height, seed).vertices[:, 1].reshape(side, side)


def test_terrain_covers_the_square_and_looks_up() -> None:
    polygons = terrain.polygons(4, 0.6, 0.9, 3)
    assert len(polygons) == 2 * 4**4
    across = 2.0 / 16
    assert np.allclose(normals(polygons)[:, 1], across**2 / 2.0, rtol=1e-12, atol=0.0)
    assert as_set(polygons.vertices[:, [0, 2]]) == {
        (-1.0 + across * i, -1.0 + across * j) for i in range(17) for j in range(17)
    }


def test_every_step_keeps_the_points_there_are_and_displaces_the_middles() -> None:
    roughness, height = 0.5, 0.8
    for detail in range(1, 6):
        coarse, fine = heights(detail, roughness, height, 7), heights(detail + 1, roughness, height, 7)
        assert (fine[::2, ::2] == coarse).all()
        reach = height * roughness**detail
        moved = [
            fine[::2, 1::2] - (coarse[:, 1:] + coarse[:, :-1]) / 2,
            fine[1::2, ::2] - (coarse[1:] + coarse[:-1]) / 2,
            fine[1::2, 1::2] - (coarse[1:, 1:] + coarse[1:, :-1] + coarse[:-1, 1:] + coarse[:-1, :-1]) / 4,
        ]
        assert all(0.0 < np.abs(part).max() <= reach * (1 + 1e-12) for part in moved)
        if detail == 5:
            assert all(np.abs(part).max() > 0.9 * reach and part.min() < 0.0 < part.max() for part in moved)


def test_the_corners_of_a_terrain_lie_at_height_0_and_seeds_differ() -> None:
    field = heights(3, 0.5, 0.5, 0)
    assert field[::8, ::8].tolist() == [[0.0, 0.0], [0.0, 0.0]]
    assert (field == heights(3, 0.5, 0.5, 0)).all() and (field != heights(3, 0.5, 0.5, 1)).any()


# ---------------------------------------------------------------- Menger sponge


@pytest.mark.parametrize(("level", "squares"), [(0, 6), (1, 72), (2, 1056), (3, 18048)])
def test_the_sponge_is_closed_and_has_its_known_volume_and_surface(level: int, squares: int) -> None:
    polygons = menger.polygons(level)
    assert len(polygons) == squares
    assert (np.diff(polygons.start) == 4).all()
    assert is_closed(polygons)
    assert volume(polygons.vertices, polygons.triangle_vertex) == pytest.approx(8 * (20 / 27) ** level)
    assert (polygons.vertices.min(), polygons.vertices.max()) == (-1.0, 1.0)


def test_the_squares_of_the_sponge_are_plane_to_the_last_bit() -> None:
    polygons = menger.polygons(2)
    corners = polygons.vertices[polygons.corner].reshape(-1, 4, 3)
    flat = (corners == corners[:, :1]).all(axis=1)
    assert (flat.sum(axis=1) == 1).all()


def test_a_cell_is_gone_if_two_of_its_coordinates_are_in_the_middle() -> None:
    gone = {tuple(cell) for cell in np.argwhere(~menger._sponge(1)).tolist()}
    assert gone == {(1, 1, 1), (0, 1, 1), (2, 1, 1), (1, 0, 1), (1, 2, 1), (1, 1, 0), (1, 1, 2)}


# ---------------------------------------------------------------- fir


@pytest.mark.parametrize(("tiers", "tips"), [(5, 32), (1, 3), (16, 5)])
def test_a_fir_is_a_trunk_and_cones_each_closed_and_outward(tiers: int, tips: int) -> None:
    polygons = fir.polygons(tiers, tips)
    assert len(polygons) == 8 * tiers * tips + 28
    assert is_closed(polygons)
    parts = components(polygons)
    assert len(parts) == tiers + 1
    assert all(volume(polygons.vertices, part) > 0.0 for part in parts)


def test_a_fir_stands_on_the_origin_and_is_1_high() -> None:
    vertices = fir.polygons(5, 32).vertices
    assert vertices[:, 1].min() == 0.0 and vertices[:, 1].max() == pytest.approx(1.0, abs=1e-15)
    assert np.abs(vertices[:, [0, 2]].mean(axis=0)).max() < 1e-15
    assert len(fir.polygons(5, 32)) == 1308
