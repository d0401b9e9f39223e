"""PLY files, text and binary."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hsr.scene.readers.ply import read_ply
from tests.scene.readers.made import LENGTHS, Mesh, cuts, meshes, refused, same, write_ply

MESH: Mesh = (
    [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)],
    [[0, 1, 2], [1, 2, 3, 0], [3, 2, 1], [0, 1, 2, 3, 0]],
)
ORDERS = ["", "<", ">"]
TEXT = write_ply(MESH, "").decode("latin-1")


def loops(content: str | bytes) -> list[list[int]]:
    faces = read_ply(content.encode("latin-1") if isinstance(content, str) else content)
    corner, found = faces.corner.tolist(), []
    for sides in faces.sides.tolist():
        found.append(corner[:sides])
        corner = corner[sides:]
    return found


# ---------------------------------------------------------------- every flavour


@given(
    meshes(), st.sampled_from(ORDERS), st.sampled_from([*LENGTHS]), st.sampled_from([*LENGTHS]), st.booleans()
)
def test_what_is_written_is_read(mesh: Mesh, order: str, counted: str, index: str, extra: bool) -> None:
    assert same(read_ply(write_ply(mesh, order, counted, index, extra)), mesh)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("extra", [False, True])
def test_a_file_cut_off_anywhere_is_refused(order: str, extra: bool) -> None:
    content = write_ply(MESH, order, extra=extra)
    # Of text, the end of the last line tells nothing; the last number is one digit.
    ends = [end for end, faces in cuts(content, read_ply) if not same(faces, MESH)]
    assert ends == []


@pytest.mark.parametrize("line", ["\r", "\r\n"])
@pytest.mark.parametrize("order", ORDERS)
def test_lines_end_in_any_way(line: str, order: str) -> None:
    content = write_ply(MESH, order)
    end = content.index(b"end_header") + len(b"end_header\n")
    head, body = content[:end], content[end:]
    # The first number after a CR may be a byte of 10.
    first = (struct.pack(f"{order}d", 0.0), b"\n" + struct.pack(f"{order}d", 0.0)[1:])
    body = body if not order else body.replace(*first, 1)
    written = head.replace(b"\n", line.encode()) + (body if order else body.replace(b"\n", line.encode()))
    assert loops(written) == MESH[1]


def test_comments_stand_anywhere_and_bytes_follow() -> None:
    text = TEXT.replace("format", "comment before the format\nformat").replace("1.0 1.0", "1.0 1.0")
    assert loops(text.replace("\n0.0 1.0", "\ncomment in the body \xff\n\n0.0 1.0") + "and more\n") == MESH[1]
    assert loops(write_ply(MESH, "<") + b"trailing") == MESH[1]
    assert loops("\ufeff".encode() + TEXT.encode("latin-1")) == MESH[1]


def test_only_what_bears_on_the_mesh_must_be_numbers() -> None:
    text = TEXT.replace("property float32 z\n", "property float32 z\nproperty float nx\n").replace(
        " 0.0 \n", " 0.0 -1.#IND\n"
    )
    assert loops(text) == MESH[1]


def test_text_has_the_digits_of_its_type() -> None:
    text = TEXT.replace("\n1.0 0.0", "\n0.123456789 0.123456789")
    vertices = read_ply(text.encode("latin-1")).vertices
    assert vertices[1, 0] == 0.123456789 and vertices[1, 1] == np.float32(0.123456789)


@pytest.mark.parametrize("order", ORDERS)
def test_rows_of_nothing_take_no_time(order: str) -> None:
    content = write_ply(MESH, order).replace(b"obj_info none", b"element nothing 999999999999999")
    assert loops(content) == MESH[1]


# ---------------------------------------------------------------- strips

STRIPS = b"ply\nformat %b 1.0\nelement vertex 5\nproperty char x\nproperty char y\nproperty char z\n\
element tristrips 2\nproperty list int %b vertex_indices\nend_header\n"


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize(("kind", "code"), [("int", "i"), ("uint", "I")])
def test_strips(order: str, kind: str, code: str) -> None:
    form = {"<": b"binary_little_endian", ">": b"binary_big_endian"}[order]
    restart = 2**32 - 1 if code == "I" else -1
    body = bytes(15) + struct.pack(f"{order}i9{code}", 9, 0, 1, 2, 3, restart, 4, 3, 2, restart)
    body += struct.pack(f"{order}i5{code}", 5, 0, 1, restart, 1, 2)
    content = STRIPS % (form, kind.encode()) + body
    assert loops(content) == [[0, 1, 2], [3, 2, 1], [4, 3, 2]]
    assert [end for end, _ in cuts(content, read_ply)] == []


def test_strips_as_text() -> None:
    text = STRIPS % (b"ascii", b"int") + b"0 0 0\n" * 5 + b"5 0 1 2 3 4\n0\n"
    assert loops(text) == [[0, 1, 2], [3, 2, 1], [2, 3, 4]]


# ---------------------------------------------------------------- problems


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("nothing", "a PLY file starts with the word ply"),
        ("ply\nformat ascii 1.0\n", "line 3: its header ends without end_header"),
        ("ply\nformat ebcdic 1.0\n", "line 2: cannot read 'format ebcdic 1.0'"),
        ("ply\nelement face -1\n", "line 2: cannot read 'element face -1'"),
        ("ply\nproperty int x\n", "line 2: cannot read 'property int x'"),
        (TEXT.replace("float y", "quad y"), "line 6: cannot read 'property quad y'"),
        (TEXT.replace("float y", "float x"), "line 6: cannot read 'property float x'"),
        (TEXT.replace("float y", "float w"), "its header announces no vertices with x, y and z"),
        (TEXT.replace("list uchar int", "list float int"), "line 10: cannot read "),
        (TEXT.replace("list uchar int", "list uchar float"), "line 10: cannot read "),
        (
            TEXT.replace("vertex_indices", "corners"),
            "its element face has 0 lists vertex_indices or vertex_index",
        ),
        (
            TEXT.replace("face 4", "face 5"),
            "row 4 (counted from 0) of the 5 of element face is not whole",
        ),
        (
            TEXT.replace("\n3 0 1 2", "\n4 0 1 2"),
            "line 16: cannot read '4 0 1 2': its header announces 5 numbers",
        ),
        (
            TEXT.replace("\n3 0 1 2", "\n3 0 1 2 7"),
            "line 16: cannot read '3 0 1 2 7': its header announces 4 ",
        ),
        (TEXT.replace("\n3 0 1 2", "\n3 0 1 two"), "line 16: cannot read '3 0 1 two'"),
        (TEXT.replace("\n3 0 1 2", "\n-3 0 1 2"), "line 16: cannot read '-3 0 1 2': "),
        (TEXT.replace("\n0.0 0.0 0.0", "\n0.0 0_0 0.0"), "line 12: cannot read '0.0 0_0 0.0'"),
        (
            write_ply(MESH, "<")[:-1],
            "byte 307: row 3 (counted from 0) of the 4 of element face is not whole",
        ),
        (
            write_ply(MESH, "<", "int").replace(struct.pack("<i", 5), struct.pack("<i", -5)),
            "byte 317: row 3 (counted from 0) of the 4 of element face is not whole",
        ),
        (write_ply(MESH, "<").replace(b"face 4", b"face 99999999999"), "byte "),
    ],
)
def test_files_that_are_refused(content: str | bytes, problem: str) -> None:
    encoded = content.encode("latin-1") if isinstance(content, str) else content
    assert refused(read_ply, encoded).startswith(problem)


def test_a_list_of_fewer_numbers_than_none_is_refused_however_much_follows() -> None:
    content = write_ply((MESH[0], [[0, 1, 2]]), "<", "char")
    body = content.index(struct.pack("<b3i", 3, 0, 1, 2))
    content = content[:body] + struct.pack("<b3i", -1, 0, 1, 2) + bytes(2000)
    assert "row 0 (counted from 0) of the 1 of element face" in refused(read_ply, content)
