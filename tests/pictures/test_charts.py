"""Charts: where labels stand, what the axes show."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from hsr.pictures.charts import (
    LETTER,
    LINE,
    PANEL,
    Curve,
    Growth,
    Mark,
    Panel,
    Span,
    growth_svg,
    place_labels,
    speed_svg,
)


def mark(x: float, y: float, frontier: bool = False, label: str = "zbuffer") -> Mark:
    return Mark(label, "zbuffer", x, y, 0.9 * y, 1.1 * y, frontier)


@pytest.mark.parametrize("seed", range(5))
def test_labels_overlap_neither_each_other_nor_marks(seed: int) -> None:
    """Eighteen marks on three heaps, as methods of one family are."""
    rng = np.random.default_rng(seed)
    heaps = np.repeat([[20.0, 40.0], [120.0, 60.0], [22.0, 150.0]], 6, axis=0)
    marks = heaps + rng.uniform(0.0, 15.0, (18, 2))
    labels = [f"zbuffer-float32-{k}" for k in range(18)]
    places = place_labels(marks, labels)
    boxes = [
        (x, y - LINE / 2, x + LETTER * len(label), y + LINE / 2)
        for (x, y), label in zip(places, labels, strict=True)
    ]
    for a, b in itertools.combinations(boxes, 2):
        assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
    for left, bottom, right, top in boxes:
        assert bottom >= 0.0 and top <= PANEL[1]
        inside = (marks[:, 0] > left) & (marks[:, 0] < right) & (marks[:, 1] > bottom) & (marks[:, 1] < top)
        assert not inside.any()


def test_labels_of_a_heap_stand_in_the_order_of_their_marks() -> None:
    marks = np.array([[20.0, 50.0], [20.0, 51.0], [20.0, 52.0], [20.0, 49.0]])
    places = place_labels(marks, ["a", "b", "c", "d"])
    assert np.argsort(places[:, 1]).tolist() == [3, 0, 1, 2]
    assert places[3, 1] == 49.0, "the lowest stands at its mark"


def test_labels_keep_clear_of_lines() -> None:
    (place,) = place_labels(np.array([[20.0, 50.0]]), ["a"], [(20.0, 49.0, 380.0, 51.0)])
    assert place[1] - LINE / 2 >= 51.0


def test_zero_has_a_place() -> None:
    span = Span.of([Panel("", [mark(0.0, 1.0), mark(5000.0, 10.0)])])
    assert span.LEFT < 0.0 and span.right > 5000.0 and span.bottom < 0.9 and span.top > 11.0


def test_ticks() -> None:
    span = Span(right=12_000.0, bottom=0.3, top=30.0)
    assert span.error_ticks() == [0.0, 1.0, 10.0, 100.0, 1e3, 1e4]
    assert span.time_ticks() == [0.5, 1.0, 2.0, 5.0, 10.0, 20.0]
    assert Span(1.0, 0.3, 3000.0).time_ticks() == [1.0, 10.0, 100.0, 1000.0]


def test_a_panel_may_be_empty() -> None:
    assert "<svg" in speed_svg([Panel("nothing", [], ["embree: missing"])], "wrong", "time")


def test_growth_is_drawn_for_one_point_or_many() -> None:
    curves = [
        Curve(
            "zbuffer",
            "zbuffer",
            [1.0, 4.0, 16.0],
            [1.0, 2.0, 4.0],
            [0.9, 1.9, 3.9],
            [1.1, 2.1, 4.1],
            [1.0, 2.0, 4.0],
        ),
        Curve("raycast-list", "raycast", [1.0], [3.0], [2.0], [4.0]),
    ]
    series = [Growth(f"more {k}", "copies", curves) for k in range(4)]
    assert growth_svg(series, "time [ms]") == growth_svg(series, "time [ms]")
