"""Meshes made from a formula: the teapot, a torus knot, a terrain, the Menger sponge, a fir tree.

Every shape is made in object space, +y up, with its faces counter-clockwise as seen from outside
(from above, for the terrain). The same parameters give the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.scene.model import Fir, Menger, Teapot, Terrain, Thing, TorusKnot
from hsr.scene.shapes import Polygons

Generated = Teapot | TorusKnot | Terrain | Menger | Fir


def generate(thing: Generated) -> Polygons:
    """Make the mesh that an object of a scene describes.

    Parameters
    ----------
    thing : Teapot, TorusKnot, Terrain, Menger or Fir

    Returns
    -------
    Polygons
        Triangles, or the squares of the sponge; each is a face of its own.
    """
    parameters = {key: value for key, value in thing if key not in ("shape", *Thing.model_fields)}
    return GENERATORS[thing.shape](**parameters)


# ---------------------------------------------------------------- lattices


def _wrapped(index: Ints) -> Ints:
    """Repeat the first column of a lattice of vertex indices after its last: close every row."""
    return np.pad(index, ((0, 0), (0, 1)), mode="wrap")


def _halves(index: Ints) -> Ints:
    """Cut the cells of lattices (..., rows, columns) of vertex indices into two triangles each.

    Seen with the columns running to the right and the rows up, the triangles (n, 3) are
    counter-clockwise.
    """
    a, b = index[..., :-1, :-1], index[..., :-1, 1:]
    d, c = index[..., 1:, :-1], index[..., 1:, 1:]
    return np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)


# ---------------------------------------------------------------- teapot

# Curves of cubic Bezier pieces, each of which begins with the last point of the one before.
# Those that are turned about the y axis: radius, length of the tangent handles, height.
BODY = (
    # rim
    (1.4, 0.784, 2.4),
    (1.3375, 0.749, 2.53125),
    (1.4375, 0.805, 2.53125),
    # upper half
    (1.5, 0.84, 2.4),
    (1.75, 0.98, 1.875),
    (2.0, 1.12, 1.35),
    # lower half
    (2.0, 1.12, 0.9),
    (2.0, 1.12, 0.45),
    (1.5, 0.84, 0.225),
    # bottom
    (1.5, 0.84, 0.15),
    (1.5, 0.84, 0.075),
    (1.425, 0.798, 0.0),
    (0.0, 0.0, 0.0),
)
LID = (
    # knob
    (0.0, 0.0, 3.15),
    (0.8, 0.45, 3.15),
    (0.0, 0.0, 2.85),
    # brim
    (0.2, 0.112, 2.7),
    (0.4, 0.224, 2.55),
    (1.3, 0.728, 2.55),
    (1.3, 0.728, 2.4),
)
# Pairs of curves in the plane z = 0 that bound a bent tube: x and y of one, x and y of the other,
# and half the width of the tube.
HANDLE = (
    (-1.6, 2.025, -1.5, 2.25, 0.3),
    (-2.3, 2.025, -2.5, 2.25, 0.3),
    (-2.7, 2.025, -3.0, 2.25, 0.3),
    (-2.7, 1.8, -3.0, 1.8, 0.3),
    (-2.7, 1.575, -3.0, 1.35, 0.3),
    (-2.5, 1.125, -2.65, 0.9375, 0.3),
    (-2.0, 0.9, -1.9, 0.6, 0.3),
)
SPOUT = (
    (1.7, 1.425, 1.7, 0.6, 0.66),
    (2.6, 1.425, 3.1, 0.825, 0.66),
    (2.3, 2.1, 2.4, 2.025, 0.25),
    (2.7, 2.4, 3.3, 2.4, 0.25),
    (2.8, 2.475, 3.525, 2.49375, 0.25),
    (2.9, 2.475, 3.45, 2.5125, 0.15),
    (2.8, 2.4, 3.2, 2.4, 0.15),
)


def teapot(detail: int) -> Polygons:
    """Cut the 32 patches of the Utah teapot into ``detail`` x ``detail`` quads, each of two triangles.

    The control points are those of M. Newell (1975), as listed by F. Crow, "The Origins of the
    Teapot", IEEE Computer Graphics and Applications 7(1), 1987: 306 points, of which 12 repeat others
    and 4 belong to no patch. The 290 that remain follow from four curves by turning and mirroring.

    Parameters
    ----------
    detail : int
        At least 2: in one step the handle would be flat.

    Returns
    -------
    Polygons
        ``64 detail**2 - 8 detail`` triangles; those that would have no area, at the middle of lid
        and bottom, are left out. The pot stands on y = 0 about the y axis, 3.15 high, the spout
        toward +x. Its surface is open: at the end of the spout and between rim and lid one can
        look inside.
    """
    t = np.linspace(0.0, 1.0, detail + 1)
    columns = _on_cubics(teapot_patches().transpose(1, 2, 0, 3), t)
    points = _on_cubics(columns.swapaxes(0, 1), t).transpose(2, 1, 0, 3)
    # Neighbours agree on their common edge to the last bit. A zero is added, for -0.0 is not 0.0.
    vertices, index = np.unique(points.reshape(-1, 3) + 0.0, axis=0, return_inverse=True)
    triangles = _halves(index.astype(np.int32).reshape(points.shape[:3]))
    a, b, c = triangles.T
    return Polygons.of_triangles(vertices, triangles[(a != b) & (b != c) & (c != a)])


def teapot_patches() -> Floats:
    """Return the control points of the teapot's bicubic patches.

    Returns
    -------
    (32, 4, 4, 3) float64
        Patch, row, column; the patches of the body, of the lid, of the handle, of the spout. Rows
        upward and columns to the right are counter-clockwise as seen from outside.
    """
    turned = [_turned(np.array(curve)) for curve in (BODY, LID)]
    bent = [_bent(np.array(curves)) for curves in (HANDLE, SPOUT)]
    return np.concatenate([*turned, *bent])


def _on_cubics(control: Floats, t: Floats) -> Floats:
    """Find the points (n, ...) at the parameters t (n,) of the cubics with control points (4, ...).

    De Casteljau's algorithm: the segments between neighbouring points are divided in the ratio
    t : 1 - t until one point is left.
    """
    t = t.reshape(-1, *[1] * (control.ndim - 1))
    points: Floats = control[:, None]
    while len(points) > 1:
        points = _between(points[:-1], points[1:], t)
    first: Floats = points[0]
    return first


def _between(a: Floats, b: Floats, t: Floats) -> Floats:
    """Divide segments, counting from the nearer end: exact at both ends, and where they coincide."""
    return np.where(t < 0.5, a + t * (b - a), b - (1.0 - t) * (b - a))


def _pieces(curve: Floats) -> Array:
    """Split a curve (3 n + 1, k) into its cubic pieces (n, 4, k)."""
    return np.stack([curve[k : k + 4] for k in range(0, len(curve) - 1, 3)])


def _turned(curve: Floats) -> Floats:
    """Turn a curve about the y axis: four patches, a quarter of a turn each, for every piece."""
    radius, tangent, height = np.moveaxis(_pieces(curve), 2, 0)
    none = np.zeros_like(radius)
    ahead = np.stack([radius, radius, tangent, none], axis=2)
    aside = ahead[:, :, ::-1]
    up = np.broadcast_to(height[:, :, None], ahead.shape)
    quarters = [(ahead, aside), (-aside, ahead), (-ahead, -aside), (aside, -ahead)]
    return np.concatenate([np.stack([x, up, z], axis=3) for x, z in quarters])


def _bent(curves: Floats) -> Floats:
    """Span a tube between two curves: two patches, mirror images in z = 0, for every piece."""
    x0, y0, x1, y1, width = np.moveaxis(_pieces(curves), 2, 0)
    x = np.stack([x0, x0, x1, x1], axis=2)
    y = np.stack([y0, y0, y1, y1], axis=2)
    z = np.stack([0.0 * width, width, width, 0.0 * width], axis=2)
    front = np.stack([x, y, z], axis=3)
    back = np.stack([x, y, -z], axis=3)[:, :, ::-1]
    return np.concatenate([front, back])


# ---------------------------------------------------------------- torus knot


def torus_knot(p: int, q: int, segments: int, sides: int, thickness: float) -> Polygons:
    """Lay a tube along the (p, q) torus knot.

    The knot winds p times about the axis and q times about the core of the torus of radii 2 and 1
    (C. Adams, *The Knot Book*, 1994, section 5.1)::

        c(t) = ((2 + cos q t) cos p t, (2 + cos q t) sin p t, sin q t),    0 <= t < 2 pi

    A cross section is spanned by the normal N of the torus, to which the tangent T of the knot is
    perpendicular everywhere, and by the binormal T x N; this frame comes back to itself.

    Parameters
    ----------
    p, q : int
        Without common factor.
    segments, sides : int
        Cross sections along the knot, corners of each.
    thickness : float
        Radius of the tube.

    Returns
    -------
    Polygons
        ``2 segments sides`` triangles, closed. The axis of the torus is the z axis.
    """
    t = 2.0 * np.pi * np.arange(segments) / segments
    cp, sp, cq, sq = np.cos(p * t), np.sin(p * t), np.cos(q * t), np.sin(q * t)
    centre = np.stack([(2.0 + cq) * cp, (2.0 + cq) * sp, sq], axis=1)
    normal = np.stack([cq * cp, cq * sp, sq], axis=1)
    turn = np.stack([-(2.0 + cq) * sp, (2.0 + cq) * cp, 0.0 * t], axis=1)
    wind = np.stack([-sq * cp, -sq * sp, cq], axis=1)
    tangent = p * turn + q * wind
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    binormal = np.cross(tangent, normal)

    angle = 2.0 * np.pi * np.arange(sides)[:, None] / sides
    ring = np.cos(angle) * normal[:, None] + np.sin(angle) * binormal[:, None]
    vertices = (centre[:, None] + thickness * ring).reshape(-1, 3)
    index = np.arange(segments * sides, dtype=np.int32).reshape(segments, sides)
    return Polygons.of_triangles(vertices, _halves(np.pad(index, (0, 1), mode="wrap")))


# ---------------------------------------------------------------- terrain


def terrain(detail: int, roughness: float, height: float, seed: int) -> Polygons:
    """Raise a square of ground by midpoint displacement.

    A. Fournier, D. Fussell, L. Carpenter, "Computer rendering of stochastic models",
    Communications of the ACM 25(6), 1982. Each step halves the cells: the middle of an edge gets
    the mean of its two ends, the middle of a cell the mean of its four corners, and both a random
    displacement. The displacements are uniform in ``[-height, height]`` in the first step and
    smaller by the factor ``roughness`` in every further one; the four corners of the square are
    at height 0.

    Parameters
    ----------
    detail : int
        Number of steps.
    roughness : float
        ``2**-H``, H being the dimension parameter of the paper.
    height : float
    seed : int

    Returns
    -------
    Polygons
        ``2 * 4**detail`` triangles over |x|, |z| <= 1, wound counter-clockwise seen from above.
    """
    random = np.random.default_rng(seed)
    y = np.zeros((2, 2))
    for step in range(detail):
        y = _displaced(y, height * roughness**step, random)
    side = len(y)
    ground = np.linspace(-1.0, 1.0, side)
    x, z = np.meshgrid(ground, ground[::-1])
    index = np.arange(side * side, dtype=np.int32).reshape(side, side)
    return Polygons.of_triangles(np.stack([x, y, z], axis=-1).reshape(-1, 3), _halves(index))


def _displaced(y: Floats, reach: float, random: np.random.Generator) -> Floats:
    """Refine heights (n, n) to (2 n - 1, 2 n - 1), the new ones displaced by at most ``reach``."""
    side = 2 * len(y) - 1
    finer = random.uniform(-reach, reach, (side, side))
    along, across = (y[:, 1:] + y[:, :-1]) / 2.0, (y[1:] + y[:-1]) / 2.0
    finer[::2, ::2] = y
    finer[::2, 1::2] += along
    finer[1::2, ::2] += across
    finer[1::2, 1::2] += (along[1:] + along[:-1]) / 2.0
    return finer


# ---------------------------------------------------------------- Menger sponge


def menger(level: int) -> Polygons:
    """Drill the cube |x|, |y|, |z| <= 1 into the Menger sponge.

    K. Menger, "Allgemeine Räume und Cartesische Räume", 1926. The cube is divided into
    3 x 3 x 3; the middle of each side and of the cube go; and so on in what remains.

    Parameters
    ----------
    level : int
        How often; 0 is the plain cube.

    Returns
    -------
    Polygons
        The squares, all of one size, that separate the sponge from what was drilled away: a closed
        surface without inner walls.
    """
    solid = np.pad(_sponge(level), 1)
    loops = np.concatenate([_walls(solid, axis, side) for axis in range(3) for side in (0, 1)])
    lattice = (3**level + 1,) * 3
    used, corner = np.unique(np.ravel_multi_index(loops.reshape(-1, 3).T, lattice), return_inverse=True)
    points = np.stack(np.unravel_index(used, lattice), axis=1).astype(np.float64)
    count = len(loops)
    return Polygons(
        2.0 * points / 3**level - 1.0,
        corner.astype(np.int32),
        np.arange(0, 4 * count + 1, 4, dtype=np.int32),
        np.arange(count, dtype=np.int32),
    )


def _sponge(level: int) -> Bools:
    """Tell which of 3**level cells a side remain.

    A cell is gone if, in base 3, at least two of its three coordinates have a 1 at the same place.
    """
    side = 3**level
    solid = np.ones((side, side, side), dtype=np.bool_)
    for place in range(level):
        middle = np.arange(side) // 3**place % 3 == 1
        x, y, z = middle[:, None, None], middle[None, :, None], middle[None, None, :]
        solid &= ~(x & y | y & z | z & x)
    return solid


def _walls(solid: Bools, axis: int, side: int) -> Array:
    """Corners (n, 4, 3), in cells, of the squares between a solid cell and an empty one.

    The solid cell lies below (side 1) or above (side 0) the square along the axis. ``solid`` has a
    border of empty cells, which the corners do not count.
    """
    beyond = np.roll(solid, -1 if side else 1, axis)
    cell = np.argwhere(solid & ~beyond) - 1
    u, v, n = np.roll(np.eye(3, dtype=np.int64), -(axis + 1), axis=0)
    loop = np.stack([0 * u, u, u + v, v]) if side else np.stack([0 * u, v, u + v, u])
    corners: Array = cell[:, None] + side * n + loop
    return corners


# ---------------------------------------------------------------- fir

# Lengths for a tree of height 1.
TRUNK_SIDES = 8
TRUNK_RADIUS = 0.03
LOWEST_BOUGH = 0.12
WIDEST_BOUGH = 0.3


def fir(tiers: int, sides: int) -> Polygons:
    """Grow a fir of height 1 on the origin: a trunk, and above it overlapping jagged cones.

    A cone is as high as two steps from one cone to the next, and as wide as a straight line from
    the lowest bough to the top of the tree allows.

    Parameters
    ----------
    tiers : int
        Number of cones.
    sides : int
        Number of tips around the rim of a cone.

    Returns
    -------
    Polygons
        ``8 tiers sides + 28`` triangles; the trunk and every cone are closed by themselves.
    """
    step = (1.0 - LOWEST_BOUGH) / (tiers + 1)
    rims = [(LOWEST_BOUGH + k * step, WIDEST_BOUGH * (1.0 - k / (tiers + 1))) for k in range(tiers)]
    parts = [_trunk(LOWEST_BOUGH + step), *(_cone(rim, reach, step, sides) for rim, reach in rims)]
    first = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    triangles = [own + offset for (_, own), offset in zip(parts, first[:-1], strict=True)]
    vertices = np.concatenate([vertices for vertices, _ in parts])
    return Polygons.of_triangles(vertices, np.concatenate(triangles))


def _trunk(top: float) -> tuple[Floats, Ints]:
    """Vertices and triangles of a prism on the ground, its base and cap fans about a corner."""
    index = np.arange(2 * TRUNK_SIDES, dtype=np.int32).reshape(2, TRUNK_SIDES)
    vertices = np.concatenate([_ring(TRUNK_SIDES, TRUNK_RADIUS, y) for y in (0.0, top)])
    base, cap = index[0, ::-1], index[1]
    fans = [np.stack([0 * ring[2:] + ring[0], ring[1:-1], ring[2:]], axis=1) for ring in (base, cap)]
    return vertices, np.concatenate([_halves(_wrapped(index)), *fans])


def _cone(rim: float, reach: float, step: float, sides: int) -> tuple[Floats, Ints]:
    """Vertices and triangles of a cone whose rim at height ``rim`` alternates tips and notches."""
    tip = np.arange(2 * sides) % 2 == 0
    jagged = _ring(2 * sides, np.where(tip, reach, 0.7 * reach), np.where(tip, rim, rim + 0.2 * step))
    waist = _ring(2 * sides, 0.4 * reach, rim + 0.8 * step)
    poles = np.array([[0.0, rim + 2.0 * step, 0.0], [0.0, rim + 0.3 * step, 0.0]])
    index = np.arange(4 * sides, dtype=np.int32).reshape(2, 2 * sides)
    top, below = 4 * sides, 4 * sides + 1
    triangles = [_halves(_wrapped(index)), _fan(top, index[1]), _fan(below, index[0, ::-1])]
    return np.concatenate([jagged, waist, poles]), np.concatenate(triangles)


def _ring(count: int, radius: float | Floats, height: float | Floats) -> Floats:
    """Points (count, 3) about the y axis, counter-clockwise seen from above."""
    angle = 2.0 * np.pi * np.arange(count) / count
    return np.stack([radius * np.sin(angle), height + 0.0 * angle, radius * np.cos(angle)], axis=1)


def _fan(pole: int, ring: Ints) -> Ints:
    """Join every side of a closed ring (n,) with one vertex: triangles (n, 3)."""
    return np.stack([ring, np.roll(ring, -1), 0 * ring + pole], axis=1)


GENERATORS: dict[str, Callable[..., Polygons]] = {
    "teapot": teapot,
    "torus-knot": torus_knot,
    "terrain": terrain,
    "menger": menger,
    "fir": fir,
}
"""By the word of the scene file; what the scene file says beside, each takes by the same name."""
