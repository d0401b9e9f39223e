"""The gallery: measured, complete, and animated where asked."""

from __future__ import annotations

import re
from io import BytesIO
from pathlib import Path

import pytest
from PIL import Image

import hsr
from hsr.pages import gallery
from hsr.pages.gallery import overview, turntable, write_gallery
from hsr.pictures.palette import CLASS_COLOURS
from tests.pages.policies import assert_strict

METHODS = ("exact", "scanline", "backface", "raycast")


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gallery, "SIDE", 24)
    monkeypatch.setattr(gallery, "TURN", 4)
    monkeypatch.setattr(gallery, "methods", lambda: METHODS)


def test_the_page_says_what_was_measured(tmp_path: Path, scenes: Path) -> None:
    names = ("cube", "convex-behind", "solids")
    told: list[str] = []
    loaded = {name: hsr.load(scenes / f"{name}.toml") for name in names}
    write_gallery(loaded, tmp_path, (64, 64), ["cube"], told.append)
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert_strict(page, images="'self' file:")
    cube, behind, solids = page.split("<article")[1:]
    view = hsr.view(loaded["convex-behind"], (64, 64))
    wrong = hsr.compare(hsr.render(view, "backface"), hsr.render(view, "exact")).different
    assert wrong > 0 and f"backface <b>{wrong}</b>" in behind
    assert "<b>" not in cube and "backface" in cube
    assert "scanline†" in solids and "rightly" not in solids
    assert re.findall(r'src="([^"]+)"', page) == ["cube.webp", "convex-behind.png", "solids.png"]
    assert [doing.split(":")[0] for doing in told] == [*METHODS] * len(names)
    for name in ("cube.png", "cube.webp", "convex-behind.png", "solids.png", "overview.png"):
        assert (tmp_path / name).exists()


def test_a_turntable_is_animated(scenes: Path) -> None:
    with Image.open(BytesIO(turntable(hsr.load(scenes / "cube.toml")))) as picture:
        assert picture.n_frames == 4 and picture.size == (24, 24)


def test_the_overview_has_a_column_a_scene(scenes: Path) -> None:
    loaded = [hsr.load(scenes / f"{name}.toml") for name in ("cube", "convex-behind")]
    picture = overview(loaded)
    side = 24 + 2 * gallery.GAP
    assert picture.shape == (4 * side, 2 * side, 3)
    red = (picture[3 * side :] == CLASS_COLOURS["wrong face"]).all(axis=-1)
    assert not red[:, :side].any() and red[:, side:].any()
