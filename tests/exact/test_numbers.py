"""Floats as integers, and the frame of a view."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hsr.base.errors import ViewError
from hsr.exact.numbers import frame_of, integers, inverse
from hsr.problem.view import view
from tests.exact.hard import loose_view, scene

finite = st.floats(allow_nan=False, allow_infinity=False)


def test_integers_are_in_proportion_and_have_no_common_factor_of_two() -> None:
    assert integers(np.array([0.5, 3.0, 0.0, -1.25])).tolist() == [2, 12, 0, -5]
    assert integers(np.zeros(2)).tolist() == [0, 0]


@given(st.lists(finite, min_size=2, max_size=4))
def test_integers_of_any_floats(values: list[float]) -> None:
    whole = integers(np.array(values))
    for number, float_ in zip(whole, values, strict=True):
        assert int(number) * Fraction(values[0]) == int(whole[0]) * Fraction(float_)


def test_inverse_up_to_a_positive_factor() -> None:
    matrix = np.array([[0, 2, 0, 1], [1, 0, 0, 0], [0, 0, -3, 0], [0, 0, 0, 1]], dtype=object)
    product = inverse(matrix) @ matrix
    factor = product[0, 0]
    assert factor > 0
    assert (product == factor * np.eye(4, dtype=np.int64)).all()
    with pytest.raises(ViewError, match="singular"):
        inverse(np.zeros((4, 4), dtype=object))


def test_samples_are_twice_their_distance_from_the_middle() -> None:
    seen = view(scene([{"shape": "square"}], {"type": "perspective", "eye": [0.0, 0.0, 5.0]}), (3, 2))
    i, j = frame_of(seen).at(np.arange(6))
    assert i.tolist() == [-2, 0, 2] * 2
    assert j.tolist() == [1, 1, 1, -1, -1, -1]


@pytest.mark.parametrize("seed", range(4))
def test_forms_give_depth_and_limits(seed: int) -> None:
    view = loose_view(seed, ("square",))
    frame = frame_of(view)
    point = integers(np.array([*np.random.default_rng(seed).normal(size=3), 1.0]))
    x, y, w, h = (Fraction(int(c)) for c in frame.rows @ point)
    i, j, zeta = x / w, y / w, h / w

    def value(form: np.ndarray) -> Fraction:
        a, b, c, k = (int(number) for number in form)
        return a * i + b * j + c + k * zeta

    depth = sum(Fraction(d) * int(p) for d, p in zip(view.depth_row, point, strict=True)) / int(point[3])
    assert value(frame.depth) / value(frame.unit) == depth
    assert (value(frame.limits[0]) * w >= 0) == (depth >= Fraction(view.near))
    assert frame.nearer == 1
