"""The lessons themselves: what they point to is there, and what they say of numbers is so."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.base.errors import HsrError, MethodError
from hsr.lessons.lesson import depth_writer, lesson_of, readable, view_of
from hsr.lessons.topics import Topic, topic_named, topics
from hsr.scene.model import Scene


@pytest.fixture(scope="module")
def course() -> dict[str, dict[str, Any]]:
    return {name: lesson_of(topic) for name, topic in topics().items()}


@pytest.mark.parametrize("name", topics())
def test_screens_and_formulas_point_to_lines_of_the_listing(
    name: str, course: dict[str, dict[str, Any]]
) -> None:
    topic, panels = topics()[name], [track["panels"][0] for track in course[name]["tracks"]]
    for screen in topic.screen:
        shown = [track.label for track in topic.track].index(screen.track) if screen.track else 0
        if screen.line is not None:
            run = [panels[shown]["listing"][line].strip() for line in panels[shown]["lines"]]
            assert sum(text.startswith(screen.line) for text in run) >= screen.nth, screen.title
    for formula in topic.formula:
        assert any(formula.text in panel["formulas"].values() for panel in panels), formula.line


@pytest.mark.parametrize("name", topics())
def test_formulas_name_variables_that_are_shown(name: str, course: dict[str, dict[str, Any]]) -> None:
    for track in course[name]["tracks"]:
        for panel in track["panels"]:
            for line, text in panel["formulas"].items():
                shown = {
                    slot for function, slot in panel["slots"] if function == panel["functions"][int(line)]
                }
                assert set(re.findall(r"\{~?([^}]+)\}", text)) <= shown, text


def test_every_lesson_asks_and_answers(course: dict[str, dict[str, Any]]) -> None:
    for name, lesson in course.items():
        asked = [question for track in lesson["tracks"] for question in track["asked"]]
        assert asked, name
        assert all(question["owner"] in question["faces"] for question in asked)


def test_culling_is_right_apart_and_wrong_behind() -> None:
    apart, behind = (view_of(track) for track in topics()["culling"].track)
    assert (hsr.render(apart, "backface").face == hsr.render(apart, "exact").face).all()
    assert (hsr.render(behind, "backface").face != hsr.render(behind, "exact").face).any()


def test_the_order_of_drawing_does_not_matter() -> None:
    one, other = (view_of(track) for track in topics()["depth-buffer"].track)
    first, second = hsr.render(one, "scanline").face, hsr.render(other, "scanline").face
    np.testing.assert_array_equal(second, np.choose(first + 1, [-1, 1, 0]))


def test_fighting_ends_where_the_lesson_says() -> None:
    wrong = []
    for track in topics()["z-fighting"].track:
        view = view_of(track)
        seen = hsr.render(view, track.methods[0], **track.options)
        wrong.append(int((seen.face != hsr.render(view, "exact").face).sum()))
    assert wrong[0] > 40 and wrong[1] == wrong[2] == 0 and wrong[3] <= 1


def test_nine_tenths_of_the_levels_lie_near_the_eye() -> None:
    near, far, d = 0.01, 100.0, 0.1
    assert (1.0 - near / d) / (1.0 - near / far) == pytest.approx(0.9, abs=1e-3)


def test_the_squares_share_one_level() -> None:
    seen = hsr.render(view_of(topics()["z-fighting"].track[0]), "scanline-d16")
    assert len(np.unique(seen.depth[seen.face >= 0])) == 1


def test_certified_is_right_where_plain_is_not() -> None:
    certified, plain = (view_of(track) for track in topics()["certified"].track)
    truth = hsr.render(certified, "exact").face
    assert (hsr.render(certified, "zbuffer").face == truth).all()
    assert (hsr.render(plain, "zbuffer-plain").face != truth).any()


def test_another_scene_may_be_seen(make_scene: Any) -> None:
    scene = make_scene([{"name": "one", "shape": "cube"}])
    lesson = lesson_of(topics()["z-fighting"], scene)
    assert [track["label"] for track in lesson["tracks"]] == [
        "16 bits, near = 0.01",
        "24 bits, near = 0.01",
        "16 bits of linear depth, near = 0.01",
    ]
    assert lesson["tracks"][0]["faces"][4]["name"] == "one.front"


def test_a_large_scene_is_refused(make_scene: Any) -> None:
    scene: Scene = make_scene([{"name": "ball", "shape": "sphere"}])
    with pytest.raises(MethodError, match=r"faces are too many to follow step by step, 48 is the most"):
        lesson_of(topics()["depth-buffer"], scene)
    assert lesson_of(topics()["ray-casting"], scene)["tracks"]


def test_unknown_topics_are_refused() -> None:
    with pytest.raises(HsrError, match="no lesson is about 'zbufer'; there are culling, depth-buffer"):
        topic_named("zbufer")


def test_a_topic_must_be_whole() -> None:
    values = topics()["culling"].model_dump()
    with pytest.raises(ValueError, match="answer 7: there are 3 choices"):
        Topic.model_validate(values | {"question": values["question"] | {"answer": 7}})
    with pytest.raises(ValueError, match="no track is labelled 'gone'"):
        Topic.model_validate(values | {"screen": [{"title": "a", "text": "b", "track": "gone"}]})


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.123456, "0.1235"), (-2.0, "−2"), (float("inf"), "∞"), (float("nan"), "–"), (3, "3"), (True, "true"),
     ([1.5, [2, -1]], "(1.5, (2, −1))"), (2**60, "0x1000000000000000")],
)  # fmt: skip
def test_values_are_readable(value: Any, text: str) -> None:
    assert readable(value) == text


def test_depths_have_the_figures_that_tell_them_apart() -> None:
    assert [depth_writer([0.25, 0.75])(z) for z in (0.25, 0.5, np.inf)] == [".250", ".500", "∞"]
    assert depth_writer([65000.0, 65535.0])(65001.0) == "65001"
    assert depth_writer([6.0])(6.0) == "6" and depth_writer([])(np.inf) == "∞"
