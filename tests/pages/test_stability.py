"""The page of the stability lab."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hsr.base.errors import HsrError
from hsr.lab.stability.cases import family_named
from hsr.lab.stability.judge import Result, judge
from hsr.pages.stability import write_folder


@pytest.fixture(scope="module")
def results() -> list[Result]:
    asked = {"integer-overflow": ("zbuffer", "int32"), "cyclic-overlap": ("zbuffer", "painter")}
    return [judge(family_named(name), True, names) for name, names in asked.items()]


def test_the_folder_holds_page_charts_and_figures(results: list[Result], tmp_path: Path) -> None:
    folder = tmp_path / "lab"
    written = write_folder(results, folder)
    names = {"index.html", "results.json", "matrix.json", "integer-overflow.svg", "cyclic-overlap.svg"}
    assert {path.name for path in written} == {path.name for path in folder.iterdir()} == names
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert page.count("<svg") == 2 and "http://www.w3.org" in page
    assert "src=" not in page and "<link" not in page and "<script" not in page  # offline, and plain
    for told in (
        "integer-overflow",
        "breaks as predicted",
        "Four bars lie each over the next",
        "no depth test",
    ):
        assert told in page
    families = json.loads((folder / "results.json").read_text(encoding="utf-8"))["families"]
    assert [family["family"] for family in families] == ["integer-overflow", "cyclic-overlap"]
    before = page
    write_folder(results, folder)
    assert (folder / "index.html").read_text(encoding="utf-8") == before


def test_a_folder_that_cannot_be_made_is_told(results: list[Result], tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(HsrError, match="taken: cannot make the folder"):
        write_folder(results, tmp_path / "taken")
