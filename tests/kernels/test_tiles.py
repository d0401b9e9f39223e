"""Half-space rasterisation: the fill rule, the depth test, the keys."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hsr.kernels import strips, tiles

NO_CULL = np.zeros(64, np.int8)


def owners(
    corners: list[list[float]], triangles: list[list[int]], size: tuple[int, int] = (4, 4), cull: int = 0
) -> list[list[int]]:
    screen = np.array(corners, float)
    screen = np.column_stack([screen, np.full(len(screen), 0.5)]) if screen.shape[1] == 2 else screen
    triangle = np.array(triangles, np.int32).reshape(-1, 3)
    face = np.arange(len(triangle), dtype=np.int32)
    owner, z, _ = tiles.rasterise(screen, triangle, face, np.full(len(face), cull, np.int8), size)
    assert np.array_equal(owner < 0, np.isinf(z))
    return owner.tolist()


# The corners of a square whose sides pass through pixel centres.
SQUARE = [[0.5, 0.5], [2.5, 0.5], [2.5, 2.5], [0.5, 2.5]]


@pytest.mark.parametrize(
    ("triangles", "expected"),
    [
        ([[0, 1, 2], [0, 2, 3]], [[0, 0, -1, -1], [1, 0, -1, -1], [-1, -1, -1, -1], [-1] * 4]),
        ([[0, 1, 3], [1, 2, 3]], [[0, 0, -1, -1], [0, 1, -1, -1], [-1, -1, -1, -1], [-1] * 4]),
    ],
)
@pytest.mark.parametrize("turned", [False, True])
def test_top_left_rule(triangles: list[list[int]], expected: list[list[int]], turned: bool) -> None:
    wound = [list(reversed(corners)) for corners in triangles] if turned else triangles
    assert owners(SQUARE, wound) == expected


def test_a_fan_about_a_pixel_centre_has_one_owner_a_sample() -> None:
    angle = 2 * np.pi * np.arange(16) / 16
    ring = np.column_stack([8.5 + 7 * np.cos(angle), 8.5 + 7 * np.sin(angle)]).tolist()
    triangles = [[0, 1 + k, 1 + (k + 1) % 16] for k in range(16)]
    alone = [np.array(owners([[8.5, 8.5], *ring], [one], (17, 17))) >= 0 for one in triangles]
    count = np.sum(alone, axis=0)
    assert count.max() == 1
    inside = np.hypot(*np.mgrid[-8:9, -8:9]) < 6.8
    assert (count[inside] == 1).all()


def test_a_lattice_of_shared_edges_covers_every_sample_once() -> None:
    n = 9
    corners = [[x + 0.5, y + 0.5] for y in range(-1, n) for x in range(-1, n)]
    count = np.zeros((n - 1, n - 1), int)
    for y in range(n):
        for x in range(n):
            a, b, c, d = (
                y * (n + 1) + x,
                y * (n + 1) + x + 1,
                (y + 1) * (n + 1) + x + 1,
                (y + 1) * (n + 1) + x,
            )
            halves = [[a, b, c], [a, c, d]] if (x + y) % 2 else [[a, b, d], [b, c, d]]
            for half in halves:
                count += np.array(owners(corners, [half], (n - 1, n - 1))) >= 0
    assert (count == 1).all()


def test_a_diagonal_within_rounding_of_pixel_centres_leaves_no_crack() -> None:
    left, right = 3.17157287525381, 12.82842712474619
    corners = [[right, right - 4.0], [left, right - 4.0], [left, left - 4.0], [right, left - 4.0]]
    assert (np.array(owners(corners, [[0, 1, 2], [0, 2, 3]], (16, 8)))[:, 3:13] >= 0).all()


@given(seed=st.integers(0, 2**32 - 1))
def test_two_halves_share_out_the_samples_of_any_quadrilateral(seed: int) -> None:
    random = np.random.default_rng(seed)
    a, c = random.integers(0, 9, (2, 2)) + 0.5 + random.choice([0.0, 1e-16, 1e-15, 1 / 3], (2, 2))
    across = random.uniform(1.0, 9.0, (2, 1)) * [[a[1] - c[1], c[0] - a[0]]] * [[1.0], [-1.0]]
    corners = [a.tolist(), (a + across[0]).tolist(), c.tolist(), (c + across[1]).tolist()]
    one, two = (np.array(owners(corners, [half], (9, 9))) >= 0 for half in ([0, 1, 2], [0, 2, 3]))
    assert not (one & two).any()
    y, x = np.mgrid[:9, :9] + 0.5
    along = ((x - a[0]) * (c[0] - a[0]) + (y - a[1]) * (c[1] - a[1])) / max(((c - a) ** 2).sum(), 1e-9)
    beside = np.abs((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0]))
    assert (one | two)[(along > 0.05) & (along < 0.95) & (beside < 1e-9)].all()


def test_nearer_wins_in_either_order() -> None:
    near, far = ([[-9, -9, z], [30, -9, z], [-9, 30, z]] for z in (0.25, 0.75))
    assert owners(near + far, [[0, 1, 2], [3, 4, 5]]) == [[0] * 4] * 4
    assert owners(far + near, [[0, 1, 2], [3, 4, 5]]) == [[1] * 4] * 4


def test_of_equal_depths_the_lower_face_stays() -> None:
    same = [[-9, -9, 0.3], [30, -9, 0.6], [-9, 30, 0.9]]
    assert owners(same + same, [[3, 4, 5], [0, 1, 2]]) == [[0] * 4] * 4


def test_depth_is_that_of_the_plane() -> None:
    screen = np.array([[0, 0, 0.0], [8, 0, 1.0], [0, 8, 0.0]])
    one = np.zeros(1, np.int32)
    owner, z, step = tiles.rasterise(screen, np.array([[0, 1, 2]], np.int32), one, NO_CULL[:1], (8, 8))
    assert step == 2.0**-52
    rows, columns = np.nonzero(owner == 0)
    assert len(rows) == 28  # the diagonal is a right edge
    assert z[rows, columns] == pytest.approx((columns + 0.5) / 8, abs=2 * step)


def test_faces_take_bits_from_the_depth() -> None:
    screen = np.array([[-9, -9, 0.7], [30, -9, 0.7], [-9, 30, 0.7]])
    face = np.array([2**20 - 1], np.int32)
    owner, z, step = tiles.rasterise(screen, np.array([[0, 1, 2]], np.int32), face, NO_CULL[:1], (4, 4))
    assert (owner == 2**20 - 1).all() and step == 2.0**-43
    assert z == pytest.approx(np.full((4, 4), 0.7), abs=step)


@pytest.mark.parametrize("z", [0.0, 1.0])
def test_near_and_far_plane_are_drawn(z: float) -> None:
    assert owners([[-9, -9, z], [30, -9, z], [-9, 30, z]], [[0, 1, 2]]) == [[0] * 4] * 4


@pytest.mark.parametrize(("cull", "drawn"), [(0, True), (1, False), (2, True)])
def test_clockwise_is_a_back_face(cull: int, drawn: bool) -> None:
    clockwise = [[-9, -9], [30, -9], [-9, 30]]  # y down
    assert (owners(clockwise, [[0, 1, 2]], cull=cull)[0][0] == 0) == drawn
    assert (owners(clockwise, [[0, 2, 1]], cull=cull)[0][0] == 0) == (cull != 2)


@pytest.mark.parametrize(
    "corners",
    [
        [[0, 0], [4, 4], [2, 2]],
        [[1, 1], [1, 1], [3, 3]],
        [[0.6, 0.6], [0.9, 0.6], [0.6, 0.9]],
        [[9, 9], [12, 9], [9, 12]],
        [[np.nan, 0], [4, 0], [0, 4]],
    ],
    ids=["collinear", "repeated corner", "between samples", "off the image", "not a number"],
)
def test_what_covers_no_sample_is_dropped(corners: list[list[float]]) -> None:
    assert owners(corners, [[0, 1, 2]]) == [[-1] * 4] * 4


def test_no_triangles() -> None:
    assert owners([[0, 0], [1, 0], [0, 1]], []) == [[-1] * 4] * 4


def test_strips_and_lanes_leave_no_trace() -> None:
    size = (2 * tiles.LANES + 3, 2 * strips.STRIP + 5)
    found = np.array(owners([[1, 2, 0.1], [34, 60, 0.9], [3, 130, 0.4]], [[0, 1, 2]], size)) == 0
    x, y = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    edges = [
        (33 * (y - 2) - 58 * (x - 1)),
        (-31 * (y - 60) - 70 * (x - 34)),
        (-2 * (y - 130) + 128 * (x - 3)),
    ]
    assert np.array_equal(found, np.min(edges, axis=0) > 0)
