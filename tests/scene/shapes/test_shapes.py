"""The generic shapes and their polygons."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

from hsr.scene.polyhedra import convexity_problems
from hsr.scene.shapes import Polygons, generic, tessellated
from hsr.scene.solids import surface_problem


def loops(polygons: Polygons) -> list[tuple[int, ...]]:
    corner, start = polygons.corner.tolist(), polygons.start.tolist()
    return [tuple(corner[a:b]) for a, b in pairwise(start)]


def test_the_cube_is_convex_and_its_faces_are_named_by_their_sides() -> None:
    cube = generic("cube")
    assert cube.polygons is not None and cube.faces == 6
    assert convexity_problems(cube.polygons.vertices, loops(cube.polygons)) == []
    middles = [cube.polygons.vertices[list(loop)].mean(axis=0).tolist() for loop in loops(cube.polygons)]
    sides = {"top": [0, 1, 0], "bottom": [0, -1, 0], "right": [1, 0, 0], "left": [-1, 0, 0]}
    assert dict(zip(cube.face_names, middles, strict=True)) == {
        **sides,
        "front": [0, 0, 1],
        "back": [0, 0, -1],
    }


def test_the_front_of_the_square_is_toward_z() -> None:
    square = generic("square").polygons
    assert square is not None
    a, b, c = square.vertices[square.corner[:3]]
    assert np.cross(b - a, c - a).tolist() == [0.0, 0.0, 4.0]


def test_generic_shapes_are_made_once() -> None:
    assert generic("sphere") is generic("sphere")


@pytest.mark.parametrize("segments", [3, 4, 5, 48])
def test_the_sphere_in_polygons_is_convex_and_one_face(segments: int) -> None:
    polygons = tessellated(generic("sphere"), segments).polygons
    assert polygons is not None
    assert convexity_problems(polygons.vertices, loops(polygons)) == []
    assert np.allclose(np.linalg.norm(polygons.vertices, axis=1), 1.0, rtol=0.0, atol=2.0**-52)
    assert not polygons.face.any() and tessellated(generic("sphere"), segments).faces == 1


@pytest.mark.parametrize("segments", [3, 4, 5, 48])
def test_the_cylinder_in_polygons_is_convex_with_side_base_and_cap(segments: int) -> None:
    shape = tessellated(generic("cylinder"), segments)
    assert shape.polygons is not None
    assert convexity_problems(shape.polygons.vertices, loops(shape.polygons)) == []
    assert shape.face_names == ("side", "base", "cap")
    assert shape.polygons.face.tolist() == [0] * segments + [1, 2]
    z = [set(shape.polygons.vertices[list(loop)][:, 2]) for loop in loops(shape.polygons)]
    assert z == [{0.0, 1.0}] * segments + [{0.0}, {1.0}]


@pytest.mark.parametrize("top", [0.0, 0.5, 3.0])
@pytest.mark.parametrize("segments", [3, 4, 48])
def test_a_tapered_cylinder_in_polygons_has_its_corners_on_the_cone(top: float, segments: int) -> None:
    shape = tessellated(generic("cylinder", top=top), segments)
    assert shape.polygons is not None and surface_problem(shape.polygons) == ""
    assert shape.face_names == (("side", "base", "cap") if top else ("side", "base"))
    assert shape.polygons.face.tolist() == [0] * segments + [1, 2][: shape.faces - 1]
    x, y, z = shape.polygons.vertices.T
    assert np.hypot(x, y) == pytest.approx(np.where(z == 0.0, 1.0, top))
    assert set(z) == {0.0, 1.0}


@pytest.mark.parametrize("top", [0.0, 0.1, 1.0, 3.0, 1e200, 5e-324])
def test_the_side_of_a_cylinder_is_its_equation_exactly(top: float) -> None:
    solid = generic("cylinder", top=top).quadric
    assert solid is not None
    for z in (0, Fraction(1, 3), 1):
        p = np.array([Fraction(3, 5) * (1 + (Fraction(top) - 1) * z)] * 2 + [z, 1])
        p[1] *= Fraction(4, 3)
        assert p @ solid.form @ p == 0
        assert (p * [2, 2, 1, 1]) @ solid.form @ (p * [2, 2, 1, 1]) > 0 or p[0] == 0
    assert ((solid.ends @ p >= 0) == (p[2] >= 0) & (p[2] <= 1)).all()
    assert solid.box.tolist() == [[-max(1.0, top)] * 2 + [0.0], [max(1.0, top)] * 2 + [1.0]]


def test_polygons_are_fans_about_their_first_corner() -> None:
    polygons = Polygons.of(np.zeros((6, 3)), [(0, 1, 2), (1, 2, 3, 4, 5), (5, 4, 3, 2)], [7, 8, 7])
    assert polygons.triangle_vertex.tolist() == [
        [0, 1, 2],
        [1, 2, 3],
        [1, 3, 4],
        [1, 4, 5],
        [5, 4, 3],
        [5, 3, 2],
    ]
    assert polygons.triangle_polygon.tolist() == [0, 1, 1, 1, 2, 2]
    assert polygons.triangle_face.tolist() == [7, 8, 8, 8, 7, 7]


def test_used_vertices_are_no_copy_unless_some_are_not_used() -> None:
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9]])
    alike, fewer = (Polygons.of(some, [(0, 1, 2)]) for some in (vertices[:3], vertices))
    assert alike.used is alike.vertices and fewer.used.tolist() == vertices[:3].tolist()
    assert fewer.reach(np.array([1.0, 2.0, 0.0, 5.0])) == (5.0, 7.0)


def test_triangles_are_their_own_fans() -> None:
    polygons = Polygons.of_rows(np.zeros((4, 3)), np.array([[0, 1, 2], [3, 2, 1]], dtype=np.int32))
    assert polygons.triangle_vertex.tolist() == [[0, 1, 2], [3, 2, 1]]
    assert polygons.triangle_face.tolist() == [0, 1] and len(polygons) == 2
