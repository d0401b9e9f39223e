"""Wavefront OBJ files."""

from __future__ import annotations

import pytest
from hypothesis import given

from hsr.scene.meshes import mesh_shape
from hsr.scene.readers.obj import read_obj
from hsr.scene.shapes import Shape
from tests.scene.readers.made import Mesh, cuts, meshes, refused, same, write_obj


def read(content: str | bytes) -> Shape:
    return mesh_shape(read_obj(content.encode() if isinstance(content, str) else content))


SQUARE_OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def loops(shape: Shape) -> list[list[int]]:
    assert shape.polygons is not None
    triangles: list[list[int]] = shape.polygons.triangle_vertex.tolist()
    return triangles


def test_obj_faces_keep_their_order_across_objects_groups_and_materials() -> None:
    text = (
        "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
        "o B\nusemtl red\nf 1 2 3\ng one\nusemtl blue\nf 1 2 4\n"
        "o A\nusemtl red\nf 1 3 4\nv 5 5 5\ng one\nusemtl blue\nf 2 3 5\ns off\nf 4 3 2\n"
    )
    shape = read(text)
    assert loops(shape) == [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 4], [3, 2, 1]]


def test_obj_relative_indices_count_from_the_vertices_so_far() -> None:
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 9 0 0\nv 9 1 0\nv 9 0 1\nf -3 -2 -1\n"
    assert loops(read(text)) == [[0, 1, 2], [3, 4, 5]]


def test_obj_corners_may_carry_texture_and_normals() -> None:
    text = (
        SQUARE_OBJ + "vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf 1//1 2//1 3//1\nf 1/1 2/1 3/1\nf 1 2 3 # end\n"
    )
    assert loops(read(text)) == [[0, 1, 2]] * 4


def test_obj_polygons_are_cut_into_fans_in_place() -> None:
    shape = read(SQUARE_OBJ + "f 1 2 3\nf 2 3 4 1\nf 3 2 1\n")
    assert loops(shape) == [[0, 1, 2], [1, 2, 3], [1, 3, 0], [2, 1, 0]]
    assert shape.cut == 1 and shape.faces == 4


def test_obj_lines_may_be_continued_and_end_in_any_way() -> None:
    text = "v 0 0 0\r\nv 1 0\\\r\n 0\r\nv 0 1 0\r\nf 1 2 \\\r\n3\r\n"
    assert loops(read(text)) == [[0, 1, 2]]


def test_obj_comments_may_be_in_any_encoding() -> None:
    assert read(b"# caf\xe9 \x85\n" + SQUARE_OBJ.encode() + b"f 1 2 3\n").faces == 1


def test_degenerate_triangles_stay() -> None:
    assert loops(read(SQUARE_OBJ + "f 1 1 2\nf 1 2 3\n")) == [[0, 0, 1], [0, 1, 2]]


@given(meshes())
def test_what_is_written_is_read(mesh: Mesh) -> None:
    content = write_obj(mesh)
    assert same(read_obj(content), mesh)
    assert same(read_obj(content.decode().replace("\n", " \t\r").encode("utf-8-sig")), mesh)
    assert same(read_obj(content.decode().encode("utf-16")), mesh)


def test_only_numbers_are_continued() -> None:
    text = "# C:\\models\\\nmtllib C:\\\nv 0 0 0 # \\\no a\\\nv 1 0 \\\n0\nv 0 1 0\ng \\\nf 1 2 \\ \n\\\n3"
    assert loops(read(text)) == [[0, 1, 2]]
    assert loops(read(text + "\\")) == [[0, 1, 2]]


def test_a_vertex_that_no_face_uses_may_be_anything() -> None:
    shape = read("v nan nan nan\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1e999 -1.#IND nan(ind)\nf 2 3 4\n")
    assert shape.polygons is not None and shape.polygons.vertices[[0, 4]].tolist() == [[0, 0, 0]] * 2


def test_a_file_cut_off_has_the_faces_before() -> None:
    content = (SQUARE_OBJ + "f 1 2 3\nf 2 3 4 1\n").encode()
    for end, faces in cuts(content, read_obj):
        assert len(faces.sides) == content[:end].count(b"f")


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (SQUARE_OBJ + "\nf 1 2 x\n", "line 6: cannot read 'f 1 2 x'"),
        ("v 0 0\nf 1 1 1\n", "line 1: cannot read 'v 0 0'"),
        ("v 0 1_0 0\n", "line 1: cannot read 'v 0 1_0 0'"),
        ("v 0 \\\n0\nf 1 1_1 1\n", "line 1: cannot read 'v 0  0'"),
        (SQUARE_OBJ + "f 1 2 99999999999999999999\n", "line 5: cannot read "),
        (SQUARE_OBJ + "surf 0 1 0 1 1 2 3 4\n", "line 5: cannot read 'surf 0 1 0 1 1 2 3 4': export "),
        (SQUARE_OBJ + "f 1 2 \xa0\n", "line 5: cannot read 'f 1 2"),
    ],
)
def test_lines_that_are_refused(content: str, problem: str) -> None:
    assert refused(read_obj, content).startswith(problem)
