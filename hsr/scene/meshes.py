"""Mesh files: what their readers hand over, and the readers.

The faces of a mesh are numbered as its file lists them, whatever groups and materials they belong
to. A face of more than three corners is cut into the fan of triangles about its first corner.
trimesh sorts faces by material and by their number of corners and takes the relative indices of
OBJ for absolute ones, so the text formats OBJ and OFF are read here; of PLY, STL and glTF we take
trimesh's arrays before it builds a mesh of them.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hsr.base.arrays import Array, Floats
from hsr.base.errors import SceneError
from hsr.scene.shapes import Kind, Polygons, Shape

MAX_TRIANGLES = (2**31 - 1) // 3
"""Corners of triangles are numbered by int32."""

MAX_COORDINATE = 2.0**300
"""Beyond this, a product of three coordinates may overflow float64."""


class Faces(NamedTuple):
    """The faces of a mesh file, in its order.

    Attributes
    ----------
    vertices : (V, 3) float64
    corner : (K,) int64
        Vertex index of every corner, face after face, counted from 0.
    sides : (F,) int64
        Number of corners of every face.
    """

    vertices: Floats
    corner: Array
    sides: Array

    @classmethod
    def of(cls, vertices: Any, corner: Any, sides: Any) -> Faces:
        """Build from anything array-like."""
        vertices = np.asarray(vertices, np.float64).reshape(-1, 3)
        return cls(vertices, np.asarray(corner, np.int64).reshape(-1), np.asarray(sides, np.int64))

    @classmethod
    def of_loops(cls, vertices: Any, loops: Sequence[Any]) -> Faces:
        """Build from the corners of each face, of any number."""
        return cls.of(vertices, [index for loop in loops for index in loop], [len(loop) for loop in loops])

    @classmethod
    def of_rows(cls, vertices: Any, rows: Array) -> Faces:
        """Build from an (F, n) array: the vertex indices of faces that all have n corners."""
        return cls.of(vertices, rows, np.full(len(rows), rows.shape[1]))


def joined(parts: Sequence[Faces]) -> Faces:
    """Put the faces of several meshes one after the other."""
    parts = [Faces.of([], [], []), *parts]
    vertices, corner, sides = (np.concatenate(column) for column in zip(*parts, strict=True))
    before = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    return Faces(vertices, corner + np.repeat(before, [len(part.corner) for part in parts]), sides)


def mesh_shape(faces: Faces) -> Shape:
    """Cut the faces of a mesh file into triangles.

    Triangles without area stay: they cover nothing, and face numbers remain those of the file.

    Raises
    ------
    SceneError
        Without a face, or with a face of fewer than three corners, a vertex that does not exist, a
        coordinate that is not finite or too large, or more triangles than int32 can number.
    """
    _check(faces)
    start = np.concatenate([[0], np.cumsum(faces.sides)]).astype(np.int32)
    polygon = np.arange(len(faces.sides), dtype=np.int32)
    polygons = Polygons(faces.vertices, faces.corner.astype(np.int32), start, polygon)
    triangles = Polygons.of_rows(faces.vertices, polygons.triangle_vertex)
    return Shape(Kind.MESH, "mesh", triangles, cut=int((faces.sides > 3).sum()))


def _check(faces: Faces) -> None:
    if not len(faces.sides):
        raise SceneError("the mesh has no faces")
    if faces.sides.min() < 3:
        k = np.argmax(faces.sides < 3)
        raise SceneError(f"face {k} (counted from 0) has fewer than three corners")
    if int((faces.sides - 2).sum()) > MAX_TRIANGLES:
        raise SceneError(f"the mesh has more than {MAX_TRIANGLES} triangles; split it")
    _check_vertices(faces.vertices)
    missing = (faces.corner < 0) | (faces.corner >= len(faces.vertices))
    if missing.any():
        face = int(np.searchsorted(np.cumsum(faces.sides), np.argmax(missing), side="right"))
        raise SceneError(
            f"face {face} (counted from 0) names a vertex that does not exist; "
            f"there are {len(faces.vertices)}"
        )


def _check_vertices(vertices: Floats) -> None:
    wrong = ~(np.abs(vertices) <= MAX_COORDINATE).all(axis=1)
    if wrong.any():
        k = int(np.argmax(wrong))
        x, y, z = vertices[k]
        what = "too large" if np.isfinite(vertices[k]).all() else "not finite"
        raise SceneError(f"vertex {k} (counted from 0) is {what}: {x:g} {y:g} {z:g}")


# ---------------------------------------------------------------- readers


def read_faces(path: Path) -> Faces:
    """Read an OBJ, OFF, PLY or STL file.

    Parameters
    ----------
    path : Path
        The ending of its name, in upper or lower case, says which format it is.

    Raises
    ------
    SceneError
        If the file does not follow its format; the message does not name the file.
    OSError
        If it cannot be read at all.
    """
    content = path.read_bytes()
    with reading(path):
        return READERS[path.suffix.lower()](content)


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Blame the file for whatever its reader stumbles over in the ``with`` block."""
    try:
        with warnings.catch_warnings():
            # NumPy only warns when text stops being numbers, and returns what came before.
            warnings.simplefilter("error")
            yield
    except SceneError:
        raise
    except Exception as error:
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        name = path.suffix.upper().removeprefix(".")
        raise SceneError(f"not a readable {name} file ({reason})") from error


def _text(content: bytes) -> list[str]:
    """Return the lines of a text file; names and comments may be in any encoding."""
    return content.decode("utf-8", errors="replace").replace("\r\n", "\n").replace("\r", "\n").split("\n")


def _read_obj(content: bytes) -> Faces:
    """Read the lines ``v`` and ``f`` of a Wavefront OBJ file; nothing else bears on visibility."""
    vertices: list[list[float]] = []
    corner: list[int] = []
    sides: list[int] = []
    for line in _text(content.replace(b"\\\n", b" ").replace(b"\\\r\n", b" ")):
        key, *words = line.partition("#")[0].split() or [""]
        try:
            if key == "v":
                x, y, z = words[:3]
                vertices.append([float(x), float(y), float(z)])
            elif key == "f":
                corner += [_obj_index(word, len(vertices)) for word in words]
                sides.append(len(words))
        except ValueError:
            raise SceneError(f"cannot read the line {line.strip()[:60]!r}") from None
    return Faces.of(vertices, corner, sides)


def _obj_index(word: str, vertices: int) -> int:
    """Return the vertex index, from 0, of a corner written ``v``, ``v/vt``, ``v//vn`` or ``v/vt/vn``.

    OBJ counts from 1; a negative index counts back from the last vertex read so far.
    """
    index = int(word.partition("/")[0])
    return max(index + vertices, -1) if index < 0 else index - 1


def _read_off(content: bytes) -> Faces:
    """Read an Object File Format file (OFF, also with colours or normals after each vertex)."""
    rows = [row for line in _text(content) if (row := line.partition("#")[0].split())]
    if not rows or not rows[0][0].endswith("OFF"):
        raise SceneError("an OFF file starts with the word OFF")
    counts = rows[0][1:] or rows.pop(1)
    vertex_count, face_count = int(counts[0]), int(counts[1])
    if len(rows) < 1 + vertex_count + face_count:
        raise SceneError(f"it ends before its {vertex_count} vertices and {face_count} faces")
    vertices = [row[:3] for row in rows[1 : 1 + vertex_count]]
    faces = rows[1 + vertex_count : 1 + vertex_count + face_count]
    loops = [row[1 : 1 + int(row[0])] for row in faces]
    if any(len(loop) < int(row[0]) for loop, row in zip(loops, faces, strict=True)):
        raise SceneError("a face lists fewer corners than it announces")
    return Faces.of_loops(vertices, loops)


def _read_ply(content: bytes) -> Faces:
    """Read a PLY file: trimesh's elements, before it sorts the faces by their number of corners."""
    from trimesh.exchange.ply import load_ply

    elements = load_ply(BytesIO(content), fix_texture=False, skip_materials=True)["metadata"]["_ply_raw"]
    vertex, face = elements["vertex"]["data"], elements.get("face", {}).get("data")
    vertices = np.column_stack([vertex[axis] for axis in "xyz"])
    if face is None:
        return Faces.of(vertices, [], [])
    keys = face.dtype.names if isinstance(face, np.ndarray) else face
    loops = face["vertex_index" if "vertex_index" in keys else "vertex_indices"]
    loops = loops["f1"] if loops.dtype.names else loops
    if loops.dtype == object:
        return Faces.of_loops(vertices, loops)
    return Faces.of_rows(vertices, np.atleast_2d(loops))


def _read_stl(content: bytes) -> Faces:
    """Read an STL file, binary or text, of one or several solids."""
    from trimesh.exchange.stl import load_stl

    found = load_stl(BytesIO(content))
    solids = found["geometry"].values() if "geometry" in found else [found]
    return joined([Faces.of_rows(solid["vertices"], solid["faces"]) for solid in solids])


READERS = {".obj": _read_obj, ".off": _read_off, ".ply": _read_ply, ".stl": _read_stl}
