from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from hsr.difference.telling import Said, say
from hsr.pages.packing import pack, pack_json, pack_told
from tests.pages.unpacking import unpack, unpack_json, unpack_told


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


FORMS = ("{}: {:.3g}", "{} or {:+.4g}", "{}; {:.9g}")
NUMBERS = st.floats(-1e300, 1e300) | st.sampled_from([-0.0, 1e-5, 0.0001, 999.96, 1e9, float("inf")])
LINES = st.tuples(
    st.sampled_from(["face", "missed"]), st.builds(say, st.sampled_from(FORMS), st.text(), NUMBERS)
)


@given(st.lists(st.lists(LINES)))
def test_histories_survive_as_they_are_shown(histories: list[list[tuple[str, Said]]]) -> None:
    told = [[(kind, str(said)) for kind, said in lines] for lines in histories]
    assert unpack_told(pack_told(histories)) == told


def test_words_are_kept_once_and_numbers_as_they_are_shown() -> None:
    form = "{} is {:.3g} deep"
    kept = unpack_json(
        pack_told([[("face", say(form, f"x#{k}", k / 3)), ("face", say("."))] for k in (0, 1)])
    )
    assert kept["forms"] == [["face", form], ["face", "."]] and kept["lines"] == [[0, 1], [0, 1]]
    assert kept["columns"] == [[["x#0", "x#1"], [0.0, 0.333]], []]
