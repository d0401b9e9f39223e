"""The page of a test run: what it shows, in a real browser, too."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from hsr.report.checks import write_page
from hsr.testing.recording import Check
from hsr.visibility import VisibilityMap

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page of a wrong map, a map without a baseline, pictures that differ, and a check that passed."""
    folder = tmp_path_factory.mktemp("results")
    face = np.full((24, 32), -1, np.int32)
    face[4:20, 6:26] = 3
    depth = np.where(face < 0, np.inf, 2.0)
    wrong = face.copy()
    wrong[10:12, 8:10] = 1
    VisibilityMap(face, depth, "exact").save(folder / "expected.npz")
    VisibilityMap(wrong, depth, "painter").save(folder / "shown.npz")
    for name, value in (("expected", 90), ("shown", 200)):
        Image.fromarray(np.full((24, 32, 3), value, np.uint8)).save(folder / f"{name}.png")
    baseline = "tests/__visibility__/test_a/test_<b>.npz"
    checks = [
        Check(
            "a/1", "mine", False, "4 <differ>", shown="shown.npz", expected="expected.npz", baseline=baseline
        ),
        Check("b/1", "new", False, "there is no baseline", shown="shown.npz", baseline="x/new.npz"),
        Check("c/1", "pictures", False, "differ", shown="shown.png", expected="expected.png", weaker=True),
        Check("d/1", "fine", True, "0 samples", lets_pass={"flipped y": 12}),
    ]
    entries = [(f"test_{check.key[0]}", asdict(check)) for check in checks]
    write_page(entries, "run-7", ["x/gone.npz"], folder / "report.html")
    return folder / "report.html"


def test_everything_is_told_without_scripts(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert "4 checks, 3 failed" in text
    assert "4 &lt;differ&gt;" in text and "test_&lt;b&gt;.npz" in text
    assert "a weaker check, of colours" in text
    assert "would pass with the mistake “flipped y”; wrong samples: 12" in text
    assert "x/gone.npz" in text
    assert text.index("there is no baseline") < text.index("0 samples")
    assert "http" not in text.replace("http-equiv", "").replace("http://www.w3.org/2000/svg", "")


def test_a_page_without_failures_needs_no_viewer(tmp_path: Path) -> None:
    write_page([("test_a", asdict(Check("a/1", "fine", True, "0 samples")))], "r", [], tmp_path / "p.html")
    text = (tmp_path / "p.html").read_text(encoding="utf-8")
    assert "1 checks, 0 failed" in text and 'id="viewer"' not in text and 'id="download"' not in text


# ---------------------------------------------------------------- in a browser


@pytest.fixture
def tab(page: Path) -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api")
    if CHROMIUM is None:
        pytest.skip("no chromium: apt-get install chromium")
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        opened = browser.new_page(viewport={"width": 1200, "height": 900})
        complaints: list[str] = []
        opened.on("console", lambda message: complaints.append(message.text))
        opened.on("pageerror", lambda error: complaints.append(str(error)))
        opened.goto(page.as_uri())
        yield opened
        browser.close()
        assert complaints == []


def test_a_link_opens_the_sample(tab: Any, page: Path) -> None:
    assert not tab.locator("#viewer").is_visible()
    tab.goto(f"{page.as_uri()}#check=a/1&x=8&y=10")
    assert tab.locator("#viewer").is_visible()
    assert tab.locator("#viewer-position").inner_text() == "row 10, column 8"
    shown = tab.locator("#pane-right select")
    words = [shown.nth(k).evaluate("e => e.selectedOptions[0].text") for k in (0, 1)]
    assert words == ["mine", "difference"]
    tab.goto(f"{page.as_uri()}#check=c/1")
    assert tab.locator("#pane-right select").nth(1).evaluate("e => e.selectedOptions[0].text") == "picture"


def test_decisions_are_handed_out_as_a_file(tab: Any, tmp_path: Path) -> None:
    button = tab.locator("#download")
    assert button.is_disabled()
    tab.locator("fieldset[data-check='a/1'] input[value=accept]").check()
    tab.locator("fieldset[data-check='b/1'] input[value=reject]").check()
    tab.locator("fieldset[data-check='b/1'] input[value=variant]").check()
    with tab.expect_download() as download:
        button.click()
    assert download.value.suggested_filename == "decisions.json"
    download.value.save_as(tmp_path / "decisions.json")
    made = json.loads((tmp_path / "decisions.json").read_text(encoding="utf-8"))
    assert made == {"hsr": 1, "run": "run-7", "decisions": {"a/1": "accept", "b/1": "variant"}}
