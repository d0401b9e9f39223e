"""Mesh files: the order of their faces, and what is refused."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from hsr.base.errors import SceneError
from hsr.scene import meshes
from hsr.scene.meshes import Faces, joined, mesh_shape, read_faces
from hsr.scene.shapes import Shape

SQUARE_OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def read(folder: Path, name: str, content: str | bytes) -> Shape:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return mesh_shape(read_faces(path))


def loops(shape: Shape) -> list[list[int]]:
    assert shape.polygons is not None
    triangles: list[list[int]] = shape.polygons.triangle_vertex.tolist()
    return triangles


# ---------------------------------------------------------------- OBJ


def test_obj_faces_keep_their_order_across_objects_groups_and_materials(tmp_path: Path) -> None:
    text = (
        "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
        "o B\nusemtl red\nf 1 2 3\ng one\nusemtl blue\nf 1 2 4\n"
        "o A\nusemtl red\nf 1 3 4\nv 5 5 5\ng one\nusemtl blue\nf 2 3 5\ns off\nf 4 3 2\n"
    )
    shape = read(tmp_path, "a.obj", text)
    assert loops(shape) == [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 4], [3, 2, 1]]


def test_obj_relative_indices_count_from_the_vertices_so_far(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 9 0 0\nv 9 1 0\nv 9 0 1\nf -3 -2 -1\n"
    assert loops(read(tmp_path, "a.obj", text)) == [[0, 1, 2], [3, 4, 5]]


def test_obj_corners_may_carry_texture_and_normals(tmp_path: Path) -> None:
    text = (
        SQUARE_OBJ + "vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf 1//1 2//1 3//1\nf 1/1 2/1 3/1\nf 1 2 3 # end\n"
    )
    assert loops(read(tmp_path, "a.obj", text)) == [[0, 1, 2]] * 4


def test_obj_polygons_are_cut_into_fans_in_place(tmp_path: Path) -> None:
    shape = read(tmp_path, "a.obj", SQUARE_OBJ + "f 1 2 3\nf 2 3 4 1\nf 3 2 1\n")
    assert loops(shape) == [[0, 1, 2], [1, 2, 3], [1, 3, 0], [2, 1, 0]]
    assert shape.cut == 1 and shape.faces == 4


def test_obj_lines_may_be_continued_and_end_in_any_way(tmp_path: Path) -> None:
    text = "v 0 0 0\r\nv 1 0\\\r\n 0\r\nv 0 1 0\r\nf 1 2 \\\r\n3\r\n"
    assert loops(read(tmp_path, "a.OBJ", text)) == [[0, 1, 2]]


def test_obj_comments_may_be_in_any_encoding(tmp_path: Path) -> None:
    assert read(tmp_path, "a.obj", b"# caf\xe9 \x85\n" + SQUARE_OBJ.encode() + b"f 1 2 3\n").faces == 1


def test_degenerate_triangles_stay(tmp_path: Path) -> None:
    assert loops(read(tmp_path, "a.obj", SQUARE_OBJ + "f 1 1 2\nf 1 2 3\n")) == [[0, 0, 1], [0, 1, 2]]


# ---------------------------------------------------------------- OFF, PLY, STL


def test_off_faces_of_mixed_size_keep_their_order(tmp_path: Path) -> None:
    text = "OFF # title\n\n4 3 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n4 1 2 3 0 255 0 0\n3 2 1 0\n"
    shape = read(tmp_path, "a.off", text)
    assert loops(shape) == [[0, 1, 2], [1, 2, 3], [1, 3, 0], [2, 1, 0]]
    assert shape.cut == 1


def test_off_may_have_colours_and_its_counts_beside_the_word(tmp_path: Path) -> None:
    text = "COFF 3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 0 0 0\n0 1 0 9 9 9 9\n3 0 1 2\n"
    assert loops(read(tmp_path, "a.off", text)) == [[0, 1, 2]]


PLY_HEADER = (
    "ply\nformat {} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face {}\nproperty list uchar int vertex_indices\nend_header\n"
)
PLY_VERTICES = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"


def test_ply_faces_of_mixed_size_keep_their_order(tmp_path: Path) -> None:
    text = PLY_HEADER.format("ascii", 3) + PLY_VERTICES + "3 0 1 2\n4 1 2 3 0\n3 2 1 0\n"
    shape = read(tmp_path, "a.ply", text)
    assert loops(shape) == [[0, 1, 2], [1, 2, 3], [1, 3, 0], [2, 1, 0]]
    assert shape.cut == 1


def test_ply_squares_keep_their_order(tmp_path: Path) -> None:
    text = PLY_HEADER.format("ascii", 2) + PLY_VERTICES + "4 0 1 2 3\n4 3 2 1 0\n"
    assert loops(read(tmp_path, "a.ply", text)) == [[0, 1, 2], [0, 2, 3], [3, 2, 1], [3, 1, 0]]


@pytest.mark.parametrize("key", ["vertex_indices", "vertex_index"])
def test_a_ply_file_of_one_face(tmp_path: Path, key: str) -> None:
    text = PLY_HEADER.format("ascii", 1).replace("vertex_indices", key) + PLY_VERTICES + "3 0 1 2\n"
    assert loops(read(tmp_path, "a.ply", text)) == [[0, 1, 2]]


def test_binary_ply(tmp_path: Path) -> None:
    vertices = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0)
    faces = struct.pack("<BiiiBiii", 3, 0, 1, 2, 3, 0, 2, 3)
    content = PLY_HEADER.format("binary_little_endian", 2).encode() + vertices + faces
    assert loops(read(tmp_path, "a.ply", content)) == [[0, 1, 2], [0, 2, 3]]


def test_ply_points_without_faces(tmp_path: Path) -> None:
    text = PLY_HEADER.format("ascii", 0).replace(
        "element face 0\nproperty list uchar int vertex_indices\n", ""
    )
    with pytest.raises(SceneError, match=r"^the mesh has no faces$"):
        read(tmp_path, "a.ply", text + PLY_VERTICES)


def stl_facet(*corners: str) -> str:
    inner = "".join(f"vertex {corner}\n" for corner in corners)
    return f"facet normal 0 0 1\nouter loop\n{inner}endloop\nendfacet\n"


def test_text_stl_of_several_solids(tmp_path: Path) -> None:
    one, two = stl_facet("0 0 0", "1 0 0", "0 1 0"), stl_facet("0 0 5", "1 0 5", "0 1 5")
    shape = read(tmp_path, "a.stl", f"solid b\n{two}endsolid b\nsolid a\n{one}endsolid a\n")
    assert shape.polygons is not None
    assert shape.polygons.vertices[shape.polygons.triangle_vertex][:, 0, 2].tolist() == [5.0, 0.0]


def test_binary_stl(tmp_path: Path) -> None:
    facet = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0)
    shape = read(tmp_path, "a.stl", bytes(80) + struct.pack("<I", 2) + facet + facet)
    assert loops(shape) == [[0, 1, 2], [3, 4, 5]]


# ---------------------------------------------------------------- problems


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("a.obj", SQUARE_OBJ, "the mesh has no faces"),
        ("a.obj", SQUARE_OBJ + "f 1 2\n", "face 0 (counted from 0) has fewer than three corners"),
        (
            "a.obj",
            SQUARE_OBJ + "f 1 2 3\nf 1 2 5\n",
            "face 1 (counted from 0) names a vertex that does not exist; ",
        ),
        (
            "a.obj",
            SQUARE_OBJ + "f 0 1 2\n",
            "face 0 (counted from 0) names a vertex that does not exist; there are 4",
        ),
        (
            "a.obj",
            "v 0 0 0\nf -1 -2 -1\nv 1 1 1\n",
            "face 0 (counted from 0) names a vertex that does not exist; ",
        ),
        ("a.obj", SQUARE_OBJ + "f 1 2 x\n", "cannot read the line 'f 1 2 x'"),
        ("a.obj", "v 0 0\nf 1 1 1\n", "cannot read the line 'v 0 0'"),
        ("a.obj", "v 0 inf 0\nf 1 1 1\n", "vertex 0 (counted from 0) is not finite: 0 inf 0"),
        ("a.obj", "v 0 1e300 0\nf 1 1 1\n", "vertex 0 (counted from 0) is too large: 0 1e+300 0"),
        ("a.off", "ply\n", "an OFF file starts with the word OFF"),
        ("a.off", "", "an OFF file starts with the word OFF"),
        ("a.off", "OFF\n3 1 0\n0 0 0\n", "it ends before its 3 vertices and 1 faces"),
        ("a.off", "OFF\n1 1 0\n0 0 0\n3 0 0\n", "a face lists fewer corners than it announces"),
        ("a.off", "OFF\n1 1 0\n0 x 0\n3 0 0 0\n", "not a readable OFF file (ValueError: could not convert"),
        ("a.ply", "nothing", "not a readable PLY file (ValueError: "),
        ("a.stl", "nothing", "the mesh has no faces"),
        (
            "a.stl",
            f"solid x\n{stl_facet('0 0 0', '1 0 0', '0 1')}endsolid x\n" + 80 * " ",
            "not a readable STL file",
        ),
    ],
)
def test_files_that_are_refused(tmp_path: Path, name: str, content: str, problem: str) -> None:
    with pytest.raises(SceneError) as caught:
        read(tmp_path, name, content)
    assert str(caught.value).startswith(problem)
    assert "\n" not in str(caught.value)


def test_too_many_triangles(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(meshes, "MAX_TRIANGLES", 1)
    with pytest.raises(SceneError, match=r"^the mesh has more than 1 triangles; split it$"):
        mesh_shape(Faces.of(np.zeros((4, 3)), [0, 1, 2, 3], [4]))


def test_joined_meshes_keep_their_own_vertices() -> None:
    one, two = Faces.of(np.zeros((3, 3)), [0, 1, 2], [3]), Faces.of(np.ones((4, 3)), [3, 2, 1, 0], [4])
    both = joined([one, two])
    assert both.corner.tolist() == [0, 1, 2, 6, 5, 4, 3]
    assert both.sides.tolist() == [3, 4] and both.vertices.shape == (7, 3)
