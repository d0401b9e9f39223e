"""The examples in docstrings give what they show, and every public function has one."""

from __future__ import annotations

import doctest
import importlib
import inspect
import shutil
from pathlib import Path

import pytest

import hsr
from tests.conftest import SCENES

PACKAGE = Path(hsr.__file__).parent
MODULES = [
    ".".join(("hsr", *file.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__")
    for file in sorted(PACKAGE.rglob("*.py"))
    if ">>> " in file.read_text(encoding="utf-8")
]
PUBLIC = [
    function
    for home in (hsr, hsr.testing)
    for function in (getattr(home, name) for name in home.__all__)
    if inspect.isfunction(function) and not function.__name__.startswith(("from_n", "from_o", "from_p"))
]
"""Those that convert what another renderer draws need that renderer, or its files."""


@pytest.mark.parametrize("name", MODULES)
def test_examples_give_what_they_show(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(SCENES, tmp_path / "scenes")
    monkeypatch.chdir(tmp_path)
    module = importlib.import_module(name)
    found = doctest.testmod(module)
    assert found.attempted > 0 and found.failed == 0


@pytest.mark.parametrize("function", PUBLIC, ids=lambda function: function.__name__)
def test_public_functions_have_an_example(function: object) -> None:
    assert ">>> " in (inspect.getdoc(function) or "")
