"""Errors, and what was perhaps meant."""

from __future__ import annotations

import pytest

from hsr.base.errors import MethodError, named, nearest

KNOWN = {"zbuffer": 1, "raycast": 2}


def test_what_is_near_is_suggested() -> None:
    assert nearest("zbufer", KNOWN) == "did you mean 'zbuffer'? " and nearest("painter", KNOWN) == ""


def test_what_is_named_is_found_or_told() -> None:
    assert named("raycast", KNOWN, "no method is named") == 2
    with pytest.raises(MethodError, match=r"^no method is named 'zbufer'; did you mean 'zbuffer'\?$"):
        named("zbufer", KNOWN, "no method is named", MethodError)
    with pytest.raises(MethodError, match=r"^no method is named 'x'; there are zbuffer, raycast$"):
        named("x", KNOWN, "no method is named", MethodError)
