"""What a run publishes: tables, CSV and pictures."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from hsr.base.errors import HsrError
from hsr.lab.metrics import METRICS
from hsr.lab.publish import (
    conditions,
    make_folder,
    panels,
    publish,
    table,
    to_csv,
    to_markdown,
    to_svg,
)
from hsr.lab.results import load_results
from hsr.lab.tables import Table
from tests.lab.made_up import results, row

RUN = results(
    row("opengl", [0.004, 0.005, 0.006], wrong=30, threads=1, driver="a pen"),
    row("zbuffer", [0.001, 0.002, 0.003]),
    row("embree", absent="needs <embreex> & more"),
)


def test_the_best_come_first_and_the_absent_last() -> None:
    head, rows, _, _ = table(RUN.rows)
    lines = [dict(zip(head, cells, strict=True)) for cells in rows]
    assert [(line["rank"], line["method"]) for line in lines] == [
        ("1", "zbuffer"),
        ("2", "opengl"),
        ("", "embree"),
    ]
    assert lines[1]["dominated by"] == "zbuffer" and lines[1]["why"] == "vertex snapping 30"
    assert lines[1]["render [ms]"] == "5" and lines[1]["wrong"] == "30" and lines[1]["build [ms]"] == ""
    assert lines[2]["why"] == "needs <embreex> & more"


def test_many_dominators_are_counted() -> None:
    rows = [row(f"m{k}", [0.001 * (k + 1)] * 3) for k in range(5)]
    assert [cells[-1] for cells in table(rows).rows] == [
        "",
        "m0",
        "m0, m1",
        "m0, m1 and 1 more",
        "m0, m1 and 2 more",
    ]


def test_csv_has_a_line_a_row_and_every_metric() -> None:
    lines = list(csv.DictReader(io.StringIO(to_csv(RUN))))
    assert [line["id"] for line in lines] == [made.id for made in RUN.rows]
    assert {metric.title for metric in METRICS} <= lines[0].keys()
    assert lines[0]["render [ms]"] == "5.0" and lines[0]["rank"] == "2"
    assert (
        lines[2]["absent"] == "needs <embreex> & more" and lines[2]["render [ms]"] == lines[2]["rank"] == ""
    )


def test_markdown_tables() -> None:
    assert Table(("a", "b"), [("x|y", "1")], ("b",)).markdown() == "| a | b |\n|---|---:|\n| x\\|y | 1 |"
    assert "**box, 12 triangles, 64x64**" in to_markdown(RUN)


def test_conditions_tell_what_makes_times_doubtful() -> None:
    told = conditions(RUN)
    assert "2 threads of 2 processors (Slide Rule), 2026-01-02, commit abc1234" in told
    assert "a pen" in told and "One thread only: opengl." in told
    assert "up to 0.00 processors busy" in told


def test_every_mark_is_a_row() -> None:
    (panel,) = panels(RUN)
    assert [mark.label for mark in panel.marks] == [made.method for made in RUN.rows if not made.absent]
    assert [mark.frontier for mark in panel.marks] == [False, True]
    assert panel.notes == ["embree: needs <embreex> & more"]


def test_the_picture_is_svg_and_always_the_same() -> None:
    text = to_svg(RUN)
    assert ElementTree.fromstring(text).tag.endswith("svg")
    assert text == to_svg(RUN) and not re.search(r"\d{4}-\d{2}-\d{2}T", text)


def test_a_mark_tells_its_row_to_who_points_at_it() -> None:
    drawn = ElementTree.fromstring(to_svg(RUN))
    titles = [title.text for title in drawn.iter("{http://www.w3.org/2000/svg}title")]
    assert titles == [mark.about for mark in panels(RUN)[0].marks]
    for told in ("box/64x64/scene/opengl", "render [ms]: 5", "wrong: 30", "why: vertex snapping 30"):
        assert told in titles[0].splitlines()


def test_all_is_written_under_one_name(tmp_path: Path) -> None:
    files = publish(RUN, tmp_path / "new")
    stem = "speed-slide-rule-2-abc1234"
    assert [file.name for file in files] == [f"{stem}.{ending}" for ending in ("json", "csv", "md", "svg")]
    assert load_results(files[0]) == RUN
    growing = results(*(row("zbuffer", scene=f"copies-{n}", series="copies") for n in (1, 4, 16)))
    assert [file.suffix for file in publish(growing, tmp_path)] == [".json", ".csv", ".md", ".svg"]


def test_a_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for folder in (tmp_path / "file", tmp_path / "no" / "such"):
        with pytest.raises(HsrError, match=r"cannot write results there: .*; choose another -o"):
            make_folder(folder)


def test_a_run_without_figures_can_be_published(tmp_path: Path) -> None:
    assert len(publish(results(row("embree", absent="missing")), tmp_path)) == 4
