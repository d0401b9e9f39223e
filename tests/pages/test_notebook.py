from __future__ import annotations

import html
import re
import shutil
from pathlib import Path

import pytest

import hsr
from hsr.difference.study import Study
from hsr.pages.inspector import fragment
from hsr.pages.notebook import Report
from hsr.pages.report import report_page
from tests.conftest import SCENES
from tests.pictures.test_png import decoded

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


def test_a_scene_shows_its_picture_and_its_cameras() -> None:
    scene = hsr.load(SCENES / "solids.toml")
    shown = scene._repr_html_()
    assert decoded(re.findall(r'src="([^"]*)"', shown)[0]).shape == (144, 192, 4)
    assert scene.title in html.unescape(shown) and all(camera.name in shown for camera in scene.camera)


def test_a_report_can_be_written(tmp_path: Path) -> None:
    made = hsr.report(hsr.load(SCENES / "cube.toml"), ["backface"], size=(8, 8), reference="backface")
    made.save(tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == made.html


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium: apt-get install chromium")
def test_the_inspector_works_within_a_notebook(studied: Study, tmp_path: Path) -> None:
    sync_api = pytest.importorskip("playwright.sync_api")
    notebook = tmp_path / "notebook.html"
    shown = str(Report(report_page([studied]))._repr_html_())
    notebook.write_text(f"<!doctype html><title>A notebook</title>{shown}", encoding="utf-8")
    complaints: list[str] = []
    with sync_api.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1000, "height": 900})
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.goto(notebook.as_uri())
        frame = page.frames[1]
        frame.click(f"a[href='{fragment(studied.name, 'shifted')}'] >> nth=0")
        frame.wait_for_selector("canvas.stage", state="visible")
        assert page.url == notebook.as_uri() and frame.url.startswith("about:srcdoc#scene=")
        browser.close()
    assert complaints == []
