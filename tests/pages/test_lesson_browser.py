"""Lessons in a real browser: every key, a lesson to its end, predictions; no error, no request."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.lessons.lesson import LETTERS, view_of
from hsr.lessons.topics import topics
from hsr.pages.lesson import write_course

playwright = pytest.importorskip("playwright.sync_api")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium: apt-get install chromium")

LESSONS = tuple(topics())


@pytest.fixture(scope="module")
def course(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("course")
    write_course(topics(), folder)
    return folder


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with playwright.sync_playwright() as started:
        running = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield running
        running.close()


@pytest.fixture
def open_lesson(browser: Any, course: Path) -> Iterator[Any]:
    """Open a lesson in a tab that must stay without errors and without requests."""
    complaints: list[str] = []
    tabs: list[Any] = []

    def opened(name: str, width: int = 1280, height: int = 800, scheme: str = "light") -> Any:
        tab = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
        address = (course / f"{name}.html").as_uri()
        tab.on("console", lambda message: complaints.append(message.text))
        tab.on("pageerror", lambda error: complaints.append(str(error)))
        tab.on("request", lambda request: request.url == address or complaints.append(request.url[:80]))
        tab.goto(address)
        tab.wait_for_selector("#lines li", state="attached")
        tabs.append(tab)
        return tab

    yield opened
    for tab in tabs:
        tab.close()
    assert complaints == []


def position(tab: Any) -> int:
    return int(tab.eval_on_selector("#scrub", "e => e.value"))


def letters(tab: Any, panel: int = 0) -> list[str]:
    """Return what stands in the cells of a face buffer."""
    found: list[str] = tab.evaluate(
        "k => [...document.querySelectorAll('.panel')[k].querySelector('svg').querySelectorAll('text')]"
        ".map(cell => cell.textContent)",
        panel,
    )
    return found


@pytest.mark.parametrize("name", LESSONS)
def test_a_lesson_ends_with_the_picture_of_the_method(name: str, open_lesson: Any) -> None:
    tab, track = open_lesson(name), topics()[name].track[0]
    tab.keyboard.press("End")
    for panel, method in enumerate(track.methods):
        answer = hsr.render(view_of(track), method, **track.options)
        seen = np.unique(answer.face[answer.face >= 0])
        shown = letters(tab, panel)
        assert [bool(letter) for letter in shown] == (answer.face.ravel() >= 0).tolist()
        assert len(
            {(letter, face) for letter, face in zip(shown, answer.face.flat, strict=True) if letter}
        ) == len(seen)
        assert set(shown) <= {*LETTERS, ""}


@pytest.mark.parametrize("name", LESSONS)
def test_every_screen_and_track_opens(name: str, open_lesson: Any) -> None:
    tab, topic = open_lesson(name), topics()[name]
    for screen in topic.screen:
        assert tab.text_content("#screen-title") == screen.title
        assert tab.text_content("#screen-text") == screen.text
        if screen.track is not None:
            assert tab.eval_on_selector("#track", "e => e.selectedOptions[0].text") == screen.track
        tab.keyboard.press("PageDown")
    assert tab.text_content("#ask-text") == topic.question.text
    tab.keyboard.press(str(topic.question.answer + 1))
    assert tab.text_content("#score") == "score 1 of 1"
    assert tab.text_content("#verdict") == topic.question.why
    tab.keyboard.press("PageUp")
    assert tab.text_content("#screen-title") == topic.screen[-1].title
    for _ in topic.track:
        tab.keyboard.press("t")
        tab.keyboard.press("End")
        tab.keyboard.press("Home")
        assert position(tab) == 0


def test_keys_step_and_go_back(open_lesson: Any) -> None:
    tab = open_lesson("depth-buffer")
    tab.keyboard.press("Home")
    empty = letters(tab)
    assert not any(empty)
    for _ in range(3):
        tab.keyboard.press("ArrowRight")
    assert position(tab) == 3
    tab.keyboard.press("ArrowLeft")
    assert position(tab) == 2
    for _ in range(4):
        tab.keyboard.press("n")
    one_more = position(tab)
    assert sum(map(bool, letters(tab))) == 3
    tab.keyboard.press("p")
    assert position(tab) < one_more and sum(map(bool, letters(tab))) == 2
    tab.keyboard.press("End")
    assert any(letters(tab))
    tab.keyboard.press("Home")
    assert letters(tab) == empty


def test_the_line_that_has_run_is_marked_and_its_numbers_are_in_the_formula(open_lesson: Any) -> None:
    tab = open_lesson("depth-buffer")
    tab.keyboard.press("PageDown")
    tab.keyboard.press("PageDown")
    assert tab.text_content("#lines [aria-current]").strip() == "z -= z_across"
    told = tab.text_content("#formula").replace("−", "-")
    shown = told.split("z₁ - A/C = ")[1]
    before, step, after = (float(number) for number in re.findall(r"-?\d[\d.e-]*", shown))
    assert before - step == pytest.approx(after, abs=1e-3)
    assert tab.is_visible("#lines [aria-current]")


def test_speed_larger_help_and_jump_keys(open_lesson: Any) -> None:
    tab = open_lesson("depth-buffer")
    tab.keyboard.press("ArrowUp")
    assert tab.input_value("#speed") == "4"
    tab.keyboard.press("ArrowDown")
    assert tab.input_value("#speed") == "3"
    tab.keyboard.press("l")
    assert not tab.is_visible("#lines")
    tab.keyboard.press("l")
    assert tab.is_visible("#lines")
    tab.keyboard.press("?")
    assert tab.is_visible("#keys")
    tab.keyboard.press("Escape")
    assert not tab.is_visible("#keys")
    tab.keyboard.press("g")
    tab.keyboard.type("5")
    tab.keyboard.press("Tab")
    tab.keyboard.type("6")
    tab.keyboard.press("Enter")
    assert "at column 5, row 6" in tab.get_attribute(".grid", "aria-label")
    tab.click(".grid g:nth-child(88)")
    assert "at column 7, row 5" in tab.get_attribute(".grid", "aria-label")


def test_playing_stops_at_a_prediction_and_scores_it(open_lesson: Any) -> None:
    tab = open_lesson("depth-buffer")
    tab.evaluate("document.getElementById('speed').value = 9")
    right = 0
    for asked in range(1, 7):
        tab.keyboard.press(" ")
        tab.wait_for_selector("#ask:visible button:not([disabled])")
        assert tab.text_content("#play") == "play"
        names = tab.eval_on_selector_all("#choices button", "all => all.map(e => e.textContent)")
        assert [name[1:] for name in names] == ["Awall", "Bsail#0"]
        tab.keyboard.press("2")
        right += tab.eval_on_selector("#choices button:nth-child(2)", "e => e.classList.contains('right')")
        assert tab.text_content("#score") == f"score {right} of {asked}"
        tab.keyboard.press("1")
        assert tab.text_content("#score") == f"score {right} of {asked}"
    assert right == 3
    tab.keyboard.press(" ")
    tab.wait_for_selector("#play[aria-label=stop]")
    tab.wait_for_selector("#play[aria-label=play]")
    assert position(tab) == int(tab.get_attribute("#scrub", "max"))
    assert tab.text_content("#score") == "score 3 of 6"


@pytest.mark.parametrize(("width", "height"), [(360, 740), (1280, 800), (3840, 2160)])
def test_a_prediction_and_its_verdict_are_seen_where_they_are_asked(
    width: int, height: int, open_lesson: Any
) -> None:
    tab = open_lesson("depth-buffer", width, height)
    tab.evaluate("document.getElementById('speed').value = 9")
    tab.keyboard.press(" ")
    tab.wait_for_selector("#ask:visible button:not([disabled])")
    tab.keyboard.press("1")
    tab.wait_for_timeout(500)  # until it has scrolled there
    asked, footer = tab.locator("#ask").bounding_box(), tab.locator("footer").bounding_box()
    assert asked["y"] >= 0 and asked["y"] + asked["height"] <= footer["y"]
    if width > 360:
        shown = tab.locator(".grid").first.bounding_box()
        assert shown["y"] >= 0 and shown["y"] + shown["height"] <= footer["y"]


def test_both_methods_of_a_pair_move_together(open_lesson: Any) -> None:
    tab = open_lesson("side-by-side")
    for _ in range(10):
        tab.keyboard.press("ArrowRight")
    counts = tab.eval_on_selector_all(".counters b", "all => all.map(e => Number(e.textContent))")
    assert counts[1] == 10 and counts[3] == 10
    tab.keyboard.press("n")
    tab.keyboard.press("p")
    assert position(tab) == 10
    tab.keyboard.press("End")
    assert letters(tab, 0) == letters(tab, 1)


@pytest.mark.parametrize(("width", "height"), [(360, 740), (768, 1024), (3840, 2160)])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_sticks_out_sideways(width: int, height: int, scheme: str, open_lesson: Any) -> None:
    for name in ("ray-casting", "side-by-side"):
        tab = open_lesson(name, width, height, scheme)
        tab.keyboard.press("PageDown")
        assert tab.evaluate("document.documentElement.scrollWidth") <= width
        background = tab.evaluate("getComputedStyle(document.body).backgroundColor")
        assert (background == "rgb(24, 24, 22)") == (scheme == "dark")
