"""One sample at a time."""

from __future__ import annotations

from itertools import pairwise
from math import atan2

import pytest

from hsr.exact.decide import Piece, between, decide, directions, tangents
from hsr.exact.infinitesimals import NOTHING, I, J, Polynomial, Surd, affine, constant


def plane(face: int, zeta: Polynomial, *extent: Polynomial) -> Piece:
    return Piece(face, (face,), Surd(zeta, NOTHING, NOTHING, constant(1)), extent, number=face)


def ball(face: int, x: int, y: int) -> Piece:
    """The near half of a sphere of radius 1 seen along the z axis, with zeta growing to the eye."""
    square = 1 - (I - x) ** 2 - (J - y) ** 2
    return Piece(face, (face,), Surd(NOTHING, constant(1), square, constant(1)), (square,), number=face)


def test_the_nearest_piece_owns_and_the_lowest_of_equals() -> None:
    low, high, same = plane(2, constant(1)), plane(1, constant(3)), plane(0, constant(3))
    assert decide([low, high], 0, 0, 1) == (1, frozenset({1}))
    assert decide([low, high], 0, 0, -1) == (2, frozenset({2}))
    assert decide([low, high, same], 0, 0, 1) == (0, frozenset({0, 1}))
    assert decide([], 0, 0, 1) == (-1, frozenset({-1}))


def test_a_corner_of_three_faces() -> None:
    quarter = plane(0, constant(1), I, J)
    right, rest = plane(1, constant(1), I, -J), plane(2, constant(1), -I)
    assert decide([quarter, right, rest], 0, 0, 1) == (1, frozenset({0, 1, 2}))


def test_planes_that_cross_share_the_line() -> None:
    assert decide([plane(0, I), plane(1, -I)], 0, 5, 1) == (0, frozenset({0, 1}))
    assert decide([plane(0, I), plane(1, -I)], 0, 5, -1) == (1, frozenset({0, 1}))
    assert decide([plane(0, I), plane(1, -I)], 1, 5, 1) == (0, frozenset({0}))


def test_between_two_balls_that_touch_the_background_shows() -> None:
    # Every other direction leads into one of the balls.
    assert decide([ball(0, -1, 0), ball(1, 1, 0)], 0, 0, 1) == (1, frozenset({-1, 0, 1}))


def test_outside_a_ball_nothing_is_tied() -> None:
    assert decide([ball(0, 0, 0)], 2, 0, 1) == (-1, frozenset({-1}))
    assert decide([ball(0, 0, 0)], 0, 0, 1) == (0, frozenset({0}))


def test_directions_part_all_lines_through_a_sample() -> None:
    pieces = [plane(0, constant(1), I, J, affine((1, 1, 0)), affine((1, 0, 7)))]
    angles = sorted(atan2(y, x) for x, y in directions(pieces, 0, 0))
    lines = sorted(atan2(y, x) for x, y in ((0, 1), (0, -1), (1, 0), (-1, 0), (1, -1), (-1, 1)))
    assert len(angles) == len(lines)
    for low, high in pairwise(lines):
        assert sum(low < angle < high for angle in angles) == 1


@pytest.mark.parametrize(
    ("polynomial", "lines"),
    [
        (2 * I + 3 * J, {(3, -2), (-3, 2)}),
        (I * J + J**3, {(0, 1), (0, -1), (1, 0), (-1, 0)}),
        (I * I + J * J, set()),
        (J - I * I, {(1, 0), (-1, 0)}),
    ],
)
def test_tangents(polynomial: Polynomial, lines: set[tuple[int, int]]) -> None:
    assert set(tangents(polynomial)) == lines


def test_tangents_that_are_no_fractions_are_rounded() -> None:
    slopes = {y / x for x, y in tangents(2 * I * I - J * J)}
    assert slopes == {2.0**0.5, -(2.0**0.5)}


def test_between_turns_less_than_half() -> None:
    assert between((1, 0), (0, 1)) == (1, 1)
    assert between((1, 0), (-1, 0)) == (0, 1)
    assert between((-1, 0), (1, 0)) == (0, -1)
