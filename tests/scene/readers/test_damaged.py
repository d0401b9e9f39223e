"""Damaged files: whatever their bytes are, they are read or refused in one line, and soon."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hsr.base.errors import HsrError
from hsr.scene import triangulation
from hsr.scene.meshes import Faces, mesh_shape
from hsr.scene.readers import READERS
from hsr.scene.readers.gltf import Document
from hsr.scene.readers.off import read_off
from hsr.scene.readers.ply import read_ply
from hsr.scene.readers.source import content_of, reading
from hsr.scene.readers.stl import read_stl
from tests.scene.readers.made import (
    Mesh,
    meshes,
    write_binary_stl,
    write_obj,
    write_off,
    write_ply,
    write_stl,
)
from tests.scene.readers.test_gltf_arrays import Made

CORPUS = Path(__file__).parent / "corpus"
"""What fuzzers found worth keeping, shrunk: each takes another way through a reader."""

QUADS: Mesh = (
    [(0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 4.0, 0.0)],
    [[0, 1, 2, 3], [3, 2, 1], [1, 2, 3, 0, 1]],
)
TRIANGLES: Mesh = (QUADS[0], [[0, 1, 2], [3, 2, 1]])


def made_glb() -> bytes:
    made = Made()
    primitive = made.tree["meshes"][0]["primitives"][0]
    primitive["targets"] = [{"POSITION": 0}]
    primitive["attributes"] |= {"JOINTS_0": made.array([[0, 0, 0, 0]] * 4, "u1")}
    primitive["attributes"] |= {"WEIGHTS_0": made.array([[1, 0, 0, 0]] * 4, "f4")}
    made.tree["skins"] = [{"joints": [0]}]
    made.tree["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 1.0}}]
    sparse = {"count": 1, "indices": {"bufferView": 1, "componentType": 5121}, "values": {"bufferView": 0}}
    made.mesh(5, POSITION=made.array([[0, 0, 0], [9, 0, 0], [0, 9, 0]], "i2", sparse=sparse))
    made.node(scale=[1, 2, 3], rotation=[0, 0, 0, 1], camera=0, children=[])
    made.node(mesh=0, skin=0, weights=[0.5])
    made.node(extensions={"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}})
    return made.glb()


FILES = {
    "a.obj": [write_obj(QUADS)],
    "a.off": [write_off(QUADS), write_off(QUADS, "4OFF ", " 2")],
    "a.ply": [
        write_ply(QUADS, order, "int", extra=extra) for order in ("", "<", ">") for extra in (False, True)
    ],
    "a.stl": [write_stl(TRIANGLES, solids=2), write_binary_stl(TRIANGLES)],
    "a.glb": [made_glb()],
}


def read(path: Path) -> None:
    """Read a mesh in full; only errors of ours may come, one line each."""
    try:
        if path.suffix in READERS:
            with reading(path):
                mesh_shape(READERS[path.suffix](content_of(path)))
        else:
            mesh_shape(Document(path).faces())
    except HsrError as error:
        assert len(str(error).splitlines()) == 1


def test_files_that_are_not_damaged_are_read(tmp_path: Path) -> None:
    for name, files in FILES.items():
        for content in files:
            path = tmp_path / name
            path.write_bytes(content)
            assert (
                len(Document(path).nodes) == 6
                if name == "a.glb"
                else mesh_shape(READERS[path.suffix](content))
            )


WORDS = [*(b"0 9 -1 1e999 nan { ] list".split()), *(b" ", b"\n", b"\r", b"\0", b"\xff\xff\xff\xff", b"\x80")]
edits = st.lists(
    st.tuples(st.floats(0, 1), st.integers(0, 9), st.sampled_from(WORDS) | st.binary(max_size=4)),
    min_size=1,
    max_size=4,
)


@pytest.mark.parametrize("name", FILES)
@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(which=st.integers(0, 5), changes=edits)
def test_damaged_files_are_read_or_refused(
    tmp_path: Path, name: str, which: int, changes: list[tuple[float, int, bytes]]
) -> None:
    content = FILES[name][which % len(FILES[name])]
    for where, length, new in changes:
        start = int(where * len(content))
        content = content[:start] + new + content[start + length :]
    path = tmp_path / name
    path.write_bytes(content)
    read(path)


WRITERS: list[tuple[Callable[[Mesh], bytes], Callable[[bytes], Faces]]] = [
    (lambda mesh: write_ply(mesh, ""), read_ply),
    (lambda mesh: write_ply(mesh, "", extra=True), read_ply),
    (lambda mesh: write_ply(mesh, "<", "ushort", "uint32", True), read_ply),
    (lambda mesh: write_ply(mesh, ">", "char", "int16"), read_ply),
    (lambda mesh: write_stl(mesh, solids=2), read_stl),
    (write_binary_stl, read_stl),
    (write_off, read_off),
]


@settings(max_examples=300)
@given(meshes(most=3), st.sampled_from(WRITERS), st.floats(0, 1))
def test_a_file_cut_off_is_refused_or_tells_no_lies(
    mesh: Mesh, flavour: tuple[Callable[[Mesh], bytes], Callable[[bytes], Faces]], where: float
) -> None:
    write, read = flavour
    content = write(mesh)
    cut, whole = content[: int(where * len(content))], read(content)
    try:
        faces = read(cut)
    except HsrError:
        return
    # Only the digits of the last number may be missing, and text in STL announces no facets.
    count = cut.count(b"endfacet") if read is read_stl else len(whole.sides)
    assert faces.sides.tolist() == whole.sides[:count].tolist()
    assert faces.corner[:-1].tolist() == whole.corner[: int(faces.sides.sum()) - 1].tolist()
    assert np.array_equal(faces.vertices, whole.vertices[: len(faces.vertices)])


MANY = 100_000
LONG = {
    "blank.stl": b"solid x" + b"\n" * MANY + b"x",
    "spaces.stl": b"solid x\n" + b" " * MANY + b"facet normal 0 0 0 outer loop vertex 0 0" + b" " * MANY,
    "solids.stl": b"solid x\nendsolid\n" * MANY,
    "continued.obj": b"v 0 \\\n" * MANY,
    "properties.ply": b"ply\nformat ascii 1.0\nelement vertex 1\n"
    + b"".join(b"property int a%d\n" % k for k in range(MANY))
    + b"end_header\n0\n",
    "elements.ply": b"ply\nformat ascii 1.0\n"
    + b"".join(b"element a%d 9\n" % k for k in range(MANY))
    + b"end_header\n",
    "comments.off": b"OFF\n" + b"#\n" * MANY,
    "nested.gltf": b"[" * MANY,
    "corners.off": b"OFF %d 1\n" % MANY
    + b"".join(b"%d %d 0\n" % (k % 2, k * k % 65537) for k in range(MANY))
    + b"%d " % MANY
    + b" ".join(b"%d" % k for k in range(MANY)),
}


@pytest.mark.parametrize("name", LONG)
def test_no_time_grows_with_the_square_of_a_file(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(triangulation, "MAX_WORK", 200_000)
    (tmp_path / name).write_bytes(LONG[name])
    start = time.process_time()
    read(tmp_path / name)
    assert time.process_time() - start < 20.0


@pytest.mark.parametrize("path", sorted(CORPUS.glob("*.*")), ids=lambda path: path.name)
def test_what_fuzzers_found(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(triangulation, "MAX_WORK", 200_000)
    read(path)
