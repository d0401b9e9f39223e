"""Files of the kinds that people have reported, of this program or of others, and what they hold."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

import hsr
from hsr.base.errors import SceneError
from hsr.scene.files import load, shape_of

SQUARE = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
ROWS = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
FACES = [[0, 1, 2], [0, 1, 3]]


def header(
    order: str, faces: int, *, vertices: int = 4, before: str = "", more: str = "", counted: str = "uchar"
) -> str:
    axes = "".join(f"property float {axis}\n" for axis in "xyz")
    return (
        f"ply\n{before}format {order} 1.0\nelement vertex {vertices}\n{axes}{more}"
        f"element face {faces}\nproperty list {counted} int vertex_indices\nend_header\n"
    )


def packed(*vertices: tuple[float, float, float]) -> bytes:
    return b"".join(struct.pack("<3f", *vertex) for vertex in vertices)


GRID = [(x, y, 0) for y in range(3) for x in range(4)]
LISTS = struct.pack("<5i4i6i", 4, 0, 1, 5, 4, 3, 1, 2, 6, 5, 2, 3, 7, 11, 6)
LITTLE = "binary_little_endian"
BAD = "-1.#IND -1.#IND -1.#IND"


def facet(*corners: str, normal: str = "0 0 0") -> str:
    inner = "".join(f"   vertex {corner}\n" for corner in corners)
    return f" facet normal {normal}\n  outer loop\n{inner}  endloop\n endfacet\n"


ONE, TWO = facet("0 0 0", "1 0 0", "0 1 0"), facet("0 0 0", "1 0 0", "0 0 1")
SOUP = [[0, 1, 2], [3, 4, 5]]
QUADS = "".join(facet(f"0 0 {z}", f"1 0 {z}", f"1 1 {z}", f"0 1 {z}") for z in range(3))
BINARY = struct.pack("<80xI12fH12fH", 2, *[0] * 6, 1, 0, 0, 0, 1, 0, 0, *[0] * 6, 1, 0, 0, 0, 0, 1, 0)
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 5 5 5\nf 2 3 4\n"

READ: dict[str, tuple[str | bytes, list[list[int]], list[float]]] = {
    "int lists of 4, 3, 5 corners.ply": (
        header(LITTLE, 3, vertices=12, counted="int").encode() + packed(*GRID) + LISTS,
        [[0, 1, 5], [0, 5, 4], [1, 2, 6], [2, 3, 7], [2, 7, 11], [2, 11, 6]],
        [3, 2, 0],
    ),
    "triangles and quads.ply": (
        header(LITTLE, 2).encode() + packed(*SQUARE) + struct.pack("<B3iB4i", 3, 0, 1, 2, 4, 0, 1, 2, 3),
        [[0, 1, 2], [0, 1, 2], [0, 2, 3]],
        [1, 1, 1],
    ),
    "comment before format.ply": (
        header("ascii", 2, before="comment x\n") + ROWS + "3 0 1 2\n3 0 1 3\n",
        FACES,
        [1, 1, 1],
    ),
    "normals that are no numbers.ply": (
        header("ascii", 2, more="property float nx\nproperty float ny\nproperty float nz\n")
        + ROWS.replace("\n", f" {BAD}\n")
        + "3 0 1 2\n3 0 1 3\n",
        FACES,
        [1, 1, 1],
    ),
    "strips.ply": (
        header(LITTLE, 1, counted="int").replace("face", "tristrips").encode()
        + packed(*SQUARE)
        + struct.pack("<8i", 7, 0, 1, 2, -1, 0, 1, 3),
        FACES,
        [1, 1, 1],
    ),
    "no end of the last solid.stl": (f"solid a\n{ONE}endsolid a\nsolid b\n{TWO}", SOUP, [1, 1, 1]),
    "no end.stl": (f"solid x\n{ONE}{TWO}", SOUP, [1, 1, 1]),
    "end solid.stl": (f"solid x\n{ONE}{TWO}end solid x\n", SOUP, [1, 1, 1]),
    "ends of lines.stl": (f"solid x\n{ONE}{TWO}endsolid x\n".replace("\n", "\r"), SOUP, [1, 1, 1]),
    "latin-1.stl": (f"solid Geh\xe4use\n{ONE}{TWO}endsolid Geh\xe4use\n".encode("latin-1"), SOUP, [1, 1, 1]),
    "normals.stl": (
        f"solid x\n{ONE}{TWO}endsolid\n".replace("0 0 0\n  outer", f"{BAD}\n  outer"),
        SOUP,
        [1, 1, 1],
    ),
    "more bytes.stl": (BINARY + bytes(37), SOUP, [1, 1, 1]),
    "mark.obj": (b"\xef\xbb\xbfv 9 9 9\n" + OBJ.replace("2 3 4", "2 3 4").encode(), [[1, 2, 3]], [1, 1, 0]),
    "comment.obj": ("v 9 9 9\n# exported to C:\\models\\\n" + OBJ, [[1, 2, 3]], [1, 1, 0]),
    "unused.obj": ("v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan nan nan\nf 1 2 3\n", [[0, 1, 2]], [1, 1, 0]),
    "homogeneous.off": (
        "4OFF\n4 2 0\n" + ROWS.replace("\n", " 2.0\n") + "3 0 1 2\n3 0 1 3\n",
        FACES,
        [0.5, 0.5, 0.5],
    ),
    "glued.off": (f"OFF4 2 0\n{ROWS}3 0 1 2\n3 0 1 3\n", FACES, [1, 1, 1]),
}


@pytest.mark.parametrize("name", READ)
def test_files_that_are_read(tmp_path: Path, name: str, capfd: pytest.CaptureFixture[str]) -> None:
    content, triangles, high = READ[name]
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    polygons = shape_of(load(path).object[0], tmp_path).polygons
    assert polygons is not None and polygons.triangle_vertex.tolist() == triangles
    assert polygons.used.min(axis=0).tolist() == [0, 0, 0] and polygons.used.max(axis=0).tolist() == high
    assert capfd.readouterr() == ("", "")


REFUSED = {
    "a line short.ply": (
        header("ascii", 3) + ROWS + "3 0 1 2\n3 0 1 3\n",
        "row 2 (counted from 0) of the 3 of ",
    ),
    "quads.stl": (
        f"solid q\n{QUADS}endsolid q\n",
        "line 2: cannot read 'facet normal 0 0 0': expected a facet of three",
    ),
    "cut off.stl": (
        f"solid a\n{ONE}endsolid a\nsolid b\n{TWO[:-7]}",
        "line 11: cannot read 'facet normal 0 0 0'",
    ),
    "binary.off": ("OFF BINARY\n\0\0\0\4", "line 1: cannot read 'OFF BINARY': only text"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_files_that_are_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(REFUSED[name][0])
    with pytest.raises(SceneError) as caught:
        load(tmp_path / name)
    (line,) = str(caught.value).splitlines()
    assert line.startswith(str(tmp_path / name)) and REFUSED[name][1] in line


def test_a_concave_polygon_covers_its_area(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 4 4 0\nv 0 1 0\nv -4 4 0\nf 2 3 4 1\n")
    camera = hsr.Orthographic(eye=(0.003, 2.001, 5), target=(0.003, 2.001, 0), height=10, far=9)
    scene = load(tmp_path / "a.obj").model_copy(update={"camera": (camera,)})
    face = hsr.render(hsr.view(scene, (200, 200)), "exact").face
    assert np.sum(face >= 0) * (10 / 200) ** 2 == pytest.approx(4.0, abs=0.1)
