"""Random meshes, written by a small writer in every flavour of a format, and files cut off and damaged."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from hypothesis import strategies as st

from hsr.base.errors import SceneError
from hsr.scene.meshes import Faces

Mesh = tuple[list[tuple[float, float, float]], list[list[int]]]

# Of float32, so that every flavour holds them.
coordinates = st.floats(-1e6, 1e6, width=32)


@st.composite
def meshes(draw: st.DrawFn, most: int = 6) -> Mesh:
    """Vertices and faces of 3 to ``most`` corners."""
    vertices = draw(st.lists(st.tuples(coordinates, coordinates, coordinates), min_size=3, max_size=9))
    index = st.integers(0, len(vertices) - 1)
    return vertices, draw(st.lists(st.lists(index, min_size=3, max_size=most), min_size=1, max_size=5))


def same(faces: Faces, mesh: Mesh) -> bool:
    vertices, loops = mesh
    return (
        np.array_equal(faces.vertices, np.reshape(vertices, (-1, 3)))
        and faces.corner.tolist() == [index for loop in loops for index in loop]
        and faces.sides.tolist() == [len(loop) for loop in loops]
    )


def soup(mesh: Mesh) -> Mesh:
    """Every triangle with vertices of its own, as STL has them."""
    vertices, loops = mesh
    corners = [vertices[index] for loop in loops for index in loop]
    return corners, [[3 * k, 3 * k + 1, 3 * k + 2] for k in range(len(loops))]


# ---------------------------------------------------------------- writers

LENGTHS = {"uchar": "B", "char": "b", "ushort": "H", "int": "i", "uint32": "I", "int16": "h"}


def write_ply(
    mesh: Mesh, order: str, counted: str = "uchar", index: str = "int", extra: bool = False
) -> bytes:
    """Write PLY: ``order`` is ``<``, ``>``, or empty for text."""
    vertices, loops = mesh
    form = {"<": "binary_little_endian", ">": "binary_big_endian", "": "ascii"}[order]
    more = "element camera 2\nproperty float fov\nproperty list uchar short view\n" if extra else ""
    header = (
        f"ply\ncomment caf\xe9\nformat {form} 1.0\n{more}element vertex {len(vertices)}\n"
        + ("property uchar red\nproperty list uchar double bones\n" if extra else "")
        + "property double x\nproperty float y\nproperty float32 z\n"
        + f"obj_info none\nelement face {len(loops)}\n"
        + ("property list ushort float texcoord\n" if extra else "")
        + f"property list {counted} {index} vertex_indices\nend_header\n"
    )

    def pack(kinds: str, *values: float) -> bytes:
        if order:
            return struct.pack(order + kinds, *values)
        return " ".join(str(value) for value in values).encode() + b" "

    row_end = b"" if order else b"\n"
    body = []
    for views in ([3, 1, 2, 3], [0]) if extra else ():
        body.append(pack("f", 1.5) + pack("B" + "h" * views[0], *views) + row_end)
    for k, (x, y, z) in enumerate(vertices):
        bones = pack("BB" + "d" * (k % 2), 7, k % 2, *[0.25] * (k % 2)) if extra else b""
        body.append(bones + pack("dff", x, y, z) + row_end)
    for k, loop in enumerate(loops):
        texture = pack("H" + "f" * (k % 3), k % 3, *[0.5] * (k % 3)) if extra else b""
        body.append(texture + pack(LENGTHS[counted] + LENGTHS[index] * len(loop), len(loop), *loop) + row_end)
    return header.encode("latin-1") + b"".join(body)


def write_stl(
    mesh: Mesh, ends: bool = True, line: str = "\n", solids: int = 1, name: str = "gehäuse"
) -> bytes:
    """Write STL as text, its facets shared out among solids."""
    vertices, loops = mesh
    text = []
    for part in np.array_split(np.arange(len(loops)), solids):
        text.append(f"solid {name}")
        for k in part:
            text += ["facet normal -1.#IND 0 1", "  outer loop"]
            text += [f"    vertex {x!r} {y!r} {z!r}" for x, y, z in (vertices[index] for index in loops[k])]
            text += ["  endloop", "endfacet"]
        text.append(f"endsolid {name}")
    return (line.join(text if ends else text[:-1]) + line).encode("latin-1")


def write_binary_stl(mesh: Mesh, header: bytes = b"", after: bytes = b"") -> bytes:
    vertices, loops = mesh
    facets = [
        struct.pack("<12fH", 0, 0, 1, *(x for index in loop for x in vertices[index]), 9) for loop in loops
    ]
    return header.ljust(80, b"\0") + struct.pack("<I", len(loops)) + b"".join(facets) + after


def write_off(mesh: Mesh, first: str = "OFF\n", extra: str = "") -> bytes:
    vertices, loops = mesh
    rows = [f"{x!r} {y!r} {z!r}{extra}" for x, y, z in vertices]
    rows += [" ".join(map(str, [len(loop), *loop])) for loop in loops]
    return f"{first}{len(vertices)} {len(loops)} 0\n{chr(10).join(rows)}\n".encode()


def write_obj(mesh: Mesh) -> bytes:
    vertices, loops = mesh
    rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices]
    rows += ["f " + " ".join(str(index + 1) for index in loop) for loop in loops]
    return "\n".join(rows).encode() + b"\n"


# ---------------------------------------------------------------- files cut off


def cuts(content: bytes, read: Callable[[bytes], Faces]) -> Iterator[tuple[int, Faces]]:
    """Cut a file at every byte; yield where it is read all the same, and what is read."""
    for end in range(len(content)):
        try:
            yield end, read(content[:end])
        except SceneError as error:
            assert len(str(error).splitlines()) == 1


def refused(read: Callable[[bytes], object], content: str | bytes) -> str:
    with pytest.raises(SceneError) as caught:
        read(content.encode() if isinstance(content, str) else content)
    assert len(str(caught.value).splitlines()) == 1
    return str(caught.value)
