"""The report in a real browser: no network, no errors, pictures, keys."""

from __future__ import annotations

import io
import re
import shutil
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import hsr
from hsr.cli.app import app
from hsr.difference.classes import SampleClass, compare
from hsr.difference.study import Study, study
from hsr.models.stages import Cause
from hsr.pages.inspector import HELP, fragment
from hsr.pages.report import write_report
from hsr.pictures.palette import CAUSE_COLOURS, CLASS_COLOURS, face_colours
from tests.pages.unpacking import scene_of, unpack

playwright = pytest.importorskip("playwright.sync_api")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium: apt-get install chromium")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with playwright.sync_playwright() as started:
        running = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield running
        running.close()


@pytest.fixture(scope="module")
def inspected(real: Study, studied: Study, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report on two scenes: one of painted maps and one that was rendered."""
    path = tmp_path_factory.mktemp("inspected") / "report.html"
    write_report([studied, real], path, histories=None)
    return path


@pytest.fixture
def visit(browser: Any, inspected: Path) -> Iterator[Callable[[str], Any]]:
    """Open the report at a fragment; it must stay without complaints, requests and frozen errors."""
    complaints: list[str] = []
    opened: list[Any] = []

    def at(fragment: str, **settings: Any) -> Any:
        tab = browser.new_page(**({"viewport": {"width": 1200, "height": 900}} | settings))
        tab.on("console", lambda message: complaints.append(message.text))
        tab.on("pageerror", lambda error: complaints.append(str(error)))
        tab.on("request", lambda request: complaints.append(request.url[:80]))
        opened.append(tab)
        tab.goto(inspected.as_uri() + fragment)
        if fragment:
            ready(tab)
        return tab

    yield at
    for tab in opened:
        tab.close()
    assert [line for line in complaints if not line.startswith(("data:image/webp", inspected.as_uri()))] == []


def ready(tab: Any) -> None:
    tab.locator("#methods tr").first.wait_for(state="attached")
    tab.wait_for_selector("#inspector:not([aria-busy])")
    tab.locator("#story p").first.wait_for(state="attached")


def chosen(tab: Any) -> list[str]:
    """Return mode, kind, overlay, and the methods on the left and right."""
    names = ("mode", "kind", "overlay", "method-left", "method-right")
    words = [tab.locator(f"#{name}").evaluate("e => e.selectedOptions[0].text") for name in names]
    return [re.sub(r"^\d\s+", "", word) for word in words]


def text(tab: Any, name: str) -> str:
    return str(tab.locator(f"#{name}").text_content())


def scale(tab: Any) -> float:
    return float(text(tab, "scale").removesuffix("×"))


def shot(tab: Any, selector: str, number: int = 0) -> Any:
    """Return a canvas as the eye sees it, (H, W, 3)."""
    tab.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    with Image.open(io.BytesIO(tab.locator(selector).nth(number).screenshot())) as image:
        return np.asarray(image.convert("RGB"))


def pixels(tab: Any, stage: int, *where: tuple[float, float]) -> list[list[int]]:
    """Return the colours of a stage at places (x, y), in samples from its middle."""
    seen = shot(tab, ".stage", stage)
    height, width, _ = seen.shape
    return [
        seen[int(height / 2 + y * scale(tab)), int(width / 2 + x * scale(tab))].tolist() for x, y in where
    ]


def until(tab: Any, condition: str) -> None:
    """Wait: the page's policy lets nobody evaluate text within it, as Playwright's own waiting does."""
    deadline = time.monotonic() + 10
    while not tab.evaluate(condition):
        assert time.monotonic() < deadline, condition
        tab.wait_for_timeout(20)


def press(tab: Any, *keys: str) -> None:
    for key in keys:
        tab.keyboard.press(key)


# ---------------------------------------------------------------- what is shown


def test_a_fragment_opens_the_inspector_at_its_sample(visit: Any) -> None:
    tab = visit(fragment("boxes", "shifted", (20, 30)))
    assert chosen(tab) == ["two-up", "faces", "none", "reference", "shifted"]
    assert text(tab, "position") == "column 30, row 20"
    tab.evaluate("location.hash = '#scene=cyclic&method=backface&x=1&y=2'")
    until(tab, "document.getElementById('position').textContent === 'column 1, row 2'")
    assert chosen(tab)[3:] == ["exact", "backface"]
    tab.evaluate("location.hash = '#scene=nowhere'")
    until(tab, "document.getElementById('lost').textContent.includes('no scene named nowhere')")


def test_the_address_follows_the_sample(visit: Any) -> None:
    tab = visit(fragment("boxes", "shifted", (20, 30)))
    press(tab, "ArrowRight", "3")
    until(tab, "location.hash === '#scene=boxes&method=equal&x=31&y=20'")
    press(tab, "Escape")
    assert not tab.locator("#inspector").is_visible() and tab.evaluate("location.hash") == ""


def test_another_scene_may_open_before_the_address_has_followed(visit: Any) -> None:
    tab = visit(fragment("boxes", "shifted", (20, 30)))
    tab.evaluate(  # unpacking takes longer than the address takes to follow
        """() => {
          const Inflate = DecompressionStream;
          window.DecompressionStream = function (kind) {
            const made = new Inflate(kind);
            const late = new TransformStream({ start: () => new Promise((done) => setTimeout(done, 400)) });
            return { writable: made.writable, readable: made.readable.pipeThrough(late) };
          };
        }"""
    )
    press(tab, "ArrowRight")
    tab.evaluate("location.hash = '#scene=cyclic&method=backface&x=1&y=2'")
    until(tab, "document.getElementById('position').textContent === 'column 1, row 2'")


def test_the_panel_says_what_explain_says(visit: Any, real: Study, capsys: Any, scenes: Path) -> None:
    tab = visit("#scene=cyclic&method=scanline-d16")
    samples = [
        difference.clusters[0].sample for difference in real.differences.values() if difference.clusters
    ]
    assert len(samples) == 2
    for row, column in [*samples, (samples[0][0] + 1, samples[0][1] + 1)]:
        press(tab, "g")
        tab.keyboard.type(f"{column}, {row}")
        press(tab, "Enter")
        assert text(tab, "position") == f"column {column}, row {row}"
        lines = tab.locator(
            "#story p, #story .line, #story .verdict, #story .missed li, #story .sentences li"
        )
        asked = [part for name in real.maps for part in ("-a", name)]
        command = ["explain", str(scenes / "cyclic.toml"), f"{column},{row}", "--size", "96x72", *asked]
        app(command, standalone_mode=False)
        told = [line.strip() for line in capsys.readouterr().out.splitlines() if line.strip()]
        assert lines.all_text_contents() == told


OBJECTS: dict[str, list[dict[str, Any]]] = {
    "planar": [{"shape": "cube"}],
    "curved": [{"shape": "sphere"}, {"shape": "cylinder", "transform": [{"translate": [0.7, 0.0, 0.3]}]}],
    "clipped": [{"shape": "cube", "transform": [{"scale": 4.2}]}, {"shape": "sphere"}],
    "tied": [{"shape": "square"}, {"shape": "square"}],
    "culled": [{"shape": "square", "transform": [{"rotate_y": 180.0}], "cull": "back"}, {"shape": "cube"}],
}


def test_the_viewer_tells_histories_of_every_kind(browser: Any, make_scene: Any, tmp_path: Path) -> None:
    methods = ["painter", "backface", "zbuffer", "scanline-d16"]
    studies = []
    for name, objects in OBJECTS.items():
        named = [{"name": f"{name}{k}"} | thing for k, thing in enumerate(objects)]
        scene = make_scene(named, near=1.2, far=5.5)
        found = study(scene, methods, "exact", (32, 24), name=name)
        truth, painted = found.maps["exact"], found.maps["painter"]
        moved = replace(painted, face=np.roll(painted.face, 2, axis=1), method="moved")
        maps, differences = found.maps | {"moved": moved}, {"moved": compare(moved, truth)}
        told = {"maps": maps, "differences": differences | found.differences, "causes": {}}
        studies.append(replace(found, agreement=np.zeros((6, 6), np.int64), **told))
    write_report(studies, tmp_path / "kinds.html", histories=None)
    tab = browser.new_page()
    seen = 0
    for found in studies:
        scene = scene_of((tmp_path / "kinds.html").read_text(encoding="utf-8"), studies.index(found))
        samples = unpack(scene["told"]).tolist()
        for sample in samples[:: max(len(samples) // 5, 1)]:
            row, column = divmod(sample, 32)
            tab.goto("about:blank")
            tab.goto((tmp_path / "kinds.html").as_uri() + fragment(found.name, "painter", (row, column)))
            ready(tab)
            known = hsr.history(found.view, list(found.maps.values()), x=column, y=row)
            lines = tab.locator(
                "#story p, #story .line, #story .verdict, #story .missed li, #story .sentences li"
            )
            words = [line.strip() for line in str(known).splitlines() if line.strip()]
            assert lines.all_text_contents() == words
            seen += 1
    tab.close()
    assert seen >= 25


def test_the_table_tells_what_every_method_shows(visit: Any, real: Study) -> None:
    row, column = real.differences["backface"].clusters[0].sample
    tab = visit(fragment("cyclic", "backface", (row, column)))
    cells = [line.split("\t") for line in tab.locator("#methods tr").all_inner_texts()]
    assert [line[0] for line in cells] == list(real.maps)
    assert [line[1] for line in cells] == [map.name_of(map.face[row, column]) for map in real.maps.values()]
    truth = real.maps["exact"].depth[row, column]
    shown = dict(zip(real.maps, (float(line[2].removeprefix("≈ ")) for line in cells), strict=True))
    assert shown["exact"] == pytest.approx(truth, rel=1e-3)
    assert shown["backface"] == pytest.approx(real.maps["backface"].depth[row, column], rel=1e-3)
    assert cells[0][3] == "wrong face, no depth test" and cells[-1][3] == "reference"


def test_a_sample_without_a_history_says_how_to_ask(visit: Any, real: Study, scenes: Path) -> None:
    tab = visit(fragment("cyclic", "backface", (0, 0)))
    assert "not in the page" in text(tab, "story")
    asked = " ".join(f"-a {name}" for name in real.maps)
    command = f"hsr explain {scenes / 'cyclic.toml'} 0,0 --size 96x72 {asked}"
    assert tab.locator("#story code").text_content() == command


def test_faces_have_the_colours_of_their_ids(visit: Any, studied: Study) -> None:
    tab = visit(fragment("boxes", "shifted", (0, 0)))
    press(tab, "f")
    places = [(-20.5, -14.5), (20.5, -2.5), (-31.5, 20.5), (-21.5, 0.5)]
    for stage, name in enumerate(("reference", "shifted")):
        faces = [studied.maps[name].face[int(24 + y), int(32 + x)] for x, y in places]
        expected = face_colours(np.array(faces)).tolist()
        assert pixels(tab, stage, *places) == expected
    assert pixels(tab, 0, places[3]) != pixels(tab, 1, places[3])


def test_depth_runs_from_light_to_dark_and_can_be_stretched(visit: Any) -> None:
    tab = visit(fragment("boxes", "equal", (24, 32)))
    ends = ((-9.5, 2.5), (9.5, 2.5))
    press(tab, "z")
    left, right, nothing = (pixel[0] for pixel in pixels(tab, 0, *ends, (-31.5, 20.5)))
    assert left > right > nothing == 0
    press(tab, "0", *["+"] * 8, "n")
    near, far = (pixel[0] for pixel in pixels(tab, 0, (-6.0, 2.5), (6.0, 2.5)))
    assert near > left and far < right
    assert "Light ≈ 5.39" in text(tab, "legend")
    press(tab, "n", "f")
    assert [pixel[0] for pixel in pixels(tab, 0, *ends)] == [left, right]


def test_class_and_cause_maps_have_the_colours_of_the_legend(visit: Any, real: Study) -> None:
    tab = visit("#scene=cyclic&method=scanline-d16")
    found = real.causes["scanline-d16"]
    for key, signs, words in (
        ("m", CLASS_COLOURS, f"W wrong face {real.differences['scanline-d16'].counts['wrong face']}"),
        ("c", CAUSE_COLOURS, f"D depth format {found.counts['depth format']}"),
    ):
        press(tab, key, "f")
        assert words in text(tab, "legend")
        colours = {tuple(colour) for colour in shot(tab, ".stage", 1).reshape(-1, 3).tolist()}
        name = SampleClass.WRONG_FACE if key == "m" else Cause.DEPTH_FORMAT
        assert signs[name.label] in colours


def test_an_unfinished_page_loads_itself_until_it_is_whole(
    browser: Any, studied: Study, tmp_path: Path
) -> None:
    path = tmp_path / "growing.html"
    write_report([studied], path, pending=["absent"])
    # Where motion is wanted the way to the heading may still be going on when the page is scrolled.
    tab = browser.new_page(viewport={"width": 800, "height": 600}, reduced_motion="reduce")
    tab.goto(path.as_uri() + "#made-with")
    place = "document.getElementById('overview').getBoundingClientRect().top"
    # In one step: the page may load itself again between two.
    before = tab.evaluate(f"() => {{ scrollTo({{ top: 900, behavior: 'instant' }}); return {place}; }}")
    write_report([studied], path)
    tab.wait_for_selector(".pending", state="detached", timeout=5000)
    until(tab, f"Math.abs({place} - {before}) < 1")
    assert before < 0
    tab.close()


# ---------------------------------------------------------------- keys


def test_keys_choose_methods(visit: Any) -> None:
    tab = visit(fragment("boxes", "shifted", (0, 0)))
    for keys, methods in (
        ("3", ["reference", "equal"]),
        ("Shift+Digit1", ["shifted", "equal"]),
        ("k", ["shifted", "reference"]),
        ("j", ["shifted", "equal"]),
        ("j", ["shifted", "equal"]),
        ("J", ["reference", "equal"]),
        ("K", ["shifted", "equal"]),
        ("9", ["shifted", "equal"]),
    ):
        press(tab, keys)
        assert chosen(tab)[3:] == methods, keys


def test_keys_choose_pictures_overlays_and_ways_to_compare(visit: Any) -> None:
    tab = visit(fragment("boxes", "shifted", (0, 0)))
    for key, kind in (("p", "picture"), ("z", "depth"), ("m", "classes"), ("c", "causes"), ("i", "faces")):
        before = tab.locator(".stage").nth(1).screenshot()
        press(tab, key)
        assert chosen(tab)[1] == kind
        assert tab.locator(".stage").nth(1).get_attribute("aria-label") == f"shifted: {kind}"
        assert tab.locator(".stage").nth(1).screenshot() != before, kind
    for overlay in ("facing", "depth complexity", "face size", "wireframe", "none"):
        before = tab.locator(".stage").first.screenshot()
        press(tab, "v")
        assert chosen(tab)[2] == overlay
        assert tab.locator(".stage").first.screenshot() != before, overlay
    for key, mode in (
        ("b", "blink"),
        ("s", "swipe"),
        ("o", "onion"),
        ("t", "two-up"),
        ("s", "swipe"),
        ("s", "two-up"),
    ):
        press(tab, key)
        assert chosen(tab)[0] == mode
        assert tab.locator(".stage").nth(1).is_visible() == (mode == "two-up")


def test_swipe_and_onion_share_the_picture(visit: Any) -> None:
    tab = visit(fragment("boxes", "shifted", (0, 0)))
    left, right = (
        (-21.5, 0.5),
        (19.0, -10.5),
    )  # the box begins 10 columns from the left, shifted 12; ends at 50, 52
    press(tab, "s")
    box, nothing = face_colours(np.array([4, -1])).tolist()
    assert pixels(tab, 0, left, right) == [box, box]
    press(tab, *[","] * 10)
    assert pixels(tab, 0, left, right) == [nothing, box]
    press(tab, *["."] * 20)
    assert pixels(tab, 0, left, right) == [box, nothing]
    press(tab, "o", *[","] * 10)
    (mixed,) = pixels(tab, 0, left)
    assert all(abs(mixed[k] - (box[k] + nothing[k]) / 2) <= 1 for k in range(3))


def test_blinking_goes_by_the_clock_and_by_hand(visit: Any) -> None:
    place = (-21.5, 0.5)
    calm = visit(fragment("boxes", "shifted", (0, 0)), reduced_motion="reduce")
    reference, method = (pixels(calm, side, place) for side in (0, 1))
    press(calm, "b")
    calm.wait_for_timeout(750)
    assert pixels(calm, 0, place) == reference
    press(calm, " ")
    assert pixels(calm, 0, place) == method
    tab = visit(fragment("boxes", "shifted", (0, 0)))
    press(tab, "b")
    seen = []
    for _ in range(30):
        seen += pixels(tab, 0, place)
        tab.wait_for_timeout(50)
    assert reference[0] in seen and method[0] in seen


def test_keys_move_and_zoom(visit: Any) -> None:
    tab = visit(fragment("boxes", "shifted", (24, 32)))
    press(tab, "ArrowRight", "ArrowDown", "Shift+ArrowLeft")
    assert text(tab, "position") == "column 23, row 25"
    press(tab, *["Shift+ArrowUp"] * 4)
    assert text(tab, "position") == "column 23, row 0"
    press(tab, "y")
    assert text(tab, "position") == "column 23, row 47 from the bottom"
    press(tab, "g")
    tab.keyboard.type("5,7")
    press(tab, "Enter", "y")
    assert text(tab, "position") == "column 5, row 40"
    fitted = scale(tab)
    press(tab, "+")
    assert scale(tab) == pytest.approx(1.5 * fitted, rel=0.01)
    press(tab, "-", "-")
    assert scale(tab) == pytest.approx(fitted / 1.5, rel=0.01)
    press(tab, "0")
    assert scale(tab) == 1.0
    press(tab, "f")
    assert scale(tab) == fitted


def test_brackets_walk_through_the_clusters(visit: Any, studied: Study) -> None:
    tab = visit(fragment("boxes", "shifted"))
    clusters = [
        f"column {column}, row {row}"
        for row, column in (cluster.sample for cluster in studied.differences["shifted"].clusters)
    ]
    assert text(tab, "position") == clusters[0] and chosen(tab)[1] == "classes"
    visited = []
    for key in ("]", "]", "["):
        press(tab, key)
        visited.append(text(tab, "position"))
    assert visited == [clusters[0], clusters[1], clusters[0]]


def test_where_only_ties_differ_one_with_a_history_is_shown(
    browser: Any, studied: Study, tmp_path: Path
) -> None:
    difference = studied.differences["shifted"]
    ties = np.where(difference.classes > 0, np.uint8(SampleClass.TIE), np.uint8(0))
    tied = replace(studied, differences={"shifted": replace(difference, classes=ties)})
    write_report([tied], tmp_path / "ties.html")
    tab = browser.new_page()
    tab.goto((tmp_path / "ties.html").as_uri() + fragment("boxes", "shifted"))
    ready(tab)
    assert "T tie" in text(tab, "legend") and text(tab, "story").startswith("column ")
    tab.close()


def test_every_link_and_picture_leads_to_a_history(browser: Any, real: Study, tmp_path: Path) -> None:
    alike = study(real.scene, ["zbuffer"], "exact", (48, 36), name="alike")
    write_report([real, alike], tmp_path / "few.html", histories=0)
    tab = browser.new_page()
    tab.goto((tmp_path / "few.html").as_uri())
    tab.evaluate("document.querySelectorAll('details').forEach(e => e.open = true)")
    led = tab.locator("a[href^='#scene='], .thumb").all()
    assert len(led) > 6
    tab.on("pageerror", lambda error: pytest.fail(str(error)))
    for link in led:
        link.click()
        ready(tab)
        until(tab, "document.getElementById('story').textContent.startsWith('column ')")
        press(tab, "Escape")
    tab.close()


def test_help_names_the_keys_and_closes(visit: Any) -> None:
    tab = visit(fragment("boxes", "shifted", (24, 32)))
    press(tab, "?")
    assert tab.locator("#help").is_visible()
    press(tab, "ArrowRight", "Escape")
    assert not tab.locator("#help").is_visible() and tab.locator("#inspector").is_visible()
    assert text(tab, "position") == "column 32, row 24"


def test_every_key_of_the_help_does_something() -> None:
    script = (Path(hsr.__file__).parent / "pages" / "viewer.js").read_text(encoding="utf-8")
    named = {key for keys, _ in HELP for key in keys.split() if len(key) == 1} - set("←↑→↓…19")
    handled = {a or b for a, b in re.findall(r'^    (?:"(.)"|(\w)): ', script, re.MULTILINE)}
    handled |= set(re.findall(r': "(\w)"[,} ]', script))
    assert named <= handled and len(named) > 15


# ---------------------------------------------------------------- hands and eyes


def test_the_pointer_reads_and_chooses_samples(visit: Any, studied: Study) -> None:
    tab = visit(fragment("boxes", "shifted", (0, 0)))
    box = tab.locator(".stage").nth(1).bounding_box()
    x = box["x"] + box["width"] / 2 + (20.5 - 32) * scale(tab)
    y = box["y"] + box["height"] / 2 + (30.5 - 24) * scale(tab)
    tab.mouse.move(x, y)
    assert text(tab, "hover") == f"column 20, row 30: {studied.view.manifest[0]['name']}.front"
    assert text(tab, "position") == "column 0, row 0"
    tab.mouse.click(x, y)
    assert text(tab, "position") == "column 20, row 30"
    before = pixels(tab, 1, (-20.5, -14.5), (12.5, 0.5))
    tab.mouse.move(x, y)
    tab.mouse.down()
    tab.mouse.move(x + 12 * scale(tab), y, steps=4)
    tab.mouse.up()
    assert text(tab, "position") == "column 20, row 30"
    assert pixels(tab, 1, (-20.5, -14.5), (12.5, 0.5)) != before
    fitted = scale(tab)
    tab.mouse.wheel(0, -200)
    tab.wait_for_timeout(50)
    assert scale(tab) > fitted


def test_two_fingers_zoom_about_what_lies_between_them(visit: Any) -> None:
    tab = visit(fragment("boxes", "shifted", (24, 32)), has_touch=True)
    box = tab.locator(".stage").nth(1).bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    fingers = tab.context.new_cdp_session(tab)

    def touch(kind: str, *points: tuple[float, float]) -> None:
        fingers.send(
            "Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y} for x, y in points]}
        )

    border = ((4.5, -0.6), (4.5, 0.4))  # of two faces, near the middle
    fitted, between = scale(tab), pixels(tab, 1, *border)
    assert between[0] != between[1]
    touch("touchStart", (x - 30, y))
    touch("touchStart", (x - 30, y), (x + 30, y))
    for apart in (40, 50, 60):
        touch("touchMove", (x - apart, y), (x + apart, y))
    touch("touchEnd")
    assert scale(tab) == pytest.approx(2.0 * fitted, rel=0.01)
    assert pixels(tab, 1, *border) == between
    assert text(tab, "position") == "column 32, row 24"  # no sample was chosen
    touch("touchStart", (x + 3.5 * scale(tab), y))
    touch("touchEnd")
    assert text(tab, "position") == "column 35, row 24"


def test_rows_of_the_table_choose_method_and_reference(visit: Any) -> None:
    tab = visit(fragment("boxes", "shifted", (24, 32)))
    tab.locator("#methods tr").nth(2).click()
    assert chosen(tab)[3:] == ["reference", "equal"]
    tab.locator("#methods tr").first.click(button="right")
    assert chosen(tab)[3:] == ["shifted", "equal"]


def test_control_and_arrows_walk_through_the_pictures(visit: Any) -> None:
    tab = visit(fragment("boxes", "shifted", (24, 32)))
    seen = []
    for key in ("ArrowRight", "ArrowRight", "ArrowLeft", "ArrowLeft", "ArrowLeft"):
        press(tab, f"Control+{key}")
        seen.append(chosen(tab)[1])
    assert seen == ["picture", "depth", "picture", "faces", "causes"]
    assert text(tab, "position") == "column 32, row 24"


def test_the_samples_around_are_drawn_with_edges(visit: Any, real: Study) -> None:
    tab = visit(fragment("cyclic", "backface", real.differences["backface"].clusters[0].sample))
    seen = []
    for side in ("left", "right"):
        around = shot(tab, f"#context-{side}")
        middle = len(around) // 2
        seen.append(around[middle + 4, middle + 4].tolist())
    row, column = real.differences["backface"].clusters[0].sample
    faces = [real.maps[name].face[row, column] for name in ("exact", "backface")]
    assert seen == face_colours(np.array(faces)).tolist()


def test_everything_is_reached_by_keyboard(visit: Any) -> None:
    tab = visit("")
    tab.locator(".thumb").first.focus()
    press(tab, "Enter")
    ready(tab)
    order = []
    for _ in range(22):
        press(tab, "Tab")
        order.append(tab.evaluate("(e => e.id || e.dataset.key || e.className)(document.activeElement)"))
    wanted = ["scene", "mode", "kind", "overlay", "go-to", "origin", "?", "Escape"]
    wanted += ["method-left", "stage", "method-right", "stage", "panel", "[", "]", "-", "+", "f", "0"]
    assert order[: len(wanted)] == wanted


def test_buttons_and_lists_do_what_keys_do(visit: Any) -> None:
    tab = visit(fragment("boxes", "shifted", (24, 32)))
    fitted = scale(tab)
    tab.locator("[data-key='+']").click()
    assert scale(tab) == pytest.approx(1.5 * fitted, rel=0.01)
    tab.locator("#kind").select_option("depth")
    tab.locator("#overlay").select_option("facing")
    tab.locator("#mode").select_option("swipe")
    tab.locator("#method-right").select_option(label="3 equal")
    assert chosen(tab) == ["swipe", "depth", "facing", "reference", "equal"]
    tab.locator("#scene").select_option(label="cyclic")
    until(tab, "document.getElementById('method-left').selectedOptions[0].text.includes('exact')")


def test_everything_has_a_name_for_a_screen_reader(visit: Any) -> None:
    tab = visit(fragment("boxes", "shifted", (24, 32)))
    controls = tab.locator("#inspector :is(button, select, input, [role=img], [tabindex='0'])").all()
    assert len(controls) > 20
    nameless = [
        control.evaluate("e => e.outerHTML.slice(0, 80)")
        for control in controls
        if not control.evaluate(
            "e => e.ariaLabel || (e.labels ? e.labels.length || e.matches('button') : e.textContent.trim())"
        )
    ]
    assert nameless == []


@pytest.mark.parametrize("width", [360, 1200, 3840])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_inspector_fits_its_window(visit: Any, width: int, scheme: str) -> None:
    size = {"width": width, "height": max(740, width * 9 // 16)}
    tab = visit("#scene=cyclic&method=backface", viewport=size, color_scheme=scheme)
    assert tab.evaluate("document.getElementById('inspector').scrollWidth") <= width
    stages = [tab.locator(".stage").nth(k).bounding_box() for k in (0, 1)]
    assert all(box["width"] > 0.3 * width and box["height"] > 200 for box in stages)
    assert tab.evaluate("parseFloat(getComputedStyle(document.documentElement).fontSize)") >= (
        36 if width > 3000 else 16
    )
    ink, paper = tab.evaluate(
        "(s => [s.color, s.backgroundColor])(getComputedStyle(document.getElementById('inspector')))"
    )
    assert (sum(channels(ink)) > sum(channels(paper))) == (scheme == "dark")


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
