"""Checks against the truth, which need no baseline."""

from __future__ import annotations

from pathlib import Path

import pytest

import hsr

ROOM = Path(__file__).with_name("room.toml")
SIZE = (24, 16)


@pytest.fixture(scope="module")
def truth():
    return hsr.render(hsr.load(ROOM), "exact", SIZE)


def test_right(visibility, truth):
    visibility.agree({"mine": hsr.render(hsr.load(ROOM), "raycast", SIZE)}, truth, scene=ROOM)


@pytest.mark.visibility(max_diff_ratio=0.9)
def test_lax(visibility, truth):
    visibility.equal(hsr.render(hsr.load(ROOM), "raycast", SIZE), truth, scene=ROOM)


def test_wrong(visibility, truth):
    painted = hsr.render(hsr.load(ROOM), "backface", SIZE)
    visibility.agree({"painted": painted}, truth, scene=ROOM)


@pytest.mark.visibility(allow={"no depth test"})
def test_wrong_for_a_known_cause(visibility, truth):
    painted = hsr.render(hsr.load(ROOM), "backface", SIZE)
    visibility.agree({"painted": painted}, truth, scene=ROOM)
