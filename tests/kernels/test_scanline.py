"""Scan conversion: who owns a sample, and at what depth."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np
import pytest

from hsr.kernels import depth_buffer, polygon_table, strips
from hsr.kernels.culling import CULL_BACK, CULL_BOTH, CULL_FRONT
from hsr.kernels.depth_buffer import ALWAYS, LESS_EQUAL, Form
from hsr.kernels.polygon_table import CLIPPED, CULLED, DRAWN, EDGE_ON, MISSED

Loop = Sequence[tuple[float, float]]
MODES = [True, False]
"""Directly, or by increments."""

REALS = [np.float64, np.float32]
ULP = 2.0**-52


def draw(
    vertices: Sequence[Sequence[float]],
    loops: Sequence[Sequence[int]],
    size: tuple[int, int],
    directly: bool = False,
    real: type = np.float64,
    cull: int | Sequence[int] = 0,
    held: type | None = None,
    form: Form | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return z, owner and counts of polygons over vertices (x, y) or (x, y, z)."""
    screen = np.zeros((len(vertices), 3), real)
    given = np.array(vertices, float)
    screen[:, : given.shape[1]] = given
    corner = np.array([k for loop in loops for k in loop], np.int32)
    start = np.cumsum([0, *map(len, loops)]).astype(np.int32)
    face = np.arange(len(loops), dtype=np.int32)
    culls = np.full(len(loops), cull, np.int8)
    table = polygon_table.polygon_table(screen, corner, start, face, culls, size)
    z, owner, counts = strips.scan_convert(table, size, directly, True, held, form)
    assert counts is not None
    return z, owner, counts


def picture(owner: np.ndarray) -> list[str]:
    return ["".join(".abcdefgh"[k + 1] for k in row) for row in owner]


def covers(loop: Sequence[Sequence[float]], row: int, column: int) -> bool:
    """Tell by exact half-planes, moved right and down by less than anything, who owns a sample."""
    points = [(Fraction(float(p[0])), Fraction(float(p[1]))) for p in loop]
    area = sum(
        (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        for (ax, ay), (bx, by), (cx, cy) in [(points[0], p, q) for p, q in itertools.pairwise(points[1:])]
    )
    if area == 0:
        return False
    x, y = Fraction(2 * column + 1, 2), Fraction(2 * row + 1, 2)
    sign = 1 if area > 0 else -1
    for (ax, ay), (bx, by) in zip(points, points[1:] + points[:1], strict=True):
        dx, dy = (bx - ax) * sign, (by - ay) * sign
        # The value, then its changes to the right and, far smaller, downward.
        if (dx * (y - ay) - dy * (x - ax), -dy, dx) <= (0, 0, 0):
            return False
    return True


# ---------------------------------------------------------------- who owns a sample


@pytest.mark.parametrize("real", REALS)
@pytest.mark.parametrize("directly", MODES)
@pytest.mark.parametrize("flip", [False, True])
def test_square_with_corners_on_pixel_centres(directly: bool, real: type, flip: bool) -> None:
    """Left and top edges are inside, right and bottom edges are not."""
    loop = [0, 1, 2, 3]
    corners = [(1.5, 1.5), (4.5, 1.5), (4.5, 3.5), (1.5, 3.5)]
    _, owner, _ = draw(corners, [loop[::-1] if flip else loop], (6, 5), directly, real)
    assert picture(owner) == ["......", ".aaa..", ".aaa..", "......", "......"]


@pytest.mark.parametrize("directly", MODES)
@pytest.mark.parametrize(
    ("loops", "expected"),
    [
        ([[0, 1, 2], [0, 2, 3]], ["aaaa", "baaa", "bbaa", "bbba"]),
        ([[0, 1, 3], [1, 2, 3]], ["aaab", "aabb", "abbb", "bbbb"]),
    ],
)
def test_diagonal_through_pixel_centres(directly: bool, loops: list[list[int]], expected: list[str]) -> None:
    """The triangle to whose left the diagonal lies owns its samples."""
    corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)]
    _, owner, counts = draw(corners, loops, (4, 4), directly)
    assert picture(owner) == expected
    assert counts[depth_buffer.FRAGMENTS] == 16


@pytest.mark.parametrize("corners", [(1.5, 2.5), (1.5, 2.0), (1.0, 2.5), (1.25, 2.625)])
@pytest.mark.parametrize("sides", [3, 4, 7, 12])
def test_fan_around_a_point_covers_once(corners: tuple[float, float], sides: int) -> None:
    angle = 2 * np.pi * np.arange(sides) / sides
    rim = np.stack([corners[0] + 9 * np.cos(angle), corners[1] + 9 * np.sin(angle)], axis=1)
    loops = [[0, 1 + k, 1 + (k + 1) % sides] for k in range(sides)]
    _, owner, counts = draw([corners, *map(tuple, rim)], loops, (4, 4))
    assert (owner >= 0).all() and counts[depth_buffer.FRAGMENTS] == 16


@pytest.mark.parametrize("real", REALS)
@pytest.mark.parametrize("directly", MODES)
@pytest.mark.parametrize("offset", [0.5, 0.25, 0.0, 1 / 3])
def test_lattice_of_shared_edges_covers_once(directly: bool, real: type, offset: float) -> None:
    """A mesh of triangles with jittered inner vertices leaves no hole and no double owner."""
    n, step = 8, 3.0
    rng = np.random.default_rng(int(offset * 12))
    grid = np.stack(np.meshgrid(np.arange(n) * step, np.arange(n) * step), axis=-1) + offset - 3.0
    jitter = rng.integers(-4, 5, grid.shape) / (4 if offset != 1 / 3 else 3.7)
    jitter[[0, -1]] = jitter[:, [0, -1]] = 0
    vertices = (grid + jitter).reshape(-1, 2)
    loops = []
    for r in range(n - 1):
        for c in range(n - 1):
            a, b, d, e = r * n + c, r * n + c + 1, (r + 1) * n + c, (r + 1) * n + c + 1
            loops += [[a, b, e], [a, e, d]] if rng.random() < 0.5 else [[a, b, d], [b, e, d]]
    _, owner, counts = draw(vertices.tolist(), loops, (16, 16), directly, real)
    assert (owner >= 0).all() and counts[depth_buffer.FRAGMENTS] == 16 * 16


@pytest.mark.parametrize("directly", MODES)
@pytest.mark.parametrize("sides", [3, 4, 6])
def test_coverage_is_that_of_exact_half_planes(directly: bool, sides: int) -> None:
    """Convex polygons on a grid of 1/4: many samples on edges, slopes that are not exact."""
    rng = np.random.default_rng(sides)
    for _ in range(25):
        angle = np.sort(rng.uniform(0, 2 * np.pi, sides))
        loop = np.stack([4 + 5 * np.cos(angle), 4 + 5 * np.sin(angle)], axis=1)
        if sides == 3:
            loop = np.round(loop * 4) / 4
        _, owner, _ = draw(loop.tolist(), [list(range(sides))], (8, 8), directly)
        exact = [[covers(loop.tolist(), r, c) for c in range(8)] for r in range(8)]
        edges_hit = np.argwhere((owner >= 0) != np.array(exact))
        for r, c in edges_hit:  # only where a sample lies on an edge that is walked with rounding
            assert sides == 3 and on_edge(loop, r, c)


def on_edge(loop: np.ndarray, row: int, column: int) -> bool:
    x, y = Fraction(2 * int(column) + 1, 2), Fraction(2 * int(row) + 1, 2)
    points = [(Fraction(a), Fraction(b)) for a, b in loop.tolist()]
    pairs = zip(points, points[1:] + points[:1], strict=True)
    return any((bx - ax) * (y - ay) == (by - ay) * (x - ax) for (ax, ay), (bx, by) in pairs)


@pytest.mark.parametrize("directly", MODES)
@pytest.mark.parametrize("slant", [0.0, 1e-12, -1e-12, 1e12])
def test_vertical_and_horizontal_edges(directly: bool, slant: float) -> None:
    if abs(slant) < 1:  # near-vertical left side, moved by less than the sample's distance
        corners = [(1.0, 0.0), (3.0, 0.0), (3.0, 3.0), (1.0 + slant, 3.0)]
    else:  # near-horizontal top side
        corners = [(1.0, 0.0), (3.0, 1 / slant), (3.0, 3.0), (1.0, 3.0)]
    _, owner, _ = draw(corners, [[0, 1, 2, 3]], (4, 3), directly)
    assert picture(owner) == [".aa.", ".aa.", ".aa."]


@pytest.mark.parametrize(
    "loop",
    [
        [(1, 1), (1, 1), (1, 1)],
        [(0, 0), (2, 2), (4, 4)],
        [(0, 1), (2, 1), (4, 1)],
        [(0.6, 0.6), (1.4, 0.7), (1.0, 1.4)],
        [(9, 9), (12, 9), (9, 12)],
        [(-9, 0), (-1, 0), (-9, 4)],
        [(math.nan, 0), (4, 0), (0, 4)],
        [(math.inf, 0), (4, 0), (0, 4)],
    ],
    ids=["point", "diagonal", "flat", "between", "below", "left", "nan", "inf"],
)
@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
def test_degenerate_polygons_cover_nothing(loop: Loop) -> None:
    _, owner, counts = draw(loop, [[0, 1, 2]], (4, 4))
    assert (owner < 0).all() and not counts.any()


def test_a_repeated_corner_changes_nothing() -> None:
    corners = [(0.3, 0.2), (6.1, 1.3), (2.2, 6.4)]
    _, plain, _ = draw(corners, [[0, 1, 2]], (7, 7))
    _, owner, _ = draw(corners, [[0, 0, 1, 1, 2]], (7, 7))
    assert np.array_equal(owner, plain) and (owner >= 0).any()


@pytest.mark.parametrize("first", range(5))
def test_the_first_corner_does_not_matter(first: int) -> None:
    corners = [(1.2, 0.1), (6.3, 2.2), (5.9, 5.5), (2.0, 6.6), (0.2, 3.1)]
    _, plain, _ = draw(corners, [[0, 1, 2, 3, 4]], (7, 7))
    _, owner, _ = draw(corners, [[(first + k) % 5 for k in range(5)]], (7, 7))
    assert np.array_equal(owner, plain)


def test_polygon_far_larger_than_the_image() -> None:
    corners = [(-3e4, -2e4), (4e4, -2e4), (0.0, 5e4)]
    _, owner, _ = draw(corners, [[0, 1, 2]], (5, 3))
    assert (owner == 0).all()


def test_one_pixel() -> None:
    _, owner, _ = draw([(0, 0), (1, 0), (0.5, 1)], [[0, 1, 2]], (1, 1))
    assert owner.tolist() == [[0]]


# ---------------------------------------------------------------- depth


def plane(x: float, y: float) -> float:
    """A plane whose values on multiples of 1/4 are exact."""
    return 0.25 + x / 64 + y / 128


@pytest.mark.parametrize("real", REALS)
@pytest.mark.parametrize("directly", MODES)
def test_prestep_to_pixel_centres(directly: bool, real: type) -> None:
    """Sides and top off the centres: without the presteps depth would differ from row to row."""
    corners = [(0.25, 0.75), (7.0, 2.0), (1.75, 6.25)]
    z, owner, _ = draw([(x, y, plane(x, y)) for x, y in corners], [[0, 1, 2]], (8, 8), directly, real)
    rows, columns = np.nonzero(owner >= 0)
    assert len(rows) > 12
    bound = 8 * float(np.finfo(real).eps)
    assert z[rows, columns] == pytest.approx(plane(columns + 0.5, rows + 0.5), abs=bound)


@pytest.mark.parametrize("turned", [False, True])
def test_slopes_are_the_plane_equation(turned: bool) -> None:
    """-A/C and -B/C against fractions, of a triangle and of a polygon in its plane."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        xy = rng.integers(0, 64, (3, 2))
        z = rng.integers(0, 64, 3)
        (ax, ay), (bx, by), (cx, cy) = ((Fraction(int(x)), Fraction(int(y))) for x, y in xy)
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if area == 0:
            continue
        dz1, dz2 = Fraction(int(z[1] - z[0])), Fraction(int(z[2] - z[0]))
        z_x = (dz1 * (cy - ay) - dz2 * (by - ay)) / area
        z_y = (dz2 * (bx - ax) - dz1 * (cx - ax)) / area
        screen = np.column_stack([xy, z]).astype(float)[:: -1 if turned else 1].copy()
        args = (np.arange(3, dtype=np.int32), np.array([0, 3], np.int32), np.zeros(1, np.int32))
        plane = polygon_table.polygon_table(screen, *args, np.zeros(1, np.int8), (64, 64)).plane
        A, B, C = plane[0]
        assert pytest.approx((float(z_x), float(z_y)), rel=4 * ULP) == (-A / C, -B / C)


def test_depth_down_a_side_and_along_a_line() -> None:
    """Differences of neighbours are -A/C, and -(A/m + B)/C between the starts of two lines."""
    corners = [(1.5, 0.5), (9.5, 0.5), (1.5, 8.5)]
    z, _, _ = draw([(x, y, plane(x, y)) for x, y in corners], [[0, 1, 2]], (10, 9))
    assert (np.diff(z[0, 1:9]) == 1 / 64).all()
    assert (np.diff(z[:8, 1]) == 1 / 128).all()  # a vertical side: -B/C


def random_triangles(rng: np.random.Generator, count: int, size: int) -> np.ndarray:
    centre = rng.uniform(0, size, (count, 1, 2))
    xy = centre + rng.uniform(-0.4 * size, 0.4 * size, (count, 3, 2))
    return np.concatenate([xy, rng.uniform(0.1, 0.9, (count, 3, 1))], axis=2)


@pytest.mark.parametrize("directly", MODES)
@pytest.mark.parametrize("seed", range(3))
def test_nearest_wins_against_brute_force(directly: bool, seed: int) -> None:
    """Every sample against every triangle in fractions."""
    size, count = 10, 12
    triangles = random_triangles(np.random.default_rng(seed), count, size)
    loops = np.arange(3 * count).reshape(count, 3).tolist()
    z, owner, _ = draw(triangles.reshape(-1, 3).tolist(), loops, (size, size), directly)
    for row in range(size):
        for column in range(size):
            depths = {
                k: exact_depth(triangle, row, column)
                for k, triangle in enumerate(triangles.tolist())
                if covers(triangle, row, column)
            }
            nearest = min(depths, key=lambda k: depths[k]) if depths else -1
            assert owner[row, column] == nearest
            assert z[row, column] == (
                pytest.approx(float(depths[nearest]), rel=1e-11) if depths else math.inf
            )


def exact_depth(triangle: Sequence[Sequence[float]], row: int, column: int) -> Fraction:
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = ([Fraction(v) for v in point] for point in triangle)
    x, y = Fraction(2 * column + 1, 2), Fraction(2 * row + 1, 2)
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    u = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area
    v = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area
    return az + u * (bz - az) + v * (cz - az)


def test_of_equal_depths_the_lower_face_stays() -> None:
    square = [(0, 0, 0.5), (4, 0, 0.5), (4, 4, 0.5), (0, 4, 0.5)]
    _, owner, counts = draw(square, [[0, 1, 2, 3], [3, 2, 1, 0]], (4, 4))
    assert (owner == 0).all()
    assert counts[[depth_buffer.FRAGMENTS, depth_buffer.PASSED]].tolist() == [32, 16]


def test_a_point_on_the_far_plane_is_seen() -> None:
    square = [(0, 0, 1.0), (4, 0, 1.0), (4, 4, 1.0), (0, 4, 1.0)]
    z, owner, _ = draw(square, [[0, 1, 2, 3]], (5, 4))
    assert (owner[:, :4] == 0).all() and (z[:, :4] == 1.0).all()
    assert (owner[:, 4] == -1).all() and (z[:, 4] == math.inf).all()


def test_painting_takes_the_last() -> None:
    near, far = [(0, 0, 0.1), (2, 0, 0.1), (0, 2, 0.1)], [(0, 0, 0.9), (2, 0, 0.9), (0, 2, 0.9)]
    z, owner, counts = draw(near + far, [[0, 1, 2], [3, 4, 5]], (2, 2), form=Form(ALWAYS))
    assert picture(owner) == ["bb", "b."] or picture(owner) == ["b.", ".."]
    assert (z[owner == 1] == pytest.approx(0.9)) and counts[depth_buffer.PASSED] == 2 * (owner >= 0).sum()


# ---------------------------------------------------------------- what the buffer holds

SQUARE = [0, 1, 2, 3]


def wall(z: float) -> list[tuple[float, float, float]]:
    return [(0, 0, z), (1, 0, z), (1, 1, z), (0, 1, z)]


@pytest.mark.parametrize(
    ("z", "level"),
    [(0.0, 0), (0.49 / 7, 0), (0.51 / 7, 1), (3.49 / 7, 3), (3.51 / 7, 4), (-0.2, 0), (0.9, 6)],
)
def test_levels_are_the_nearest(z: float, level: int) -> None:
    """Of 0, 1/7 .. 7/7, clamped."""
    held, owner, _ = draw(
        wall(z), [SQUARE], (1, 1), held=np.uint16, form=Form(levels=7, scale=7.0, offset=0.5)
    )
    assert held.dtype == np.uint16 and held.tolist() == [[level]] and owner.tolist() == [[0]]


def test_the_greatest_level_is_as_far_as_nothing() -> None:
    form = Form(levels=7, scale=7.0, offset=0.5)
    strict = draw(wall(0.95), [SQUARE], (1, 1), held=np.uint16, form=form)
    closed = draw(wall(0.95), [SQUARE], (1, 1), held=np.uint16, form=form._replace(test=LESS_EQUAL))
    assert [shown[0].item() for shown in (strict, closed)] == [7, 7]
    assert [shown[1].item() for shown in (strict, closed)] == [-1, 0]


@pytest.mark.parametrize(("d", "level"), [(2.0, 0), (3.0, 1), (5.4, 3), (5.6, 4), (8.9, 7), (-1.0, 7)])
def test_linear_levels_divide(d: float, level: int) -> None:
    """Near 2, far 9, seven steps of 1; beyond infinity, where -1/d is positive, is as far as far."""
    form = Form(LESS_EQUAL, 7, 1.0, 0.5 - 2.0, -1.0 / 9.0)
    held, _, _ = draw(wall(-1.0 / d), [SQUARE], (1, 1), held=np.uint16, form=form)
    assert held.tolist() == [[level]]


@pytest.mark.parametrize("directly", MODES)
def test_what_is_held_is_what_is_compared(directly: bool) -> None:
    """Two walls that only float64 can tell apart, the nearer last."""
    walls, loops = wall(0.5) + wall(0.5 - 2.0**-40), [SQUARE, [4, 5, 6, 7]]
    assert draw(walls, loops, (1, 1), directly)[1].item() == 1
    held, owner, _ = draw(walls, loops, (1, 1), directly, held=np.float32)
    assert held.dtype == np.float32 and owner.item() == 0


@pytest.mark.parametrize(("form", "shown", "passed"), [(None, "a", 1), (Form(LESS_EQUAL), "b", 2)])
def test_of_equal_depths_the_test_decides(form: Form | None, shown: str, passed: int) -> None:
    _, owner, counts = draw(wall(0.5), [SQUARE, SQUARE], (1, 1), form=form)
    assert picture(owner) == [shown] and counts[depth_buffer.PASSED] == passed


def test_whole_numbers_are_stepped_as_integers() -> None:
    """A triangle of depths that no grid holds, against Python's integers."""
    corners = [(0.0, 0.0, 100.3), (40.0, 0.0, 993.7), (0.0, 30.0, 401.9)]
    z, owner, _ = draw(corners, [[0, 1, 2]], (40, 30), form=Form(whole=True))
    z_x, z_y = (993.7 - 100.3) / 40, (401.9 - 100.3) / 30
    for row in range(30):
        # The left side is vertical: down it, then half a pixel to the first centre, then along.
        left = round(100.3 + 0.5 * z_y) + row * round(z_y)
        start = round(left + 0.5 * z_x)
        seen = z[row][owner[row] == 0].tolist()
        assert seen == [start + column * round(z_x) for column in range(len(seen))]


# ---------------------------------------------------------------- table, strips, counts


@pytest.mark.parametrize(("cull", "shown"), [(0, "ab"), (CULL_BACK, "a"), (CULL_FRONT, "b"), (CULL_BOTH, "")])
def test_culling(cull: int, shown: str) -> None:
    """With y down, what the eye sees counter-clockwise has a negative area."""
    corners = [(0, 0), (0, 1), (1, 1), (1, 0), (2, 0), (2, 1)]
    front, back = [0, 1, 2, 3], [3, 4, 5, 2]
    _, owner, _ = draw(corners, [front, back], (2, 1), cull=cull)
    assert picture(owner)[0].replace(".", "") == shown


def test_fates_of_polygons() -> None:
    screen = np.array(
        [[0, 0, 0], [0, 3, 0], [3, 3, 0], [3, 0, 0], [6, 6, 0], [0.1, 0.2, 0], [0.2, 0.3, 0]], float
    )
    loops = [[0, 1, 2], [2, 1, 0], [0, 2, 4], [0, 5, 6], []]
    corner = np.array([k for loop in loops for k in loop], np.int32)
    start = np.cumsum([0, *map(len, loops)]).astype(np.int32)
    cull = np.full(5, CULL_BACK, np.int8)
    table = polygon_table.polygon_table(screen, corner, start, np.arange(5, dtype=np.int32), cull, (8, 8)).row
    fates = [DRAWN, CULLED, EDGE_ON, MISSED, CLIPPED]
    assert table[:, polygon_table.FATE].tolist() == fates


def test_strips_list_polygons_in_order() -> None:
    rng = np.random.default_rng(1)
    table = np.zeros((200, 8), np.int32)
    table[:, polygon_table.FIRST_LINE] = rng.integers(0, 150, 200)
    table[:, polygon_table.END_LINE] = table[:, polygon_table.FIRST_LINE] + rng.integers(1, 51, 200)
    table[::7] = 0  # not drawn
    polygon, dealt = strips.deal_to_strips(table, 200)
    assert sorted(dealt[:, 0].tolist()) == list(range(-(-200 // strips.STRIP)))
    for strip, begin, end in dealt.tolist():
        low, high = strip * strips.STRIP, (strip + 1) * strips.STRIP
        crosses = (table[:, 0] < high) & (table[:, 1] > low) & (table[:, 0] < table[:, 1])
        assert polygon[begin:end].tolist() == np.flatnonzero(crosses).tolist()


@pytest.mark.parametrize("real", REALS)
def test_strips_leave_no_trace(real: type) -> None:
    """A side over many strips is one walk, bit for bit: every line is the line above plus 1/m."""
    height = 3 * strips.STRIP + 5
    corners = np.array([(0.3, 0.1, 0.2), (11.7, 0.1, 0.8), (4.9, height - 0.3, 0.4)], real)
    loop = (np.arange(3, dtype=np.int32), np.array([0, 3], np.int32), np.zeros(1, np.int32))
    ((A, B, C),) = polygon_table.polygon_table(corners, *loop, np.zeros(1, np.int8), (12, height)).plane
    z_x, z_y = -A / C, -B / C
    z, owner, _ = draw(corners.tolist(), [[0, 1, 2]], (12, height), False, real)
    (x0, y0, z0), (x2, y2, _) = corners[0], corners[2]
    half, m = real(0.5), (x2 - x0) / (y2 - y0)
    x = x0 + (half - y0) * m
    z_left = z0 + (x - x0) * z_x + (half - y0) * z_y
    for row in range(height):
        first = math.ceil(x - half)
        if (owner[row] >= 0).any():
            assert owner[row].tolist().index(0) == first
            assert z[row, first] == z_left + (real(first) + half - x) * z_x
        x, z_left = x + m, z_left + (m * z_x + z_y)


def test_counts() -> None:
    corners = [(0.0, 0.0), (4.0, 0.0), (0.0, 4.0), (9.0, 0.0), (9.3, 4.0), (9.2, 4.0)]
    _, owner, counts = draw(corners, [[0, 1, 2], [3, 4, 5]], (9, 4))
    # The first triangle: 4 scan lines with 3, 2, 1 and 0 samples; the second lies beside the image.
    assert counts.tolist() == [4, 3, 6, 6] and (owner >= 0).sum() == 6
