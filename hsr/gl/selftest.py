"""The picture every context must draw before it is used.

A context that opens proves nothing: Mesa's softpipe opens one, reports no error and draws nothing.
The picture has two triangles that cut through each other, so each must once overwrite the other
and once be kept from it. No sample lies on an edge, nor where the two meet.
"""

from __future__ import annotations

import numpy as np

from hsr.gl.context import Context
from hsr.gl.depth import D24
from hsr.gl.drawing import Drawing
from hsr.problem.map import BACKGROUND
from hsr.problem.view import CULL, Placement, View
from hsr.scene.shapes import Kind, Polygons, Shape

PICTURE = """
. . . . . . . .
0 . . . . . . 1
0 0 . . . . 1 1
0 0 0 . . 1 1 1
0 0 0 0 1 1 1 1
0 0 0 0 1 1 1 1
0 0 0 0 1 1 1 1
0 0 0 0 1 1 1 1
"""

FACE = np.array([BACKGROUND if k == "." else int(k) for k in PICTURE.split()]).reshape(8, 8)

X = (2 * np.arange(8) + 1) / 8 - 1
"""Where the samples of a row lie, from -1 to 1."""

DEPTH = np.where(FACE == BACKGROUND, np.inf, -np.abs(X) / 2)
"""Both triangles fall away from the middle column to the sides: z = x / 2 and z = -x / 2."""

# Storing rounds by half a step. The driver computes z from float32 numbers of at most 1, each
# operation rounding by at most half a step: eight steps leave room for fourteen operations, and
# are a hundred-thousandth of the picture's own depths. Depths here run over 2, not 1.
TOLERANCE = 2 * 8 * D24.step


def picture() -> View:
    """Return the view of the two triangles: world space is clip space, and depth is z."""
    left = [[-1, -1, -0.5], [0.875, -1, 0.4375], [-1, 0.875, -0.5]]
    right = [[1, -1, -0.5], [1, 0.875, -0.5], [-0.875, -1, 0.4375]]
    corners = np.array([*left, *right], dtype=np.float64)
    shape = Shape(Kind.MESH, "mesh", Polygons.of(corners, [(0, 1, 2), (3, 4, 5)]))
    placement = Placement("picture", shape, np.eye(4), 0, CULL["none"], False, (0.0, 0.0, 0.0))
    return View(np.eye(4), np.array([0.0, 0.0, 1.0, 0.0]), -1.0, 1.0, 8, 8, (placement,))


def flaw(context: Context) -> str | None:
    """Draw the picture; say what is wrong with it, or return None."""
    with Drawing(context, picture()) as drawing:
        drawing.draw()
        face, depth = drawing.read()
    wrong = int(np.count_nonzero(face != FACE))
    if wrong:
        return f"draws {wrong} of {FACE.size} samples of the test picture wrong"
    if not np.allclose(depth, DEPTH, rtol=0.0, atol=TOLERANCE):
        return "stores wrong depths of the test picture"
    return None
