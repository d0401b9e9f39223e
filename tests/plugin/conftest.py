"""The sample project is run by pytester, never collected here."""

from __future__ import annotations

import importlib
import shutil
from pathlib import Path

import pytest

import hsr

collect_ignore = ["sample"]

SAMPLE = Path(__file__).parent / "sample"


@pytest.fixture
def project(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """A copy of the sample project, to be run where no CI is."""
    monkeypatch.delenv("CI", raising=False)
    shutil.copytree(SAMPLE, pytester.path, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__"))
    pytester.makeini("[pytest]\n")
    return pytester


@pytest.fixture(scope="session", autouse=True)
def everything_imported() -> None:
    """Import beforehand what runs of pytest within a test import: after each, pytester forgets it."""
    rows = hsr.methods().values()
    modules = {module for row in rows for module in (row.module, row.pipeline) if module}
    more = (
        "hsr.testing.results",
        "hsr.cli",
        "skimage.metrics",
        "hypothesis",
        "matplotlib",
    )
    for module in (*modules, *more):
        importlib.import_module(module)
    hsr.render(hsr.load(SAMPLE / "room.toml"), "raycast", (4, 4))  # Numba imports more when it first compiles
