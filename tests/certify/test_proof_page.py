"""The head page of :mod:`hsr.certify` proves certification by names that exist."""

from __future__ import annotations

import ast
import importlib
import re
from pathlib import Path

import hsr.certify
from hsr.algorithms.registry import certified_methods

ROOT = Path(__file__).parents[2]
PAGE = hsr.certify.__doc__ or ""
NAMED = sorted(set(re.findall(r":(?:func|mod):`(hsr[\w.]*)`", PAGE)))
TESTS = sorted(set(re.findall(r"``(test_\w+)``\s+in\s+``(tests/[\w/]+\.py)``", PAGE)))


def test_the_page_names_functions_that_exist() -> None:
    assert len(NAMED) > 25
    for name in NAMED:
        try:
            importlib.import_module(name)
        except ModuleNotFoundError:
            home, _, function = name.rpartition(".")
            assert callable(getattr(importlib.import_module(home), function, None)), name


def test_the_page_names_tests_that_exist() -> None:
    assert len(TESTS) > 15
    for test, file in TESTS:
        tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
        known = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
        assert test in known, f"{file}: {test}"


def test_the_page_speaks_of_all_certified_methods() -> None:
    assert all(f"``{name}``" in PAGE for name in certified_methods())
