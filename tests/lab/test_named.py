"""Names of scenes: a file, a built-in scene, a hard case."""

from __future__ import annotations

from pathlib import Path

import pytest

import hsr
from hsr.lab.stability.cases import family_named
from hsr.scene.writing import to_toml


def test_a_hard_case_is_a_scene_by_its_name() -> None:
    scene, case = hsr.load("needle-gap"), family_named("needle-gap")
    assert (scene.title, scene.file) == ("needle-gap", "needle-gap")
    assert to_toml(scene) == to_toml(case.scene_at(case.sweep[-1], 512))
    view = hsr.view(scene)
    assert hsr.compare(hsr.render(view, "scanline-snap-8"), hsr.render(view, "exact")).different == 512


def test_files_come_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert hsr.load("cube").title != "needle"
    (tmp_path / "needle").write_text("no scene")
    with pytest.raises(hsr.HsrError, match=r"^needle: not a scene or mesh file"):
        hsr.load("needle")


def test_what_is_misspelt_is_guessed() -> None:
    with pytest.raises(hsr.HsrError, match="hard case 'needl'; did you mean 'needle'"):
        hsr.load("needl")
    with pytest.raises(hsr.HsrError, match="built-in scene 'cub'; did you mean 'cube'"):
        hsr.load("cub")
    with pytest.raises(hsr.HsrError, match="built-in scene 'xyzzy'; there are"):
        hsr.load("xyzzy")
