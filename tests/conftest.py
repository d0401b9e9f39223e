"""Fixtures shared by all tests."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

pytest_plugins = "pytester"

# The first example may import a library: only the suite as a whole is timed.
settings.register_profile("hsr", deadline=None)
settings.load_profile("hsr")

SCENES = Path(__file__).parent.parent / "scenes"
JIT = os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "jit: too slow without compiled kernels")


def pytest_collection_modifyitems(items: Iterable[pytest.Item]) -> None:
    if JIT:
        return
    skip = pytest.mark.skip(reason="too slow without compiled kernels")
    for item in items:
        if item.get_closest_marker("jit"):
            item.add_marker(skip)


@pytest.fixture(scope="session", autouse=True)
def store(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keep results of this run out of the user's store, and those out of this run."""
    os.environ["HSR_STORE"] = str(tmp_path_factory.mktemp("store"))


@pytest.fixture(scope="session")
def scenes() -> Path:
    """The folder of the built-in scenes."""
    return SCENES


def _scene(objects: list[dict[str, Any]], **camera: Any) -> dict[str, Any]:
    defaults = {"type": "perspective", "eye": [0.3, 0.4, 5.0]}
    return {"hsr": 1, "camera": [{**defaults, **camera}], "object": objects}


@pytest.fixture(scope="session")
def make_scene() -> Any:
    """Build a scene from object tables and camera keys: ``make_scene([{...}], fov=60.0)``."""
    from hsr.scene.model import Scene

    return lambda objects, **camera: Scene.model_validate(_scene(objects, **camera))
