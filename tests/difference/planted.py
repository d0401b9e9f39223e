"""A small renderer in the open, and the classic mistakes that can be planted in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr.arrays import Bools, Floats
from hsr.scene.model import Scene
from hsr.viewing import View, view
from hsr.visibility import VisibilityMap


@dataclass(frozen=True)
class Renderer:
    """Triangle by triangle over the whole image; each field but its default is a mistake."""

    centre: float = 0.5
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
        """Draw a view, and call the map that of method ``name``."""
        shape = (seen.height, seen.width)
        face, best, depth = np.full(shape, -1, np.int32), np.full(shape, np.inf), np.full(shape, np.inf)
        for corners, owner, cull, scale in triangles(seen):
            screen = self._screen(seen, corners)
            covered, weights = self._cover(seen, screen, cull)
            here = self._depth(seen, corners[:, 2], weights)
            covered &= (here <= seen.far) & ((here >= seen.near) | (not self.near_clip))
            key = self._key(seen, here, scale) if self.nearest else np.zeros(shape)
            nearer = covered & ((key <= best) if self.later_wins else (key < best))
            face[nearer], best[nearer], depth[nearer] = owner, key[nearer], here[nearer]
        if self.upside_down:
            face, depth = face[::-1].copy(), depth[::-1].copy()
        return VisibilityMap(face, depth, name)

    def _screen(self, seen: View, corners: Floats) -> Floats:
        w = corners[:, 2:] if seen.perspective else 1.0
        screen = (1.0 + corners[:, :2] / w * [1.0, -1.0]) * 0.5 * [seen.width, seen.height]
        return np.trunc(screen * self.grid) / self.grid if self.grid else screen

    def _cover(self, seen: View, screen: Floats, cull: int) -> tuple[Bools, Floats]:
        """Return which samples a triangle covers, and the weights (3, H, W) of its corners there."""
        y, x = np.mgrid[: seen.height, : seen.width] + self.centre
        turn = np.sign(cross(screen[1] - screen[0], screen[2] - screen[0]))
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
        with np.errstate(invalid="ignore", divide="ignore"):
            return covered, edges / edges.sum(axis=0)

    def _depth(self, seen: View, depths: Floats, weights: Floats) -> Floats:
        if seen.perspective and self.divided:
            with np.errstate(divide="ignore"):
                return np.asarray(1.0 / np.tensordot(1.0 / depths, weights, 1))
        return np.tensordot(depths, weights, 1)

    def _key(self, seen: View, depth: Floats, scale: float) -> Floats:
        if self.levels:
            return np.rint((1.0 - seen.near / depth) / (1.0 - seen.near / seen.far) * self.levels)
        return depth / scale if self.unscaled else depth


def cross(a: Floats, b: Floats) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def triangles(seen: View) -> Any:
    """Corners (3, 3) as (x, y, depth), face, cull and scale of every triangle."""
    rows = np.stack([seen.clip_from_world[0], seen.clip_from_world[1], seen.depth_row])
    for placement in seen.placements:
        assert placement.shape.polygons is not None and not placement.mirrored
        polygons, matrix = placement.shape.polygons, placement.world_from_object
        world = polygons.vertices @ matrix[:3, :3].T + matrix[:3, 3]
        clip = world @ rows[:, :3].T + rows[:, 3]
        scale = float(np.cbrt(np.linalg.det(matrix[:3, :3])))
        for corner, face in zip(polygons.triangle_vertex, polygons.triangle_face, strict=True):
            yield clip[corner], placement.first + int(face), placement.cull, scale


MISTAKES = {
    "pixel corner instead of centre": Renderer(centre=0.0),
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


# ---------------------------------------------------------------- scenes


def prism() -> View:
    """A bar with a front and a back left and right, its upright edges through samples at +-2.5.

    The faces are numbered so that of the two that meet at an upright edge the front is first on the
    left, and the back on the right.
    """
    x, z = (-2.5, 0.0, 2.5, 0.0), (0.0, 1.0, 0.0, -1.0)
    vertices = [[x[k], y, z[k]] for y in (-2.0, 2.0) for k in range(4)]
    left_front, left_back, right_back, right_front = (0, 1), (3, 0), (2, 3), (1, 2)
    faces = []
    for a, b in (left_front, left_back, right_back, right_front):
        faces += [[a, b, b + 4], [a, b + 4, a + 4]]
    camera = {"type": "orthographic", "eye": [0.0, 0.0, 10.0], "height": 8.0, "far": 16.0}
    thing = {"name": "bar", "shape": "mesh", "vertices": vertices, "faces": faces}
    return view(Scene.model_validate({"camera": [camera], "object": [thing]}), (8, 8))


def soup(seed: int = 0, size: int = 48) -> View:
    """Triangles strewn before the eye: some cross the near plane, some turn their backs and are culled."""
    random = np.random.default_rng(seed)
    things = []
    for name, cull, scale in (("a", "none", 1.0), ("b", "back", 4.0)):
        centre = random.uniform([-1.0, -1.0, 0.0], [1.0, 1.0, 3.4], (24, 1, 3))
        corners = centre + random.uniform(-0.9, 0.9, (24, 3, 3))
        faces = np.arange(72).reshape(-1, 3).tolist()
        mesh = {"shape": "mesh", "vertices": (corners.reshape(-1, 3) / scale).tolist(), "faces": faces}
        things.append({"name": name, "cull": cull, "transform": [{"scale": scale}], **mesh})
    camera = {"type": "perspective", "eye": [0.1, 0.2, 5.0], "near": 1.3, "far": 10000.0}
    return view(Scene.model_validate({"camera": [camera], "object": things}), (size, size))


def close_pair(gap: float = 0.1) -> View:
    """Two squares at a distance at which 16 bits cannot tell them apart, the nearer one last."""
    squares = [
        {"name": name, "shape": "square", "transform": [{"scale": size}, {"translate": [0.0, 0.0, z]}]}
        for name, size, z in (("back", 40.0, -100.0), ("front", 30.0, -100.0 + gap))
    ]
    camera = {"type": "perspective", "eye": [0.013, 0.007, 1.0], "near": 0.1}
    return view(Scene.model_validate({"camera": [camera | {"far": 1000.0}], "object": squares}), (24, 24))


VIEWS = {"prism": prism, "soup": soup, "close pair": close_pair}
