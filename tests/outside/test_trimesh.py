"""trimesh's rays, by Embree: right where float32 suffices."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh

import hsr
from hsr.problem.view import View
from hsr.testing import from_ids
from tests.conftest import SCENES

pytest.importorskip("embreex")


def first_hits(view: View) -> Any:
    """Return the triangle (H, W) that each ray hits first, -1 for none."""
    from trimesh.ray.ray_pyembree import RayMeshIntersector

    triangles = view.tessellated().triangles
    mesh = trimesh.Trimesh(
        triangles.reshape(-1, 3), np.arange(triangles.size // 3).reshape(-1, 3), process=False
    )
    row, column = np.mgrid[: view.height, : view.width].reshape(2, -1)
    ndc = np.stack([np.ones(row.size), (2 * column + 1) / view.width - 1, 1 - (2 * row + 1) / view.height])
    origins, directions = (view.rays.origin @ ndc).T, (view.rays.direction @ ndc).T
    hits = RayMeshIntersector(mesh).intersects_first(origins, directions)
    return hits.reshape(view.height, view.width)


@pytest.mark.jit
@pytest.mark.parametrize("scene", ["cube", "polyhedra", "cyclic", "coplanar", "interpenetrating", "room"])
def test_trimesh_sees_what_is_there(visibility: Any, scene: str) -> None:
    file = SCENES / f"{scene}.toml"
    view = hsr.view(hsr.load(file), (96, 96))
    shown = from_ids(first_hits(view), view, method="embree")
    visibility.agree({"trimesh": shown}, hsr.render(view, "exact"), scene=file)
