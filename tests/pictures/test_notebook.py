from __future__ import annotations

import html
import re
from html.parser import HTMLParser

import pytest

import hsr
from hsr.difference.study import Study
from hsr.pictures.palette import CAUSE_COLOURS
from tests.conftest import SCENES
from tests.pictures.test_png import decoded


def test_a_map_shows_its_faces_and_figures(studied: Study) -> None:
    shown = studied.maps["reference"]._repr_html_()
    picture = decoded(re.findall(r'src="([^"]*)"', shown)[0])
    assert picture.shape == (48, 64, 4) and len({tuple(pixel) for pixel in picture.reshape(-1, 4)}) == 3
    assert "reference  64x48" in shown and "2 faces on" in shown


def test_a_difference_shows_where_and_how_much(studied: Study) -> None:
    difference = studied.differences["shifted"]
    shown = difference._repr_html_()
    picture = decoded(re.findall(r'src="([^"]*)"', shown)[0])
    assert ((picture[..., 3] == 255) == (difference.classes > 0)).all()
    assert str(difference) in shown


@pytest.mark.parametrize("what", ["map", "difference"])
def test_nothing_is_taken_for_markup_and_nothing_is_fetched(what: str, studied: Study) -> None:
    shown = studied.maps["shifted"] if what == "map" else studied.differences["shifted"]
    text = shown._repr_html_()
    HTMLParser().feed(text)
    assert not re.search(r"https?:|<script|url\(", text) and len(text) < 20000


def test_causes_show_where_and_why() -> None:
    view = hsr.view(hsr.load(SCENES / "cyclic.toml"), (64, 48))
    why = hsr.causes(view, hsr.render(view, "painter"), hsr.render(view, "exact"))
    picture = decoded(re.findall(r'src="([^"]*)"', why._repr_html_())[0])
    shown = (picture[..., :3] == CAUSE_COLOURS["no depth test"]).all(-1)
    assert (shown == (why.cause > 0)).all()
    assert f"painter: {why.wrong} wrong\n{why.wrong} no depth test" in why._repr_html_()


def test_a_history_shows_its_text() -> None:
    view = hsr.view(hsr.load(SCENES / "cube.toml"), (8, 8))
    told = hsr.history(view, [hsr.render(view, "exact")], x=4, y=4)
    assert html.unescape(told._repr_html_()) == f"<pre>{told}</pre>"
