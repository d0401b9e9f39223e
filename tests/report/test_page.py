"""The report as a file: whole, self-contained, small, and written all or not at all."""

from __future__ import annotations

import base64
import io
import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from hsr.difference.cause import Causes
from hsr.difference.models.stages import Cause
from hsr.difference.study import Study
from hsr.errors import HsrError
from hsr.report.page import _extent, _figures, _milliseconds, _note, write_report
from hsr.report.pictures import Album, png

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


def lab_of(page: str) -> Any:
    return json.loads(Balanced(page).data["script 0"])


def test_page_is_well_formed_and_alone(page: str) -> None:
    parsed = Balanced(page)
    assert len(parsed.ids) == len(set(parsed.ids))
    assert "default-src 'none'" in page and "img-src data:" in page
    assert not re.search(r"(?:src|href)=[\"'](?!#|data:)", page)
    assert not re.search(r"url\(|@import|fetch\(|XMLHttpRequest", page)
    assert re.findall(r"https?://[^\s\"'<]+", page) == ["http://www.w3.org/2000/svg"]


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


def test_pictures_are_those_of_the_maps(page: str, studied: Study) -> None:
    lab = lab_of(page)
    (scene,) = lab["scenes"]
    assert [method["name"] for method in scene["methods"]] == list(studied.maps)
    for kind in ("faces", "depth"):
        base = stacked(lab, scene["methods"][scene["reference"]]["layers"][kind])
        for method in scene["methods"]:
            whole = stacked(lab, method["layers"][kind])
            same = studied.maps[method["name"]].face == studied.maps["reference"].face
            assert (whole[..., 3] == 255).all()
            if kind == "faces":
                assert np.array_equal((whole == base).all(axis=2), same)


def test_class_pictures_show_exactly_what_differs(page: str, studied: Study) -> None:
    lab = lab_of(page)
    for method in lab["scenes"][0]["methods"]:
        found = studied.differences.get(method["name"])
        if found is None:
            assert "difference" not in method["layers"]
            continue
        (_, faint), (classes, _) = method["layers"]["difference"]
        assert faint < 1.0
        assert np.array_equal(decoded(lab["pictures"][classes])[..., 3] > 0, found.classes > 0)
        assert method["boxes"] == [list(cluster.box) for cluster in found.clusters]


def decoded(uri: str) -> Any:
    with Image.open(io.BytesIO(base64.b64decode(uri.removeprefix("data:image/png;base64,")))) as image:
        return np.asarray(image.convert("RGBA"))


def stacked(lab: Any, layers: list[list[float]]) -> Any:
    """Lay opaque pixels over each other, from the bottom up."""
    whole: Any = 0
    for place, _ in layers:
        picture = decoded(lab["pictures"][int(place)])
        whole = np.where(picture[..., 3:] > 0, picture, whole)
    return whole


def test_equal_pictures_are_kept_once() -> None:
    album, picture = Album(), np.full((4, 4, 4), 255, np.uint8)
    assert album.add(picture) == album.add(picture.copy()) == 0
    picture[0, 0] = 0
    assert album.add(picture) == 1 and len(album.uris) == 2


@pytest.mark.parametrize("colours", [1, 2, 256, 257])
def test_png_keeps_every_pixel(colours: int) -> None:
    value = np.arange(32 * 32) % colours
    opacity = np.where(value % 3 == 0, 0, 255)
    pixels = np.stack([value % 256, value // 256, 255 - value % 256, opacity], axis=1)
    pixels = pixels.reshape(32, 32, 4).astype(np.uint8)
    data = png(pixels)
    with Image.open(io.BytesIO(data)) as image:
        assert (image.mode == "P") == (colours <= 256)
        assert np.array_equal(np.asarray(image.convert("RGBA")), pixels)


def test_a_study_without_a_reference(studied_alone: Study, tmp_path: Path) -> None:
    write_report([studied_alone], tmp_path / "r.html")
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "No reference" in page and "not compared" in page
    Balanced(page)


def test_causes_are_summed_over_scenes(studied: Study, tmp_path: Path) -> None:
    cause = np.zeros((2, 4), np.uint8)
    cause[0, :3] = Cause.VERTEX_SNAPPING, Cause.UNEXPLAINED, Cause.TESSELLATION
    known = replace(studied, causes={"shifted": Causes("shifted", cause, True)})
    write_report([known, known], tmp_path / "causes.html")
    text = (tmp_path / "causes.html").read_text(encoding="utf-8")
    heads = re.findall(r"<th[^>]*>([^<]*)</th>", text[text.index("Why samples are wrong") :])
    assert heads[:6] == ["method", "wrong", "tessellation", "vertex snapping", "unexplained", "shifted"]
    figures = re.findall(r"<td[^>]*>([^<]*)</td>", text[text.index("Why samples are wrong") :])
    assert figures[:4] == ["6", "2", "2", "2"]
    assert "<b>shifted</b>: tessellation 1, vertex snapping 1, unexplained 1" in text


def test_without_the_truth_there_are_no_causes(page: str) -> None:
    assert "Why samples are wrong" not in page


def test_several_scenes_share_one_page(studied: Study, studied_alone: Study, tmp_path: Path) -> None:
    write_report([studied, studied_alone, studied], tmp_path / "r.html", title="A < B")
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert {"scene-1", "scene-2", "scene-3"} <= set(Balanced(page).ids)
    assert "<h1>A &lt; B</h1>" in page and len(lab_of(page)["scenes"]) == 3


def test_nothing_to_report(studied: Study, tmp_path: Path) -> None:
    with pytest.raises(HsrError, match="no scenes"):
        write_report([], tmp_path / "r.html")
    with pytest.raises(HsrError, match="every method was skipped"):
        write_report([replace(studied, maps={})], tmp_path / "r.html")


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
