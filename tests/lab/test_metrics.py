"""Metrics declared once, and who dominates whom."""

from __future__ import annotations

import pytest

from hsr.lab.metrics import ERROR, METRICS, SPEED, dominators, written
from tests.lab.made_up import row


def test_titles_differ_and_name_units() -> None:
    titles = [metric.title for metric in METRICS]
    assert len(set(titles)) == len(titles)
    assert SPEED.title == "render [ms]" and ERROR.title == "wrong"


def test_figures_of_a_row() -> None:
    made = row("zbuffer", [0.002] * 3, wrong=1234, peak_bytes=2_500_000)
    figures = {metric.title: metric.of(made) for metric in METRICS}
    assert (figures["render [ms]"], figures["wrong"], figures["ties"], figures["peak [MB]"]) == (
        2.0,
        1234,
        1,
        2.5,
    )
    assert ERROR.text(made) == "1,234"
    assert all(metric.of(row("lame", absent="cannot")) is None for metric in METRICS)


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (0.01234, "0.0123"), (1.5, "1.5"), (99.94, "99.9"), (1234.5, "1,234"), (3.9e13, "3.9e+13")],
)
def test_numbers_as_people_read_them(value: float, text: str) -> None:
    assert written(value) == text


def test_ranks() -> None:
    rows = [
        row("fast", [0.001] * 3, wrong=9),
        row("right", [0.004] * 3, wrong=0),
        row("between", [0.002] * 3, wrong=9),
        row("bad", [0.005] * 3, wrong=9),
        row("twin", [0.001] * 3, wrong=9),
        row("gone", absent="cannot"),
    ]
    found = {name.rpartition("/")[2]: better for name, better in dominators(rows).items()}
    assert found == {
        "fast": [],
        "twin": [],  # as good in both: neither dominates the other
        "right": [],
        "between": ["fast", "twin"],
        "bad": ["fast", "twin", "between", "right"],
    }
