from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from hsr.pages.packing import digits, pack, pack_alike, pack_json
from tests.pages.unpacking import unpack, unpack_alike, unpack_json


@given(
    arrays(np.uint16, array_shapes(min_dims=2, max_dims=2, min_side=0)), st.sampled_from([(), (0,), (1, 0)])
)
def test_numbers_survive_and_differences_wrap(array: Any, axes: tuple[int, ...]) -> None:
    packed = pack(array, *axes)
    assert packed["axes"] == list(axes)
    assert np.array_equal(unpack(packed), array)


@pytest.mark.parametrize("kind", [np.uint8, np.uint32, np.float32])
def test_types_survive(kind: Any) -> None:
    array = np.array([3, 0, 255], dtype=kind)
    assert unpack(pack(array)).dtype == kind and unpack(pack(array)).tolist() == [3, 0, 255]


def test_what_grows_evenly_is_short() -> None:
    even = np.arange(0, 70000, 7, dtype=np.uint32)
    assert len(pack(even, 0)["data"]) < 200 < len(pack(even)["data"])


def test_json_survives() -> None:
    assert unpack_json(pack_json({"näher": [1, None]})) == {"näher": [1, None]}


TEXTS = st.text(st.sampled_from("a#0195 ٣{}"), max_size=12)


@given(
    st.lists(st.recursive(TEXTS | st.booleans(), lambda part: st.lists(part) | st.dictionaries(TEXTS, part)))
)
def test_texts_alike_survive(values: list[Any]) -> None:
    assert unpack_alike(pack_alike(values)) == values


def test_texts_that_differ_in_numbers_alone_are_kept_once() -> None:
    values = [{"line": f"x#{k} is {2 * k} deep"} for k in range(1000)]
    kept = unpack_json(pack_alike(values))
    assert (kept["texts"], kept["forms"]) == (["x#\0 is \0 deep"], [{"line": 0}])
    assert digits(values) == sum(len(f"{k}{2 * k}") for k in range(1000))


def test_digits_of_escapes_are_none() -> None:
    assert digits([{"line": "näher#12"}]) == 2
