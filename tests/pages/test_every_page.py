"""Every kind of page in a real browser: whom it serves, light and dark, on desk, phone and paper."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

import hsr
from hsr.difference.study import Study
from hsr.lab.stability.cases import family_named
from hsr.lab.stability.judge import judge
from hsr.lessons.topics import topics
from hsr.pages import checks, gallery, stability
from hsr.pages.frame import PAGES
from hsr.pages.inspector import fragment
from hsr.pages.lesson import write_course
from hsr.pages.report import write_report
from hsr.pages.stories import Shown
from hsr.testing.recording import Check

playwright = pytest.importorskip("playwright.sync_api")
axe = pytest.importorskip("axe_playwright_python.sync_playwright")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium: apt-get install chromium")

ROOT = Path(__file__).parent.parent.parent
DESK, PHONE, PAPER = (1280, 800), (390, 844), (680, 1010)
"""Width and height in pixels; the paper is A4 without its margins."""

INSPECTOR = fragment("cyclic", "backface")
SEEN = {
    "report": "lab.html",
    "growing report": "growing.html",
    "inspector": f"lab.html{INSPECTOR}",
    "keys of the inspector": f"lab.html{INSPECTOR}?",
    "checks": "checks/report.html",
    "gallery": "gallery/index.html",
    "lessons": "lessons/index.html",
    "lesson": "lessons/depth-buffer.html",
    "keys of the lesson": "lessons/depth-buffer.html?",
    "lesson of two methods": "lessons/side-by-side.html",
    "stability": "stability/index.html",
    "API, front page": "api/index.html",
    "API, a module": "api/hsr/kernels.html",
}
"""Every page and what is opened on it: an address, and a key that is pressed there."""


def write_site(folder: Path, painted: Study, real: Study) -> None:
    """Write a page of every kind, small, where the project's own pages lie."""
    for place in (*PAGES.values(), "checks/report.html"):  # whatever is written first leads to all others
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
        (folder / place).touch()
    command = [sys.executable, str(ROOT / "docs" / "api.py"), str(folder / "api")]
    path = os.pathsep.join([str(Path(hsr.__file__).parent.parent), os.environ.get("PYTHONPATH", "")])
    documented = subprocess.Popen(command, env={**os.environ, "PYTHONPATH": path}, stdout=subprocess.DEVNULL)
    maps = {"exact": real.maps["exact"], "mine": real.maps["backface"]}
    found, why = real.differences["backface"], real.causes["backface"]
    failed = Shown("e/1", real.view, maps, "exact", {"mine": found}, {"mine": why})
    (folder / "checks" / "e.json").write_text(json.dumps(checks.kept(failed)), encoding="utf-8")
    made = [
        Check(
            "e/1", "mine", False, "many differ", {"no depth test": 9}, inspection="e.json", baseline="b.npz"
        ),
        Check("d/1", "fine", True, "0 samples", lets_pass={"flipped y": 12}),
    ]
    pairs = [("test_mine", asdict(check)) for check in made]
    checks.write_page(pairs, "run", ["x/gone.npz"], folder / "checks" / "report.html")
    scenes = {"cyclic": real.scene, "cube": hsr.load("cube")}
    gallery.write_gallery(scenes, folder / "gallery", (48, 48), ["cube"], lambda _: None)
    write_course({name: topics()[name] for name in ("depth-buffer", "side-by-side")}, folder / "lessons")
    cases = {"integer-overflow": ("zbuffer", "int32"), "cyclic-overlap": ("zbuffer", "painter")}
    stability.write_folder(
        [judge(family_named(name), True, names) for name, names in cases.items()], folder / "stability"
    )
    assert documented.wait() == 0
    write_report([painted, real], folder / "growing.html", pending=["absent"])
    for place in ("sample.html", "lab.html"):
        write_report([painted, real], folder / place)


@pytest.fixture(scope="module")
def site(studied: Study, real: Study, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    with pytest.MonkeyPatch.context() as small:
        small.setattr(gallery, "SIDE", 24)
        small.setattr(gallery, "TURN", 4)
        small.setattr(gallery, "methods", lambda: ("exact", "scanline", "backface", "raycast"))
        write_site(folder, studied, real)
    return folder


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with playwright.sync_playwright() as started:
        running = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield running
        running.close()


@pytest.fixture
def visit(browser: Any, site: Path) -> Iterator[Callable[..., Any]]:
    """Open a page that stays as it is, and press its key; axe is no script of the page's own."""
    opened: list[Any] = []

    def at(name: str, size: tuple[int, int] = DESK, **settings: Any) -> Any:
        address, key = SEEN[name].removesuffix("?"), SEEN[name][-1]
        window = {"width": size[0], "height": size[1]}
        tab = browser.new_page(viewport=window, bypass_csp=True, **settings)
        opened.append(tab)
        tab.add_init_script("window.setInterval = () => 0")
        tab.goto(f"{site.as_uri()}/{address}")
        if "lesson" in name and name != "lessons":
            tab.wait_for_selector("#lines li", state="attached")
        if "inspector" in name:
            tab.locator("#story p").first.wait_for(state="attached")
        if key == "?":
            tab.keyboard.press("?")
        return tab

    yield at
    for tab in opened:
        tab.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", SEEN)
def test_nobody_is_shut_out(visit: Any, name: str, scheme: str) -> None:
    rules = {"runOnly": ["color-contrast"]} if scheme == "dark" else None  # all else is the same
    found = axe.Axe().run(visit(name, color_scheme=scheme), options=rules).response["violations"]
    grave = [one for one in found if one["impact"] in ("serious", "critical")]
    assert [(one["id"], [node["html"][:120] for node in one["nodes"]]) for one in grave] == []


@pytest.mark.parametrize("name", SEEN)
def test_a_phone_needs_no_sideways_scrolling(visit: Any, name: str) -> None:
    assert visit(name, PHONE).evaluate("document.documentElement.scrollWidth") == PHONE[0]


@pytest.mark.parametrize("name", [name for name in SEEN if "keys" not in name])
def test_paper_is_light_has_no_controls_and_cuts_nothing(visit: Any, name: str) -> None:
    tab = visit(name, PAPER, color_scheme="dark")
    tab.emulate_media(media="print")
    assert tab.evaluate("document.documentElement.scrollWidth") <= PAPER[0]
    ink, paper = tab.evaluate("(s => [s.color, s.backgroundColor])(getComputedStyle(document.body))")
    assert paper in ("rgb(255, 255, 255)", "rgba(0, 0, 0, 0)") and ink != "rgb(230, 228, 221)"
    assert tab.locator(":is(nav, .bar, footer, dialog, input[type=search]):visible").count() == 0
    assert tab.evaluate(
        "[...document.querySelectorAll('.wide, pre')].every(e => e.scrollWidth <= e.clientWidth + 1)"
    )


@pytest.mark.parametrize("name", SEEN)
def test_who_goes_by_keyboard_sees_where_they_are(visit: Any, name: str) -> None:
    tab = visit(name)
    seen = set()
    for _ in range(15):
        tab.keyboard.press("Tab")
        outline, tag = tab.evaluate(
            "() => { const e = document.activeElement, s = getComputedStyle(e);"
            " return [s.outlineStyle !== 'none' && s.outlineWidth !== '0px', e.outerHTML.slice(0, 90)]; }"
        )
        assert outline or tag.startswith("<body"), tag
        seen.add(tag)
    assert len(seen) > 1


def test_pages_lead_to_each_other(visit: Any) -> None:
    for name in ("report", "checks", "gallery", "lessons", "lesson", "stability", "API, front page"):
        links = (
            visit(name).locator("nav a").evaluate_all("all => all.map(e => [e.textContent.trim(), e.href])")
        )
        told = {told: Path(href.removeprefix("file://")) for told, href in links}
        assert {*PAGES} - {*told} <= ({"API"} if name.startswith("API") else set())
        assert all(file.is_file() for file in told.values())


def test_pages_that_are_kept_lead_to_pages_that_are_kept() -> None:
    listed = subprocess.run(["git", "ls-files", "reports"], cwd=ROOT, capture_output=True, text=True).stdout
    kept = {ROOT / name for name in listed.splitlines()}
    for file in (file for file in kept if file.suffix == ".html"):
        links = re.findall(r'<a href="([^"#]+)"', file.read_text(encoding="utf-8"))
        assert {(file.parent / link).resolve() for link in links} <= kept, file
