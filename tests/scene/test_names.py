"""Names made of whatever files give."""

from __future__ import annotations

import sys
from types import FrameType

from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter

from hsr.scene.model import Name
from hsr.scene.names import printable, unique

NAME: TypeAdapter[str] = TypeAdapter(Name)


def test_names_are_made_different() -> None:
    assert unique(["a", "a", "b", "a", "a.1", ""]) == ["a", "a.1", "b", "a.2", "a.1.1", "unnamed"]


def test_characters_that_are_not_printable_are_escaped() -> None:
    assert printable("Gear\xa0wheel\n\u200b\ud800\U0001f600é") == "Gear\\xa0wheel\\n\\u200b\\ud800\U0001f600é"


@given(st.lists(st.text(st.characters(exclude_categories=[]), max_size=100), max_size=20))
def test_any_names_can_be_names_of_a_scene_file(names: list[str]) -> None:
    found = unique([*names, *names])
    assert len(set(found)) == 2 * len(names)
    assert [NAME.validate_python(name) for name in found] == found


def test_the_work_grows_with_the_number_of_names() -> None:
    lines = 0

    def count(frame: FrameType, *_: object) -> object:
        nonlocal lines
        lines += 1
        return count if frame.f_code is unique.__code__ else None

    before = sys.gettrace()
    sys.settrace(count)
    try:
        names = unique(["n"] * 2000 + [f"n.{k}" for k in range(2000)])
    finally:
        sys.settrace(before)
    assert len(set(names)) == 4000 and lines < 10 * 4000 + 4000 * 5
