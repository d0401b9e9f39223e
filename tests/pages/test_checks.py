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

import hsr
from hsr.difference.classes import compare
from hsr.difference.study import Study
from hsr.pages.checks import kept, write_page
from hsr.pages.inspector import fragment
from hsr.pages.stories import Shown
from hsr.problem.map import VisibilityMap
from hsr.testing.recording import Check
from tests.pages.policies import assert_strict

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


def painted() -> Shown:
    """Return two maps of nobody knows what, that differ at four samples."""
    face = np.full((24, 32), -1, np.int32)
    face[4:20, 6:26] = 3
    depth = np.where(face < 0, np.inf, 2.0)
    wrong = face.copy()
    wrong[10:12, 8:10] = 1
    expected, shown = VisibilityMap(face, depth, "kept.npz"), VisibilityMap(wrong, depth, "painter")
    maps = {"kept.npz": expected, "mine": shown}
    return Shown("a/1", None, maps, "kept.npz", {"mine": compare(shown, expected)}, {})


def rendered(real: Study) -> Shown:
    """Return a wrong map of a known view, and the truth."""
    maps = {"exact": real.maps["exact"], "mine": real.maps["backface"]}
    found, why = real.differences["backface"], real.causes["backface"]
    return Shown("e/1", real.view, maps, "exact", {"mine": found}, {"mine": why})


@pytest.fixture(scope="module")
def page(real: Study, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page of wrong maps, a map without a baseline, pictures that differ, and a check that passed."""
    folder = tmp_path_factory.mktemp("results")
    alone = Shown("b/1", None, {"new": painted().maps["mine"]}, None, {}, {})
    for name, shown in {"a": painted(), "b": alone, "e": rendered(real)}.items():
        (folder / f"{name}.json").write_text(json.dumps(kept(shown)), encoding="utf-8")
    for name, value in (("expected", 90), ("shown", 200)):
        Image.fromarray(np.full((24, 32, 3), value, np.uint8)).save(folder / f"{name}.png")
    baseline = "tests/__visibility__/test_a/test_<b>.npz"
    checks = [
        Check("a/1", "mine", False, "4 <differ>", inspection="a.json", baseline=baseline),
        Check("b/1", "new", False, "there is no baseline", inspection="b.json", baseline="x/new.npz"),
        Check("c/1", "pictures", False, "differ", shown="shown.png", expected="expected.png", weaker=True),
        Check("e/1", "mine", False, "many differ", {"no depth test": 9}, inspection="e.json"),
        Check("d/1", "fine", True, "0 samples", lets_pass={"flipped y": 12}),
    ]
    entries = [(f"test_{check.key[0]}", asdict(check)) for check in checks]
    write_page(entries, "run-7", ["x/gone.npz"], folder / "report.html")
    return folder / "report.html"


def test_everything_is_told_without_scripts(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert "5 checks, 4 failed" in text
    assert "4 &lt;differ&gt;" in text and "test_&lt;b&gt;.npz" in text
    assert "a weaker check, of colours" in text
    assert "would pass with the mistake “flipped y”; wrong samples: 12" in text
    assert "x/gone.npz" in text
    assert text.index("there is no baseline") < text.index("0 samples")
    assert "http" not in text.replace("http-equiv", "")
    assert_strict(text)


def test_a_page_without_failures_needs_no_viewer(tmp_path: Path) -> None:
    write_page([("test_a", asdict(Check("a/1", "fine", True, "0 samples")))], "r", [], tmp_path / "p.html")
    text = (tmp_path / "p.html").read_text(encoding="utf-8")
    assert "1 checks, 0 failed" in text and 'id="inspector"' not in text and 'id="download"' not in text


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


def opened(tab: Any, page: Path, check: str, sample: tuple[int, int]) -> None:
    """Follow the link of a check to a sample."""
    tab.goto(page.as_uri() + fragment(check, "mine", sample))
    tab.locator("#story p").first.wait_for()
    assert tab.locator("#position").inner_text() == f"column {sample[1]}, row {sample[0]}"


def test_a_link_opens_the_sample_of_maps_without_a_scene(tab: Any, page: Path) -> None:
    assert not tab.locator("#inspector").is_visible()
    opened(tab, page, "a/1", (10, 8))
    cells = [row.split("\t") for row in tab.locator("#methods tr").all_inner_texts()]
    assert [(name, told) for name, _, _, told in cells] == [("kept.npz", "reference"), ("mine", "wrong face")]
    assert "nothing says which scene" in tab.locator("#story").inner_text()
    assert tab.locator("#overlay option").all_text_contents() == ["none"]
    tab.keyboard.press("v")
    assert tab.locator("#overlay").input_value() == "none"


def test_a_link_opens_the_history_of_a_sample_of_a_scene(tab: Any, page: Path, real: Study) -> None:
    row, column = real.differences["backface"].clusters[0].sample
    opened(tab, page, "e/1", (row, column))
    told = hsr.history(real.view, [real.maps["exact"], real.maps["backface"]], x=column, y=row)
    lines = tab.locator("#story p, #story .line, #story .verdict, #story .missed li, #story .sentences li")
    assert lines.all_text_contents() == [line.strip() for line in str(told).splitlines() if line.strip()]
    assert "wrong face, no depth test" in tab.locator("#methods").inner_text()


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


def test_checks_are_filtered_and_what_is_shown_is_accepted_at_once(tab: Any) -> None:
    def shown() -> list[str]:
        return tab.locator("section.check:visible h2").all_inner_texts()

    tab.locator("#state").select_option("no depth test")
    assert [name.split()[-1] for name in shown()] == ["test_e"]
    assert tab.locator("#matching").inner_text() == "1 of 5 checks"
    tab.locator("#state").select_option("failed")
    tab.locator("#words").fill("TEST_B")
    assert [name.split()[-1] for name in shown()] == ["test_b"]
    tab.locator("#all").click()
    tab.locator("#words").fill("")
    assert len(shown()) == 4
    assert tab.locator("fieldset[data-check='b/1'] input[value=accept]").is_checked()
    assert not tab.locator("fieldset[data-check='a/1'] input:checked").count()
    tab.locator("#all").click()
    assert tab.locator("fieldset input[value=accept]:checked").count() == 2
    assert tab.locator("#download").is_enabled()
