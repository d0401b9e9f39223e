from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from hsr.report.packing import pack, pack_json
from tests.report.unpacking import unpack, unpack_json


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
