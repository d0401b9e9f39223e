"""Classic mistakes of renderers, planted on purpose: a test that lets one pass tests too little."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from hsr.base.arrays import Bools, Floats
from hsr.base.errors import MethodError
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View


@dataclass(frozen=True)
class Renderer:
    """Triangle by triangle over the whole image; each field but its default is a mistake.

    Attributes
    ----------
    centre : tuple of 2 float
        Where in a pixel its sample lies: (down, right) from its upper left corner, from 0 to 1.
    inclusive : bool
        Whether every edge owns its samples, and not the top and left ones alone.
    later_wins : bool
        Whether of equal depths the last drawn is seen.
    upside_down : bool
        Whether row 0 is the bottom row.
    near_clip : bool
        Whether what lies in front of near is left out.
    divided : bool
        Whether depth is interpolated as its inverse, as perspective demands.
    grid : float
        Steps a pixel to which corners are truncated; 0 leaves them.
    swapped : bool
        Whether front and back are taken for each other.
    unscaled : bool
        Whether depths of different objects are compared in their own units.
    levels : int
        Steps of the depth buffer; 0 keeps float64.
    nearest : bool
        Whether the nearest face is seen, and not the first drawn.
    short_box : bool
        Whether the last row and column of a triangle's bounding box are left out.
    """

    centre: tuple[float, float] = (0.5, 0.5)
    inclusive: bool = False
    later_wins: bool = False
    upside_down: bool = False
    near_clip: bool = True
    divided: bool = True
    grid: float = 0.0
    swapped: bool = False
    unscaled: bool = False
    levels: int = 0
    nearest: bool = True
    short_box: bool = False

    def render(self, seen: View, name: str) -> VisibilityMap:
        """Draw a view without curved shapes, and call the map that of method ``name``.

        Triangles are not clipped at the eye; those that reach behind it come out wrong.
        """
        shape = (seen.height, seen.width)
        face, best, depth = np.full(shape, -1, np.int32), np.full(shape, np.inf), np.full(shape, np.inf)
        with np.errstate(divide="ignore", invalid="ignore"):
            for corners, owner, cull, scale in _triangles(seen):
                box, covered, here = self._cover(seen, corners, cull)
                key = self._key(seen, here, scale) if self.nearest else np.zeros(here.shape)
                nearer = covered & ((key <= best[box]) if self.later_wins else (key < best[box]))
                face[box][nearer], best[box][nearer], depth[box][nearer] = owner, key[nearer], here[nearer]
        if self.upside_down:
            face, depth = face[::-1].copy(), depth[::-1].copy()
        return VisibilityMap(face, depth, name)

    def _cover(self, seen: View, corners: Floats, cull: int) -> tuple[Box, Bools, Floats]:
        """Return the box of a triangle, the samples in it that it covers, and its depths there."""
        screen = self._screen(seen, corners)
        box = _box(seen, screen, corners[:, 3])
        y, x = np.mgrid[box] + np.reshape(self.centre, (2, 1, 1))
        turn = np.sign(_cross(screen[1] - screen[0], screen[2] - screen[0]))
        covered = np.full(x.shape, turn != 0 and cull != (1 if (turn > 0) != self.swapped else 2))
        edges = np.zeros((3, *x.shape))
        for k in range(3):
            p, side = screen[k - 2], screen[k - 1] - screen[k - 2]
            edges[k] = turn * (side[0] * (y - p[1]) - side[1] * (x - p[0]))
            # Rows run down: a side that runs up is a left one, a level one to the right a top one.
            owns = turn * side[1] < 0 or (side[1] == 0 and turn * side[0] > 0) or self.inclusive
            covered &= (edges[k] >= 0) if owns else (edges[k] > 0)
        if self.short_box:
            covered &= (x < np.floor(screen[:, 0].max())) & (y < np.floor(screen[:, 1].max()))
        depth = self._depth(seen, corners[:, 2], edges / edges.sum(axis=0))
        return box, covered & (depth <= seen.far) & ((depth >= seen.near) | (not self.near_clip)), depth

    def _screen(self, seen: View, corners: Floats) -> Floats:
        screen = (1.0 + corners[:, :2] / corners[:, 3:] * [1.0, -1.0]) * 0.5 * [seen.width, seen.height]
        return np.trunc(screen * self.grid) / self.grid if self.grid else screen

    def _depth(self, seen: View, depths: Floats, weights: Floats) -> Floats:
        if seen.perspective and self.divided:
            return np.asarray(1.0 / np.tensordot(1.0 / depths, weights, 1))
        return np.tensordot(depths, weights, 1)

    def _key(self, seen: View, depth: Floats, scale: float) -> Floats:
        if self.levels and seen.perspective:
            return np.rint((1.0 - seen.near / depth) / (1.0 - seen.near / seen.far) * self.levels)
        if self.levels:
            return np.rint((depth - seen.near) / (seen.far - seen.near) * self.levels)
        return depth / scale if self.unscaled else depth


Box = tuple[slice, slice]
"""Rows and columns of an image."""


def _box(seen: View, screen: Floats, w: Floats) -> Box:
    """Return rows and columns that hold all samples of a triangle; all if it reaches behind the eye."""
    if (w <= 0.0).any():
        return slice(0, seen.height), slice(0, seen.width)
    size = [seen.width, seen.height]
    # A sample lies at most one pixel after its column and row begin.
    low = np.clip(np.floor(screen.min(axis=0)) - 1, 0, size).astype(int)
    high = np.clip(np.ceil(screen.max(axis=0)), 0, size).astype(int)
    return slice(low[1], high[1]), slice(low[0], high[0])


def _cross(a: Floats, b: Floats) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def _triangles(seen: View) -> Iterator[tuple[Floats, int, int, float]]:
    """Yield corners (3, 4) as (x, y, depth, w), face, cull and scale of every triangle."""
    rows = np.stack(
        [seen.clip_from_world[0], seen.clip_from_world[1], seen.depth_row, seen.clip_from_world[3]]
    )
    for placement in seen.placements:
        polygons, matrix = placement.shape.polygons, placement.world_from_object
        if polygons is None:
            raise MethodError(f"object {placement.name!r} is curved; draw view.tessellated()")
        world = polygons.vertices @ matrix[:3, :3].T + matrix[:3, 3]
        clip = world @ rows[:, :3].T + rows[:, 3]
        scale = abs(float(np.cbrt(np.linalg.det(matrix[:3, :3]))))
        for corner, face in zip(polygons.triangle_vertex, polygons.triangle_face, strict=True):
            # Counter-clockwise where the front is seen, of mirrored objects, too.
            corners = clip[corner[::-1]] if placement.mirrored else clip[corner]
            yield corners, placement.first + int(face), placement.cull, scale


MISTAKES = {
    "pixel corner instead of centre": Renderer(centre=(0.0, 0.0)),
    "lower pixel corner instead of centre": Renderer(centre=(1.0, 0.0)),
    "inclusive edges": Renderer(inclusive=True),
    "<= for <": Renderer(later_wins=True),
    "flipped y": Renderer(upside_down=True),
    "no near clip": Renderer(near_clip=False),
    "z not divided": Renderer(divided=False),
    "truncating snap": Renderer(grid=16.0),
    "swapped winding": Renderer(swapped=True),
    "unnormalised t": Renderer(unscaled=True),
    "16-bit depth": Renderer(levels=2**16 - 1),
    "first instead of nearest hit": Renderer(nearest=False),
    "truncated bounding box": Renderer(short_box=True),
}
"""A renderer for each mistake, by what people call it."""


# ---------------------------------------------------------------- planting them


@lru_cache(maxsize=len(MISTAKES) + 1)
def _drawn(renderer: Renderer, seen: View) -> VisibilityMap:
    return renderer.render(seen.tessellated(), "")


def planted(mistake: str, shown: VisibilityMap, seen: View) -> VisibilityMap:
    """Return a map as it would be if its renderer made a mistake.

    Parameters
    ----------
    mistake : str
        A key of ``MISTAKES``.
    shown : VisibilityMap
        Of the view ``seen``.
    seen : View

    Returns
    -------
    VisibilityMap
        Changed where a small renderer shows another face with the mistake than without it.
    """
    right, wrong = _drawn(Renderer(), seen), _drawn(MISTAKES[mistake], seen)
    changed = right.face != wrong.face
    face, depth = np.where(changed, wrong.face, shown.face), np.where(changed, wrong.depth, shown.depth)
    return replace(shown, face=face, depth=depth)
