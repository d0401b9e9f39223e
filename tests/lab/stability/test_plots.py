"""Charts and summaries of results."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import pytest

from hsr.lab.stability.cases import family_named
from hsr.lab.stability.judge import Result, judge
from hsr.lab.stability.plots import chart, draw
from hsr.lab.stability.summary import headline, markdown, matrix, table


@pytest.fixture(scope="module")
def result() -> Result:
    return judge(family_named("integer-overflow"), quick=True, asked=("zbuffer", "int32", "int64"))


def test_a_chart_is_the_same_each_time(result: Result) -> None:
    first = chart(result)
    assert first == chart(result) and "<dc:date>" not in first
    assert ElementTree.fromstring(first).tag.endswith("svg")
    for told in ("int32", "zbuffer (certified)", "distance of the corners, in pixels"):
        assert told in first


def test_a_chart_shows_what_was_measured_and_predicted(result: Result) -> None:
    (axes,) = draw(result).axes
    lines = {line.get_label(): line for line in axes.lines}
    assert list(lines["zbuffer (certified)"].get_ydata()) == [0.0, 0.0, 0.0]
    int32 = result.rows[1]
    assert list(lines["int32"].get_ydata()) == [point.wrong for point in int32.points]
    assert int32.predicted in [line.get_xdata()[0] for line in axes.lines]


@pytest.mark.parametrize("name", ["behind-the-eye", "slab-degeneracies", "needle"])
def test_signs_zeros_and_descent_have_a_place(name: str) -> None:
    family = family_named(name)
    (axes,) = draw(judge(family, quick=True, asked=("zbuffer",))).axes
    left, right = axes.get_xlim()
    assert (left < right) == family.ascending
    assert min(left, right) <= min(family.values(True)) and max(left, right) >= max(family.values(True))


def test_summaries(result: Result) -> None:
    told = headline(matrix([result])["families"])
    assert told.startswith("1 family, 3 rows: 2 holds, 1 breaks as predicted")
    assert "certified methods: 0 wrong samples; 0 unexplained of 0 traced" in told
    head, (family, _, int32, _), _, _ = table([result])
    row = dict(zip(head, int32, strict=True))
    assert family == ("integer-overflow",) and row["variant"] == "  int32"
    assert row["mostly by"] == "planted mistake" and row["predicted"] == "37"
    head, _, line = markdown(matrix([result])["families"]).splitlines()
    assert head.count("|") == line.count("|")
    assert "| int32 | first wrong face: distance of the corners, in pixels |" in line
    assert "| `sqrt(2^31 / 24) / 2^8 px` | 37 |" in line
