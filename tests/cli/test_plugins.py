"""Methods of other packages: one that is broken breaks only itself."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest

from hsr.algorithms import registry

BROKEN = """
from dataclasses import dataclass
import numpy as np
from hsr import Method, VisibilityMap

@dataclass(frozen=True)
class Options:
    pass

def render(view, options):
    raise KeyError("no such\\ncorner")

raises = Method("raises", "raises", "hsr_broken")
small = Method("small", "answers in the wrong shape", "hsr_small")
models = Method("models", "has broken models", "hsr_models", pipeline="hsr_no")
none = 3
"""
SMALL = """
from hsr_broken import Options
import numpy as np
from hsr import VisibilityMap

def render(view, options):
    return VisibilityMap(np.full((1, 1), -1, np.int32), np.full((1, 1), np.inf), "small")
"""
EMPTY = SMALL.replace("(1, 1)", "(view.height, view.width)")
WHY = {
    "gone": "entry point hsr_no:gone cannot be loaded: ModuleNotFoundError: No module named 'hsr_no'",
    "none": "entry point hsr_broken:none must be an hsr.Method, not int",
    "raises": "it broke down: KeyError: 'no such\\ncorner'",
    "small": "its answer is no map of 8x8 samples",
}


@pytest.fixture
def plugins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Install methods of which each is broken in another way."""
    for name, text in (("hsr_broken", BROKEN), ("hsr_small", SMALL), ("hsr_models", EMPTY)):
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    group = [
        ("gone", "hsr_no:gone"),
        *((name, f"hsr_broken:{name}") for name in ("none", "raises", "small", "models")),
    ]
    points = [EntryPoint(name, value, registry.ENTRY_POINTS) for name, value in group]
    monkeypatch.setattr(
        registry, "entry_points", lambda group: points if group == registry.ENTRY_POINTS else []
    )
    registry.methods.cache_clear()
    yield
    registry.methods.cache_clear()


@pytest.mark.usefixtures("plugins")
def test_each_has_a_row_and_its_reason(run: Any) -> None:
    asked = [word for name in ("zbuffer", *WHY, "models") for word in ("-a", name)]
    code, out, _ = run("compare", "cube", "--size", "8", *asked, "--json")
    (study,) = json.loads(out)["studies"]
    assert code == 0 and study["skipped"] == WHY
    assert [*study["differences"]] == ["zbuffer", "models"]
    assert study["causes"]["models"]["unexplained"] == study["differences"]["models"]["different"] > 0
    table = run("compare", "cube", "--size", "8", *asked)[1]
    assert all(f"\n{name} " in table and f"\n{name}: {why}\n" in table for name, why in WHY.items())


@pytest.mark.usefixtures("plugins")
@pytest.mark.parametrize("name", WHY)
def test_asked_for_alone_each_is_one_line(run: Any, name: str) -> None:
    code, out, problem = run("render", "cube", "--size", "8", "-a", name)
    assert (code, out) == (2, "") and problem == f"hsr: {name}: {WHY[name]}\n"


@pytest.mark.usefixtures("plugins")
def test_the_list_of_methods_stays_whole(run: Any) -> None:
    told = {row["name"]: row for row in json.loads(run("algos", "--json")[1])["methods"]}
    assert told["gone"]["about"] == WHY["gone"] and "zbuffer" in told
