"""STL files, text and binary."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hsr.scene.readers.stl import read_stl
from tests.scene.readers.made import Mesh, cuts, meshes, refused, same, soup, write_binary_stl, write_stl

MESH: Mesh = (
    [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)],
    [[0, 1, 2], [0, 1, 3], [2, 1, 3]],
)
SOUP = soup(MESH)
TEXT = write_stl(MESH, name="x").decode()


@given(meshes(most=3), st.integers(1, 3), st.sampled_from(["\n", "\r", "\r\n", " \n\n"]), st.booleans())
def test_text_that_is_written_is_read(mesh: Mesh, solids: int, line: str, ends: bool) -> None:
    content = write_stl(mesh, ends or solids > 1, line, solids)
    assert same(read_stl(content), soup(mesh))
    assert same(read_stl("\ufeff".encode() + content.upper() + b"\0\x1a"), soup(mesh))


@given(meshes(most=3), st.sampled_from([b"", b"solid x", b"solid x\nfacet normal", b"\xef\xbb\xbf\xff\xfe"]))
def test_bytes_that_are_written_are_read(mesh: Mesh, header: bytes) -> None:
    for after in (b"", b"\n", b"trailing words", bytes(500)):
        if not (after and header.endswith(b"normal")):  # that would be text, and no facet
            assert same(read_stl(write_binary_stl(mesh, header, after)), soup(mesh))


def test_the_end_may_be_written_otherwise() -> None:
    for end in ("end solid x\n", "endsolid", "ENDSOLID y", ""):
        assert same(read_stl(TEXT.replace("endsolid x\n", end).encode()), SOUP)
    spaced = TEXT.replace("endloop", "end loop").replace("endfacet", "end facet")
    assert same(read_stl(spaced.replace(" -1.#IND 0 1", "").encode()), SOUP)


def test_text_may_be_utf_16() -> None:
    assert same(read_stl(TEXT.encode("utf-16")), SOUP)


def test_text_cut_off_is_refused_within_a_facet() -> None:
    content = write_stl(MESH, solids=2)
    read = {end: len(faces.sides) for end, faces in cuts(content, read_stl)}
    # Only between facets may a file end: nothing says how many there are.
    whole = [
        end for end in range(len(content)) if content[:end].rstrip().endswith((b"endfacet", b"endsolid"))
    ]
    after_name = [
        end for end in range(len(content)) if b"\n" not in content[:end].rpartition(b"endsolid")[2][:-1]
    ]
    assert set(read) <= {*whole, *after_name}
    assert all(count == content[:end].count(b"endfacet") for end, count in read.items())
    assert len(read) < 40


def test_bytes_cut_off_are_refused() -> None:
    for header in (b"", b"solid x"):
        assert [end for end, _ in cuts(write_binary_stl(MESH, header), read_stl)] == []


QUAD = TEXT.replace("  endloop", "    vertex 9 9 9\n  endloop", 1)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("nothing", "it is neither text that starts as an STL file does, nor as long as a binary header"),
        (
            QUAD,
            "line 2: cannot read 'facet normal -1.#IND 0 1': expected a facet of three vertices, or endsolid",
        ),
        (TEXT.replace("0.0 1.0\n", "0.0\n"), "line 9: cannot read "),
        (
            TEXT.replace("0.0 1.0\n", "0.0 1,0\n"),
            "line 9: cannot read 'facet normal -1.#IND 0 1': expected numbers",
        ),
        (
            TEXT.replace("endsolid x", "endsolid x\nendsolid x"),
            "line 24: cannot read 'endsolid x': expected solid",
        ),
        (TEXT + "solid y\n", "it ends where a facet of three vertices, or endsolid is expected"),
        (TEXT.replace("\n", "\r\n").replace("outer", "inner", 1), "line 2: cannot read"),
        (
            write_binary_stl(MESH)[:-1],
            "byte 233: facet 2 (counted from 0) of 3 is not whole",
        ),
        (write_binary_stl(MESH, after=b"x" * 50), "byte 84: its header announces 3 facets, and there are 4"),
    ],
)
def test_files_that_are_refused(content: str | bytes, problem: str) -> None:
    assert refused(read_stl, content).startswith(problem)
