"""Every sample against every triangle, in float64 and nothing but numpy: slow and obvious."""

from __future__ import annotations

from typing import Any

import numpy as np

from hsr.problem.view import View

STEP = 1.0 / 16.0
"""How far, in pixels, a sample is moved to see whether its owner is beyond doubt."""


def brute_force(view: View, right: float = 0.0, down: float = 0.0) -> tuple[Any, Any]:
    """Return face (H, W) and depth (H, W), the samples moved by parts of a pixel.

    The sample's line of sight meets a triangle where (x, y, 1) w is a combination of its corners'
    (x, y, w) with weights that are all positive.
    """
    view = view.tessellated()
    polygons = view.polygons
    column, row = np.meshgrid(np.arange(view.width) + right, np.arange(view.height) + down)
    x, y = (2 * column + 1) / view.width - 1, 1 - (2 * row + 1) / view.height
    sample = np.stack([x, y, np.ones_like(x)], axis=-1)
    face, depth = np.full(x.shape, -1), np.full(x.shape, np.inf)
    for triangle, polygon in zip(polygons.triangle_vertex, polygons.triangle_polygon, strict=True):
        corners = np.column_stack([polygons.vertices[triangle], np.ones(3)])
        homogeneous = corners @ view.clip_from_world[[0, 1, 3]].T
        facing = np.linalg.det(homogeneous)
        culled = (facing < 0) if polygons.cull[polygon] == 1 else (facing > 0)
        if facing == 0 or (polygons.cull[polygon] and culled):
            continue
        weight = sample @ np.linalg.inv(homogeneous)
        hit = (weight > 0).all(axis=-1)
        z = np.divide(
            weight @ (corners @ view.depth_row), weight.sum(axis=-1), where=hit, out=np.full_like(x, np.inf)
        )
        nearer = hit & (view.near <= z) & (z <= view.far) & (z < depth)
        face[nearer], depth[nearer] = polygons.face[polygon], z[nearer]
    return face, depth


def assert_agrees(face: Any, depth: Any, view: View, relative: float) -> None:
    """Assert that a map shows the owner at every sample where moving the sample changes nothing."""
    right, right_depth = brute_force(view)
    moved = [brute_force(view, i * STEP, j * STEP)[0] for i in (-1, 1) for j in (-1, 1)]
    certain = np.all([right == other for other in moved], axis=0)
    assert certain.mean() > 0.8
    np.testing.assert_array_equal(face[certain], right[certain])
    np.testing.assert_allclose(depth[certain], right_depth[certain], rtol=relative)
