"""What can be laid over a picture of a view: how its faces face, how many overlap, how large they are."""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array, Ints, Pixels, ranges
from hsr.kernels.clipping import clip_polygons, view_volume
from hsr.kernels.projection import clip_rows, to_clip, to_screen
from hsr.pages.outlines import sides
from hsr.problem.view import CULL, View

MOST = 255
"""Greatest depth complexity that is told apart."""

AT_ONCE = 2**23
"""Scan lines of edges that are crossed at once, at most, which keeps memory within some hundred MB."""

SMALLEST, LARGEST = -6, 20
"""Powers of two, of areas in pixels, between which sizes are told apart."""


class Drawn:
    """The polygons of a view on the screen, clipped, as a depth buffer draws them.

    Curved shapes are tessellated. Coordinates are rounded, so that a sample very close to an edge may be
    counted on the wrong side of it.
    """

    def __init__(self, view: View) -> None:
        flat = view.tessellated()
        clip = to_clip(flat.polygons.vertices, clip_rows(flat.clip_from_world, flat.depth_row))
        volume = view_volume(flat.near, flat.far, flat.perspective)
        clipped, corner, start = clip_polygons(clip, flat.polygons.corner, flat.polygons.start, volume)
        self.size = (flat.width, flat.height)
        screen = to_screen(clipped, flat.perspective, self.size, (flat.near, flat.far))
        place, following, self.polygon = sides(start, np.arange(len(start) - 1))
        self.tail, self.head = screen[corner[place], :2], screen[corner[following], :2]
        self.face, self.cull = flat.polygons.face, flat.polygons.cull
        cross = self.tail[:, 0] * self.head[:, 1] - self.tail[:, 1] * self.head[:, 0]
        self.area = -0.5 * np.bincount(self.polygon, cross, len(self.face))  # y is down

    def complexity(self) -> Pixels:
        """Count at every sample the faces that cover it, those not culled.

        Along a scan line an edge that runs down a front face opens it, one that runs up closes it: the
        count is the running sum.

        Returns
        -------
        (H, W) uint8
            255 for that many or more.
        """
        width, height = self.size
        culled = np.where(self.area > 0.0, self.cull == CULL["front"], self.cull == CULL["back"])
        drawn = np.flatnonzero(~(culled | (self.area == 0.0))[self.polygon])
        steps = np.zeros(height * (width + 1))
        for edges in np.array_split(drawn, 1 + len(drawn) * height // AT_ONCE):
            steps += self._steps(edges)
        count = np.cumsum(steps.reshape(height, width + 1), axis=1)[:, :width]
        complexity: Pixels = np.clip(count, 0, MOST).astype(np.uint8)
        return complexity

    def _steps(self, edges: Array) -> Array:
        """Count on every scan line, (H * (W + 1),), the faces that edges open less those they close.

        Row r is on an edge from y0 down to y1 if ``y0 <= r + 0.5 < y1``, and opened or closed from column
        c on if ``x <= c + 0.5``: samples are owned as by :mod:`hsr.kernels.scanline`.
        """
        width, height = self.size
        (x0, y0), (x1, y1) = self.tail[edges].T, self.head[edges].T
        opens = np.where(y1 > y0, 1.0, -1.0) * np.sign(self.area[self.polygon[edges]])
        lower, upper = np.minimum(y0, y1), np.maximum(y0, y1)
        edge, row = ranges(*(np.ceil(np.clip(y - 0.5, 0, height)).astype(np.int64) for y in (lower, upper)))
        x = x0[edge] + (row + 0.5 - y0[edge]) * (x1 - x0)[edge] / (y1 - y0)[edge]
        column = np.ceil(np.clip(x - 0.5, 0, width)).astype(np.int64)
        return np.bincount(row * (width + 1) + column, opens[edge], height * (width + 1))

    def sizes(self, faces: Ints) -> Pixels:
        """Tell how large faces are on the image.

        Parameters
        ----------
        faces : (n,) int32

        Returns
        -------
        (n,) uint8
            The binary logarithm of the area in pixels, rounded, from 0 for SMALLEST up.
        """
        area = np.bincount(self.face, np.abs(self.area), max(faces.max(initial=-1) + 1, 1))[faces]
        power = np.log2(np.maximum(area, 2.0**SMALLEST))
        sizes: Pixels = np.rint(np.clip(power, SMALLEST, LARGEST) - SMALLEST).astype(np.uint8)
        return sizes
