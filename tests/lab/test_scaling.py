"""How times grow: made-up times that follow a law, and the scenes."""

from __future__ import annotations

import math

import pytest

from hsr.lab.scaling import (
    SERIES,
    crossovers,
    exponent,
    fitted,
    growth,
    law_of,
    measured_cases,
    sentences,
    size_of,
    table,
)
from hsr.pictures.charts import Curve
from tests.lab.made_up import results, row

SIZES = [10.0**k for k in range(2, 7)]


def curve(label: str, y: list[float], blur: float = 0.01) -> Curve:
    low, high = [t * (1.0 - blur) for t in y], [t * (1.0 + blur) for t in y]
    return Curve(label, label.partition("-")[0], SIZES[: len(y)], y, low, high)


def test_exponents() -> None:
    value, low, high = exponent(SIZES, [3.0 * x**0.7 for x in SIZES])
    assert value == pytest.approx(0.7) and high - low < 1e-6
    _, low, high = exponent(
        SIZES, [x**0.7 * f for x, f in zip(SIZES, (1.0, 1.2, 0.9, 1.1, 1.0), strict=True)]
    )
    assert low < 0.7 < high and high - low > 0.02
    assert exponent(SIZES[:2], [1.0, 2.0]) is None


@pytest.mark.parametrize(
    ("law", "time"),
    [
        ("c x", lambda x: 3e-4 * x),
        ("a + b x", lambda x: 0.5 + 3e-4 * x),
        ("a + b log x", lambda x: 0.5 + 2.0 * math.log(x)),
    ],
)
def test_laws_find_their_constants(law: str, time: object) -> None:
    y = [time(x) for x in SIZES]  # type: ignore[operator]
    assert fitted(law, SIZES, y) == pytest.approx(y)
    others = {"c x", "a + b x", "a + b log x"} - {law}
    assert any(fitted(other, SIZES, y) != pytest.approx(y, rel=0.1) for other in others)


def test_what_theory_says_of_whom() -> None:
    assert law_of("raycast-list", "triangles") == "c x"
    assert law_of("raycast", "triangles") == "a + b log x" == law_of("embree", "copies")
    assert (
        law_of("raycast", "pixels")
        == law_of("zbuffer", "triangles")
        == law_of("opengl", "layers")
        == "a + b x"
    )
    assert law_of("exact", "triangles") is None


def test_a_crossover_is_where_the_times_meet() -> None:
    buffer = curve("zbuffer", [0.1 + 1e-4 * x for x in SIZES])
    rays = curve("raycast", [2.0] * 5)
    (found,) = crossovers([buffer, rays])
    assert (found.winner, found.loser) == ("raycast", "zbuffer")
    assert (found.below, found.above) == (pytest.approx(1e4), pytest.approx(1e5))
    assert found.at == pytest.approx(1.9e4, rel=0.2)
    assert found.sentence("triangles").startswith("From about ")
    assert "raycast is faster than zbuffer (measured at 10,000 and 100,000)." in found.sentence("triangles")


def test_no_crossover_within_the_noise_nor_within_a_family() -> None:
    flat, tilted = [1.0] * 5, [0.9, 0.95, 1.0, 1.05, 1.1]
    assert len(crossovers([curve("zbuffer", tilted), curve("raycast", flat)])) == 1
    assert crossovers([curve("zbuffer", tilted, blur=0.2), curve("raycast", flat)]) == []
    begins_alike, ends_alike = [0.99, 0.9, 1.2, 1.5, 2.0], [0.5, 0.6, 0.8, 0.9, 1.01]
    assert crossovers([curve("zbuffer", begins_alike, blur=0.05), curve("raycast", flat)]) == []
    assert crossovers([curve("zbuffer", ends_alike, blur=0.05), curve("raycast", flat)]) == []
    assert crossovers([curve("raycast-single", tilted), curve("raycast", flat)]) == []
    assert crossovers([curve("zbuffer", tilted), curve("raycast", [2.0] * 5)]) == []


def test_curves_come_from_the_rows() -> None:
    rows = [row("zbuffer", [1e-6 * n] * 3, scene=f"copies-{n}", series="copies") for n in (1, 4, 16)] + [
        row("lame", scene="copies-1", series="copies", absent="cannot")
    ]
    (found,) = growth(results(*rows))
    (line,) = found.curves
    assert (line.label, line.x, line.y) == ("zbuffer", [1.0, 4.0, 16.0], [0.001, 0.004, 0.016])
    assert line.theory == pytest.approx(line.y)
    assert table([found]).rows[0][:5] == ("copies", "zbuffer", "x^1.00 (1.00 to 1.00)", "a + b x", "0%")
    assert sentences([found]) == ["At 16 copies the fastest are zbuffer 0.016 ms."]


def test_every_series_grows_as_its_name_says() -> None:
    cases = measured_cases(quick=True)
    assert {case.series for case in cases} == {series.name for series in SERIES}
    assert len({case.scene for case in cases}) == len(cases)
    triangles = {case.scene: len(case.view.polygons.triangle_face) for case in cases}
    for name, count in triangles.items():
        if name.startswith("triangles-"):
            assert count == pytest.approx(int(name.rpartition("-")[2]), rel=0.05)
        if name.startswith("layers-"):
            assert count == 2 * int(name.rpartition("-")[2])
    pixels = [case.view.width * case.view.height for case in cases if case.series == "pixels"]
    assert pixels == [4**5, 4**6, 4**7]
    assert size_of(row("a", scene="pixels-4096", series="pixels")) == 4096
    assert size_of(row("a", scene="triangles-100", series="triangles")) == 12, "as counted"


def test_full_sizes() -> None:
    sizes = {series.name: series.sizes for series in SERIES}
    assert (sizes["triangles"][0], sizes["triangles"][-1]) == (100, 1_000_000)
    assert (sizes["pixels"][0], sizes["pixels"][-1]) == (64**2, 4096**2)
