"""A study made of maps painted by hand, so that a report needs no renderer."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hsr
from hsr.base.arrays import Array
from hsr.difference.classes import compare
from hsr.difference.study import Study, explained, study
from hsr.pages.report import write_report
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View
from hsr.scene.model import Scene

TABLES = {
    "hsr": 1,
    "title": "Two boxes & a <wall>",
    "about": "Not a picture of anything: the maps are painted by hand.",
    "camera": [{"type": "perspective", "eye": [0.0, 0.0, 6.0]}],
    "object": [{"name": "box", "shape": "cube"}, {"name": "other", "shape": "cube"}],
}


def painted(view: View, method: str, shift: int = 0) -> VisibilityMap:
    """Paint the front of a box, with a strip of another, ``shift`` columns to the right."""
    face = np.full((view.height, view.width), -1, dtype=np.int32)
    face[8:40, 10 + shift : 50 + shift] = 4
    face[20:24, 30 + shift : 60] = 10
    depth = np.where(face < 0, np.inf, 5.0 + np.arange(view.width) / 64.0)
    return VisibilityMap(
        face,
        depth,
        method,
        {"edges": 4},
        {"prepare": 0.001, "render": 0.25},
        {"driver": "a painted driver 1.0"},
        view.manifest,
        view.hashes,
    )


@pytest.fixture(scope="session")
def studied() -> Study:
    """Three methods: the reference, one that agrees, one that is two columns off."""
    scene = Scene.model_validate(TABLES)
    view = hsr.view(scene, (64, 48))
    maps = {
        "shifted": painted(view, "shifted", 2),
        "reference": painted(view, "reference"),
        "equal": painted(view, "equal"),
    }
    differences = {name: compare(map, maps["reference"]) for name, map in maps.items() if name != "reference"}
    wrong = differences["shifted"].different
    agreement: Array = np.array([[0, wrong, wrong], [wrong, 0, 0], [wrong, 0, 0]])
    return Study(
        "boxes",
        scene,
        view,
        "main",
        ("shifted", "reference", "equal", "absent"),
        "reference",
        maps,
        {"absent": "needs a driver; install one"},
        frozenset({"absent"}),
        ("shifted",),
        differences,
        {},
        agreement,
    )


@pytest.fixture(scope="session")
def studied_alone(studied: Study) -> Study:
    """The same methods without a reference."""
    return replace(studied, reference=None, differences={})


@pytest.fixture(scope="session")
def real(scenes: Path) -> Study:
    """Four methods, two of them wrong at some samples, judged by the exact one."""
    loaded = hsr.load(scenes / "cyclic.toml")
    return explained(study(loaded, ["backface", "scanline-d16", "zbuffer"], "exact", (96, 72), name="cyclic"))


@pytest.fixture(scope="session")
def report(studied: Study, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report on the study, as a file."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    write_report([studied], path)
    return path


@pytest.fixture(scope="session")
def page(report: Path) -> str:
    """The text of the report."""
    return report.read_text(encoding="utf-8")
