"""What goes with the next version."""

from __future__ import annotations

from typing import Any

import pytest

from hsr.base.deprecated import sample_by_name


@sample_by_name
def told(view: str, maps: tuple[str, ...] = (), known: str = "", *, x: int, y: int) -> Any:
    return view, maps, known, x, y


def test_a_sample_is_named() -> None:
    assert told("view", ("a",), x=3, y=5) == ("view", ("a",), "", 3, 5)


@pytest.mark.parametrize(
    ("given", "keys"),
    [
        (("view", 5, 3, ("a",)), {}),
        (("view", 5, 3), {"maps": ("a",)}),
        (("view", ("a",)), {"row": 5, "column": 3}),
    ],
)
def test_the_order_of_before_warns_and_is_obeyed(given: Any, keys: Any) -> None:
    with pytest.warns(DeprecationWarning, match="told: name the sample, x= its column, y= its row"):
        assert told(*given, **keys) == ("view", ("a",), "", 3, 5)
