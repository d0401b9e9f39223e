"""Checks against stored baselines."""

from __future__ import annotations

import pytest
from painter import paint


def test_scene(visibility):
    visibility.check(paint("scene"))


@pytest.mark.parametrize("side", ["left/right", "LEFT/RIGHT", "con", "a" * 200])
def test_sides(visibility, side):
    visibility.check(paint("scene", method=side))


def test_two(visibility):
    visibility.check(paint("scene"), "first")
    visibility.check(paint("scene"), "second")
