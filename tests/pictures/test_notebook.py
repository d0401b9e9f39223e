from __future__ import annotations

import re
from html.parser import HTMLParser

import pytest

from hsr.difference.study import Study
from tests.pictures.test_png import decoded


def test_a_map_shows_its_faces_and_figures(studied: Study) -> None:
    html = studied.maps["reference"]._repr_html_()
    picture = decoded(re.findall(r'src="([^"]*)"', html)[0])
    assert picture.shape == (48, 64, 4) and len({tuple(pixel) for pixel in picture.reshape(-1, 4)}) == 3
    assert "reference  64x48" in html and "2 faces on" in html


def test_a_difference_shows_where_and_how_much(studied: Study) -> None:
    difference = studied.differences["shifted"]
    html = difference._repr_html_()
    picture = decoded(re.findall(r'src="([^"]*)"', html)[0])
    assert ((picture[..., 3] == 255) == (difference.classes > 0)).all()
    assert str(difference) in html


@pytest.mark.parametrize("what", ["map", "difference"])
def test_nothing_is_taken_for_markup_and_nothing_is_fetched(what: str, studied: Study) -> None:
    shown = studied.maps["shifted"] if what == "map" else studied.differences["shifted"]
    html = shown._repr_html_()
    HTMLParser().feed(html)
    assert not re.search(r"https?:|<script|url\(", html) and len(html) < 20000
