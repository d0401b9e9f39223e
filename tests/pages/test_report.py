"""The report as a file: whole, self-contained, small, and written all or not at all."""

from __future__ import annotations

import html
import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hsr.base.errors import HsrError
from hsr.base.store import Store
from hsr.difference.cause import Causes
from hsr.difference.study import RECALLED, Study
from hsr.models.stages import Cause
from hsr.pages import report
from hsr.pages.inspector import fragment, inspection
from hsr.pages.report import _extent, _figures, _milliseconds, _note, write_report
from hsr.pages.shading import shade
from tests.pages.policies import assert_strict
from tests.pages.unpacking import scene_of, stories_of
from tests.pictures.test_png import decoded

VOID = {"meta", "br", "img", "link", "hr", "input"}


class Balanced(HTMLParser):
    """Checks that every element that is opened is closed, in order."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.data: dict[str, str] = {}
        self.feed(page)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        if tag not in VOID:
            self.open.append(tag)
        self.ids += [value for key, value in attributes if key == "id" and value]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "script":
            self.data[f"script {len(self.data)}"] = data


def test_page_is_well_formed_and_alone(page: str) -> None:
    parsed = Balanced(page)
    assert len(parsed.ids) == len(set(parsed.ids))
    assert not re.search(r"(?:src|href)=[\"'](?!#|data:)", page)
    assert not re.search(r"url\(|@import|fetch\(|XMLHttpRequest", page)
    assert not re.search(r"https?://", page)


def test_page_tells_what_there_is_to_tell(page: str) -> None:
    for words in (
        "Two boxes &amp; a &lt;wall&gt;",
        "Row 0 is the top row",
        "wrong face",
        "needs a driver",
        "box.front",
        "a painted driver 1.0",
    ):
        assert words in page, words
    assert "<wall>" not in page


def test_only_the_page_s_own_script_and_style_are_allowed(page: str) -> None:
    assert_strict(page)


def test_nothing_is_read_back_from_a_canvas(page: str) -> None:
    assert not re.search(r"getImageData|toDataURL|toBlob|convertToBlob", page)


def test_fragments_name_a_sample() -> None:
    assert fragment("teapot", "opengl", (204, 311)) == "#scene=teapot&method=opengl&x=311&y=204"
    assert fragment("a b", "opengl") == "#scene=a+b&method=opengl"


def test_clusters_and_counts_lead_to_the_inspector(page: str, studied: Study) -> None:
    links = re.findall(r'href="(#scene=[^"]*)"', html.unescape(page))
    clusters = [
        fragment("boxes", "shifted", found.sample) for found in studied.differences["shifted"].clusters
    ]
    assert links == [fragment("boxes", "shifted"), *clusters]


def test_methods_that_agree_are_named_and_the_others_shown(page: str, studied: Study) -> None:
    assert "The same faces as reference at every sample: equal." in page
    sources = re.findall(r'data-method="([^"]*)"><img[^>]* src="([^"]*)"', page)
    assert [method for method, _ in sources] == ["reference", "shifted"]
    shaded, small = (decoded(source) for _, source in sources)
    assert np.array_equal(shaded[..., :3], shade(studied.maps["reference"], studied.view))
    assert np.array_equal(small, studied.differences["shifted"].picture())


def test_a_study_s_data_stand_in_its_page(page: str, studied: Study) -> None:
    assert scene_of(page) == json.loads(json.dumps(inspection(studied)))


def test_a_study_without_a_reference(studied_alone: Study, tmp_path: Path) -> None:
    write_report([studied_alone], tmp_path / "r.html")
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "No reference" in page and "not compared" in page
    Balanced(page)


def test_causes_are_summed_over_scenes(studied: Study, tmp_path: Path) -> None:
    cause = np.full((48, 64), Cause.TESSELLATION, np.uint8)
    cause[0, :2] = Cause.VERTEX_SNAPPING, Cause.UNEXPLAINED
    known = replace(studied, causes={"shifted": Causes("shifted", cause, True)})
    write_report([known, known], tmp_path / "causes.html")
    text = (tmp_path / "causes.html").read_text(encoding="utf-8")
    heads = re.findall(
        r"<th[^>]*>(?:<span[^>]*></span>)?([^<]*)</th>", text[text.index("Why samples are wrong") :]
    )
    assert heads[:6] == ["method", "wrong", "tessellation", "vertex snapping", "unexplained", "shifted"]
    figures = re.findall(r"<td[^>]*>([^<]*)</td>", text[text.index("Why samples are wrong") :])
    assert figures[:4] == ["6,144", "6,140", "2", "2"]
    assert "<b>shifted</b>: tessellation 3,070, vertex snapping 1, unexplained 1" in text


def test_pictures_come_before_tables_with_the_sentence_that_matters(studied: Study, tmp_path: Path) -> None:
    cause = np.where(studied.differences["shifted"].differs, Cause.NO_DEPTH_TEST, 0).astype(np.uint8)
    why = Causes("shifted", cause, True)
    write_report([replace(studied, causes={"shifted": why})], tmp_path / "r.html")
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    sentence = f"shifted: {why.wrong} of 3,072 wrong, all for want of a depth test."
    assert page.index("<img") < page.index(sentence) < page.index("<table")


@pytest.mark.parametrize(("flat", "red"), [(0, True), (100, True), (500, False)])
def test_counts_are_red_where_most_was_not_asked_for(
    studied: Study, tmp_path: Path, flat: int, red: bool
) -> None:
    cause = np.zeros((48, 64), np.uint8)
    cause.ravel()[:400] = Cause.NO_DEPTH_TEST
    cause.ravel()[:flat] = Cause.TESSELLATION
    write_report([replace(studied, causes={"shifted": Causes("shifted", cause, True)})], tmp_path / "r.html")
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    cell = re.search(r'<td class="number([^"]*)"><a href="#scene=boxes.*?</td>', page, re.DOTALL)
    assert cell and (cell[1] == " differs") == red
    parts = re.findall(r'width="([^"]*)" height="1"', cell[0])
    assert sum(map(float, parts)) == pytest.approx(1.0, abs=0.01) and len(parts) == 1 + (0 < flat < 400)


def test_pages_of_one_folder_lead_to_each_other(studied: Study, tmp_path: Path) -> None:
    for name in ("lessons", "gallery"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "index.html").touch()
    for name in ("sample.html", "lab.html"):
        write_report([studied], tmp_path / name)
    page = (tmp_path / "lab.html").read_text(encoding="utf-8")
    links = re.findall(r'<a href="([^"#]*)"( aria-current="page")?>([^<]*)</a>', page)
    assert [name for _, _, name in links] == ["Report", "Sample report", "Scenes", "Lessons"]
    assert [bool(here) for _, here, _ in links] == [True, False, False, False]
    assert links[2][0] == "gallery/index.html"


def test_without_the_truth_there_are_no_causes(page: str) -> None:
    assert "Why samples are wrong" not in page


def test_several_scenes_share_one_page(studied: Study, studied_alone: Study, tmp_path: Path) -> None:
    write_report([studied, studied_alone, studied], tmp_path / "r.html", title="A < B")
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert {"scene-1", "scene-2", "scene-3"} <= set(Balanced(page).ids)
    assert "<h1>A &lt; B</h1>" in page and scene_of(page, 2)["name"] == "boxes"


def test_as_many_histories_as_are_asked_for(real: Study, tmp_path: Path) -> None:
    for asked in (0, 30, None):
        write_report([real], tmp_path / "r.html", histories=asked)
        told = scene_of((tmp_path / "r.html").read_text(encoding="utf-8"))
        linked = {cluster.sample for found in real.differences.values() for cluster in found.clusters[:10]}
        expected = told["wanted"] if asked is None else max(asked, len(linked))
        assert len(stories_of(told)) == expected


def test_nothing_to_report(studied: Study, tmp_path: Path) -> None:
    with pytest.raises(HsrError, match="no scenes"):
        write_report([], tmp_path / "r.html")
    with pytest.raises(HsrError, match="every method was skipped"):
        write_report([replace(studied, maps={})], tmp_path / "r.html")


def test_what_the_inspector_shows_is_kept(
    studied: Study, studied_alone: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store, asked = Store(tmp_path / "store"), []

    def gather(found: Study, histories: int | None) -> dict[str, Any]:
        asked.append((found.name, histories))
        return inspection(found, histories)

    monkeypatch.setattr(report, "inspection", gather)
    for histories in (4, 4, 5):
        write_report([studied], tmp_path / f"{histories}.html", histories=histories, store=store)
    write_report([studied_alone], tmp_path / "alone.html", histories=4, store=store)
    assert asked == [(studied.name, 4), (studied.name, 5), (studied_alone.name, 4)]


def test_times_that_were_not_measured_now_bear_a_star(studied: Study, tmp_path: Path) -> None:
    write_report([studied], tmp_path / "now.html")
    maps = {name: replace(map, notes=map.notes | {RECALLED: True}) for name, map in studied.maps.items()}
    write_report([replace(studied, maps=maps)], tmp_path / "then.html")
    now, then = ((tmp_path / f"{when}.html").read_text(encoding="utf-8") for when in ("now", "then"))
    starred = re.compile(r"[0-9]\*</td>")
    assert not starred.search(now) and len(starred.findall(then)) == 2 * len(maps)


def test_a_report_is_written_in_stages(studied: Study, tmp_path: Path) -> None:
    part = replace(studied, maps={"reference": studied.maps["reference"]}, differences={})
    texts = []
    for studies, pending in (([], ["reference", "shifted"]), ([part], ["shifted"]), ([studied], [])):
        write_report(studies, tmp_path / "r.html", pending=pending)
        texts.append((tmp_path / "r.html").read_text(encoding="utf-8"))
        Balanced(texts[-1])
        assert_strict(texts[-1])
    assert "Still to come: reference, shifted." in texts[0] and "Still to come: shifted." in texts[1]
    assert '<td class="number quiet">…</td>' in texts[1]
    assert ["reload()" in text for text in texts] == [True, True, False] and "Still to come" not in texts[2]


def test_a_report_is_replaced_whole_or_not_at_all(
    studied: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "r.html"
    target.write_text("before", encoding="utf-8")

    def full_disk(*_arguments: Any, **_options: Any) -> Any:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(Path, "write_bytes", full_disk)
        with pytest.raises(HsrError, match=r"r\.html: cannot write the report: No space left"):
            write_report([studied], target)
    assert target.read_text(encoding="utf-8") == "before" and list(tmp_path.iterdir()) == [target]
    write_report([studied], target)
    assert target.read_text(encoding="utf-8") != "before" and list(tmp_path.iterdir()) == [target]


def test_a_folder_that_is_not_there(studied: Study, tmp_path: Path) -> None:
    with pytest.raises(HsrError, match=r"none/r\.html: cannot write the report: No such file"):
        write_report([studied], tmp_path / "none/r.html")


@pytest.mark.parametrize(
    ("value", "text"), [(0.0, "0"), (1234.5, "1.23e+03"), (0.05, "0.05"), (float("inf"), "∞")]
)
def test_figures(value: float, text: str) -> None:
    assert _figures(value) == text


@pytest.mark.parametrize(("seconds", "text"), [(0.0, "0.0"), (0.0012345, "1.2"), (12.3456, "12,345.6")])
def test_milliseconds(seconds: float, text: str) -> None:
    assert _milliseconds(seconds) == text


@pytest.mark.parametrize(
    ("note", "text"),
    [(True, "yes"), (12345, "12,345"), (2.0**-24, "5.96e-08"), ("osmesa", "osmesa")],
)
def test_notes(note: Any, text: str) -> None:
    assert _note(note) == text
    assert _note({"step": note, "far": None}) == f"step {text}"


def test_extent() -> None:
    assert (_extent(4, 5), _extent(4, 8)) == ("4", "4–7")
