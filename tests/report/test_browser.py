"""The report in a real browser: no network, no errors, pictures, keys."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

playwright = pytest.importorskip("playwright.sync_api")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium: apt-get install chromium")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with playwright.sync_playwright() as started:
        running = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield running
        running.close()


@pytest.fixture
def tab(browser: Any, report: Path) -> Iterator[Any]:
    """The report in a tab that must stay without errors and without requests."""
    opened = browser.new_page(viewport={"width": 1200, "height": 900})
    complaints: list[str] = []
    opened.on("console", lambda message: complaints.append(message.text))
    opened.on("pageerror", lambda error: complaints.append(str(error)))
    opened.on("request", lambda request: complaints.append(request.url[:80]))
    opened.goto(report.as_uri())
    opened.wait_for_selector(".thumb img")
    yield opened
    opened.close()
    assert [line for line in complaints if not line.startswith(("data:image/png", report.as_uri()))] == []


def thumb(tab: Any, method: int, kind: str) -> Any:
    return tab.locator(f".thumb[data-method='{method}'][data-kind={kind}]").last


def chosen(tab: Any, side: str) -> tuple[str, str]:
    """Return method and kind of picture that a pane shows, by the words people see."""
    selects = tab.locator(f"#pane-{side} select")
    words = [selects.nth(k).evaluate("e => e.selectedOptions[0].text") for k in (0, 1)]
    return words[0], words[1]


def test_every_picture_has_pixels(tab: Any) -> None:
    tab.evaluate("dispatchEvent(new Event('beforeprint'))")
    tab.wait_for_function("[...document.images].every(image => image.complete)")
    sizes = tab.evaluate("[...document.images].map(image => [image.naturalWidth, image.naturalHeight])")
    assert len(sizes) > 9 and set(map(tuple, sizes)) == {(64, 48)}
    assert tab.evaluate("[...document.querySelectorAll('.thumb')].every(t => t.querySelector('img'))")


def test_pictures_are_not_blank(tab: Any) -> None:
    for method, kind in ((1, "picture"), (1, "faces"), (1, "depth"), (0, "difference")):
        shown = thumb(tab, method, kind) if kind != "picture" else tab.locator("[data-kind=picture]")
        shown.scroll_into_view_if_needed()
        shown.locator("img").first.wait_for()
        colours = tab.evaluate(
            """async element => {
                const seen = new Set();
                for (const image of element.querySelectorAll('img')) {
                    await image.decode();
                    const canvas = new OffscreenCanvas(image.naturalWidth, image.naturalHeight);
                    const context = canvas.getContext('2d');
                    context.drawImage(image, 0, 0);
                    const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
                    for (let k = 0; k < data.length; k += 4) seen.add(data.slice(k, k + 4).join());
                }
                return seen.size;
            }""",
            shown.element_handle(),
        )
        assert colours > 1, (method, kind)


def test_a_picture_opens_beside_the_reference(tab: Any) -> None:
    thumb(tab, 0, "faces").click()
    assert tab.locator("#viewer").is_visible()
    assert chosen(tab, "left") == ("reference", "faces") and chosen(tab, "right") == ("shifted", "faces")
    tab.keyboard.press("Escape")
    assert not tab.locator("#viewer").is_visible()


def test_keys_choose_methods_and_pictures(tab: Any) -> None:
    thumb(tab, 0, "difference").click()
    assert chosen(tab, "right") == ("shifted", "difference")
    assert chosen(tab, "left") == ("reference", "faces")
    tab.keyboard.press("3")
    assert chosen(tab, "right")[0] == "equal"
    tab.keyboard.press("Shift+Digit1")
    assert chosen(tab, "left") == ("shifted", "difference")
    tab.keyboard.press("z")
    assert (chosen(tab, "left"), chosen(tab, "right")) == (("shifted", "depth"), ("equal", "depth"))
    tab.keyboard.press("b")
    assert (chosen(tab, "left"), chosen(tab, "right")) == (("equal", "depth"), ("shifted", "depth"))
    tab.keyboard.press("9")
    assert chosen(tab, "right")[0] == "shifted"


def test_keys_move_and_zoom_both_panes(tab: Any) -> None:
    def widths() -> list[float]:
        return tab.evaluate("[...document.querySelectorAll('.stage img')].map(i => i.clientWidth)")  # type: ignore[no-any-return]

    thumb(tab, 0, "faces").click()
    position = tab.locator("#viewer-position")
    assert position.inner_text() == "row 24, column 32"
    for key in ("ArrowRight", "ArrowDown", "Shift+ArrowLeft"):
        tab.keyboard.press(key)
    assert position.inner_text() == "row 25, column 23"
    for _ in range(4):
        tab.keyboard.press("Shift+ArrowUp")
    assert position.inner_text() == "row 0, column 23"
    before = widths()
    tab.keyboard.press("+")
    assert len(set(widths())) == 1 and widths()[0] == pytest.approx(1.5 * before[0], abs=1.0)
    tab.keyboard.press("0")
    assert set(widths()) == {64}
    tab.keyboard.press("f")
    assert widths() == before


def test_brackets_walk_through_the_clusters(tab: Any, studied: Any) -> None:
    thumb(tab, 0, "difference").click()
    visited = []
    for key in ("]", "]", "["):
        tab.keyboard.press(key)
        visited.append(tab.locator("#viewer-position").inner_text())
    boxes = [cluster.box for cluster in studied.differences["shifted"].clusters]
    middle = [f"row {(r0 + r1) // 2}, column {(c0 + c1) // 2}" for r0, c0, r1, c1 in boxes]
    assert visited == [middle[0], middle[1], middle[0]]


def test_the_pointer_reads_pixels(tab: Any) -> None:
    thumb(tab, 0, "faces").click()
    stack = tab.locator("#pane-right .stack").bounding_box()
    tab.mouse.move(stack["x"] + stack["width"] * 10.5 / 64, stack["y"] + stack["height"] * 7.5 / 48)
    assert tab.locator("#viewer-position").inner_text() == "row 7, column 10"


def test_everything_is_reached_by_keyboard(tab: Any) -> None:
    tab.locator("[data-kind=picture]").focus()
    tab.keyboard.press("Enter")
    assert tab.locator("#viewer").is_visible()
    assert chosen(tab, "right") == ("reference", "picture")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_phone_needs_no_sideways_scrolling(browser: Any, report: Path, scheme: str) -> None:
    phone = browser.new_page(viewport={"width": 390, "height": 844}, color_scheme=scheme)
    phone.goto(report.as_uri())
    assert phone.evaluate("document.documentElement.scrollWidth") == 390
    ink, paper = phone.evaluate("(s => [s.color, s.backgroundColor])(getComputedStyle(document.body))")
    assert (sum(channels(ink)) > sum(channels(paper))) == (scheme == "dark")
    phone.close()


def channels(colour: str) -> list[int]:
    return [int(part) for part in colour.removeprefix("rgb(").removesuffix(")").split(",")]
