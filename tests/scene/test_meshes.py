"""Mesh files: the order of their faces, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hsr.base.errors import SceneError
from hsr.scene import meshes
from hsr.scene.meshes import Faces, joined, mesh_shape
from hsr.scene.readers import read_faces
from hsr.scene.shapes import Shape

SQUARE_OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def read(folder: Path, name: str, content: str | bytes) -> Shape:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return mesh_shape(read_faces(path))


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
        ("a.obj", "v 0 inf 0\nf 1 1 1\n", "vertex 0 (counted from 0) is not finite: 0 inf 0"),
        ("a.obj", "v 0 1e300 0\nf 1 1 1\n", "vertex 0 (counted from 0) is too large: 0 1e+300 0"),
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
