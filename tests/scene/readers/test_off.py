"""OFF files."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hsr.scene.meshes import mesh_shape
from hsr.scene.readers.off import read_off
from hsr.scene.shapes import Shape
from tests.scene.readers.made import Mesh, cuts, meshes, refused, same, write_off


def read(content: str | bytes) -> Shape:
    return mesh_shape(read_off(content.encode() if isinstance(content, str) else content))


def loops(shape: Shape) -> list[list[int]]:
    assert shape.polygons is not None
    triangles: list[list[int]] = shape.polygons.triangle_vertex.tolist()
    return triangles


def test_off_faces_of_mixed_size_keep_their_order() -> None:
    text = "OFF # title\n\n4 3 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n4 1 2 3 0 255 0 0\n3 2 1 0\n"
    shape = read(text)
    assert loops(shape) == [[0, 1, 2], [1, 2, 3], [1, 3, 0], [2, 1, 0]]
    assert shape.cut == 1


def test_off_may_have_colours_and_its_counts_beside_the_word() -> None:
    text = "COFF 3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 0 0 0\n0 1 0 9 9 9 9\n3 0 1 2\n"
    assert loops(read(text)) == [[0, 1, 2]]


@given(meshes(), st.sampled_from(["OFF\n", "OFF", "OFF # title\n\n", "STCN4OFF "]))
def test_what_is_written_is_read(mesh: Mesh, first: str) -> None:
    content = write_off(mesh, first, " 1 0 0 1" if "4" in first else "")
    assert same(read_off(content), mesh)
    assert same(read_off(content.decode().replace("\n", " \t\r").encode("utf-8-sig")), mesh)


def test_the_fourth_coordinate_divides_the_others() -> None:
    text = "4OFF\n4 1 0\n0 0 0 2\n1 0 0 2\n0 1 0 -4\n1 1 1 0\n3 0 1 2\n"
    with np.errstate(all="ignore"):
        vertices = read_off(text.encode()).vertices
    assert vertices[:3].tolist() == [[0, 0, 0], [0.5, 0, 0], [0, -0.25, 0]]
    with np.errstate(all="ignore"):
        assert refused(read, text.replace("0 1 2\n", "0 1 3\n")).startswith("vertex 3 (")


def test_a_file_cut_off_is_refused() -> None:
    content = b"OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n4 0 1 2 3\n"
    assert [end for end, _ in cuts(content, read_off)] == [len(content) - 1]


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("ply\n", "an OFF file starts with the word OFF"),
        ("", "an OFF file starts with the word OFF"),
        ("FOOOFF 1 1\n", "an OFF file starts with the word OFF"),
        ("OFF\n", "line 1: cannot read 'OFF': expected how many vertices and faces there are"),
        ("OFF\n-1 2\n0 0 0\n", "line 2: cannot read '-1 2': expected how many"),
        ("OFF\n3\n", "line 2: cannot read '3': expected how many"),
        ("OFF\n3 1 0\n0 0 0\n", "it ends before its 3 vertices and 1 faces"),
        ("OFF\n1 1 0\n0 0 0\n3 0 0\n", "line 4: cannot read '3 0 0': it has fewer numbers than it announces"),
        ("OFF\n1 1 0\n0 x 0\n3 0 0 0\n", "line 3: cannot read '0 x 0'"),
        ("OFF\n1 1 0\n0 0\n3 0 0 0\n", "line 3: cannot read '0 0': it has fewer numbers"),
        ("OFF BINARY\n\0\0", "line 1: cannot read 'OFF BINARY': only text "),
        ("nOFF\n5\n", "line 1: cannot read 'nOFF': only text of points in 3D is read"),
    ],
)
def test_files_that_are_refused(content: str, problem: str) -> None:
    assert refused(read_off, content).startswith(problem)
