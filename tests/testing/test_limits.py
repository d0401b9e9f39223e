"""Limits: what they mean together, who set them, and which are refused."""

from __future__ import annotations

from typing import Any

import pytest

from hsr.base.errors import CheckError
from hsr.testing.limits import Limits, merged


def test_nothing_set_means_nothing_may_differ() -> None:
    limits = Limits()
    assert limits.max_diff_pixels == 0 and limits.told("max_diff_pixels") == "max_diff_pixels=0 (default)"


@pytest.mark.parametrize("name", ["max_diff_ratio", "max_cluster"])
def test_any_count_that_is_set_takes_the_place_of_the_default(name: str) -> None:
    assert Limits(**{name: 1}).max_diff_pixels is None
    assert Limits(**{name: 0}).max_diff_pixels is None


@pytest.mark.parametrize("name", ["max_in_window", "expect_diff"])
def test_so_does_any_pair(name: str) -> None:
    assert Limits(**{name: (3, 3)}).max_diff_pixels is None


def test_judging_depths_leaves_the_default() -> None:
    assert Limits(depth_ulps=4).max_diff_pixels == 0


def test_the_first_source_wins_limit_by_limit() -> None:
    limits = merged(
        [("marker", {"max_cluster": 2}), ("command line", {"max_cluster": 9, "max_diff_pixels": 5})]
    )
    assert limits.told("max_cluster") == "max_cluster=2 (marker)"
    assert limits.told("max_diff_pixels") == "max_diff_pixels=5 (command line)"


def test_of_unknown_limits_the_first_is_named() -> None:
    with pytest.raises(CheckError, match="marker: there is no limit 'max_pixels'"):
        merged([("marker", {"max_pixels": 2}), ("command line", {"max_samples": 5})])


@pytest.mark.parametrize(
    ("given", "complaint"),
    [
        ({"max_diff_pixels": -1}, "max_diff_pixels=-1 (here): expected a whole number from 0"),
        ({"max_diff_pixels": 0.5}, "max_diff_pixels=0.5 (here): expected a whole number from 0"),
        ({"max_cluster": True}, "max_cluster=True (here): expected a whole number from 0"),
        ({"max_diff_ratio": 1.5}, "max_diff_ratio=1.5 (here): at most 1"),
        ({"depth_ulps": float("nan")}, "depth_ulps=nan (here): expected a number from 0"),
        ({"allow": "fill rule"}, "allow='fill rule' (here): write a set"),
        ({"allow": {"vertex snaping"}}, "no cause 'vertex snaping' (here); did you mean 'vertex snapping'?"),
        ({"max_in_window": (0, 3)}, "max_in_window=(0, 3) (here): expected (side, most), such as (8, 3)"),
        ({"max_in_window": 3}, "max_in_window=3 (here): expected (side, most)"),
        ({"expect_diff": (3, 2)}, "expect_diff=(3, 2) (here): expected (low, high), such as (10, 20)"),
        ({"expect_diff": (1.5, 2)}, "expect_diff=(1.5, 2) (here): expected (low, high)"),
        ({"subpixel_bits": 4}, "subpixel_bits, depth_format, fill_rule belong to a model: name it"),
        ({"max_pixels": 3}, "here: there is no limit 'max_pixels'; there are max_diff_pixels"),
    ],
)
def test_what_makes_no_sense_is_told_in_a_line(given: dict[str, Any], complaint: str) -> None:
    with pytest.raises(CheckError) as error:
        merged([("here", given)])
    assert complaint in str(error.value) and "\n" not in str(error.value)
