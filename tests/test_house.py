"""How the house is built: no circle among its modules, string imports where they belong, names that stay."""

from __future__ import annotations

import ast
import importlib
import pkgutil
import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from types import ModuleType

import pytest

import hsr

ROOT = Path(hsr.__file__).parent

BY_STRING = {
    "__init__.py",
    "algorithms/registry.py",
    "lab/stability/cases/__init__.py",
    "scene/shapes/__init__.py",
}
"""What may import by a string: two files that publish names, two that load their own folder."""

PLANNED = ("regions", "lines", "frames", "hits", "report", "shapes")
"""Public names to come: no package may be in their way."""


def sources() -> dict[str, ast.Module]:
    """Every module of the package by its dotted name."""
    found = {}
    for path in ROOT.rglob("*.py"):
        parts = path.relative_to(ROOT.parent).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        found[name] = ast.parse(path.read_text(encoding="utf-8"))
    return found


def imports(name: str, tree: ast.Module, known: set[str]) -> set[str]:
    """Modules of the package that a module imports anywhere, but for its own packages, which come first."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        if isinstance(node, ast.ImportFrom) and node.module:
            whole = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= (whole & known) or {node.module}
    return {one for one in found & known if not name.startswith(f"{one}.")} - {name, "hsr"}


def test_there_is_no_circle() -> None:
    trees = sources()
    graph = {name: imports(name, tree, set(trees)) for name, tree in trees.items() if name != "hsr"}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


def test_modules_are_named_by_strings_in_few_files() -> None:
    named = {
        path.relative_to(ROOT).as_posix()
        for path in ROOT.rglob("*.py")
        if re.search("import_module|resolve_name|__import__", path.read_text(encoding="utf-8"))
    }
    assert named <= BY_STRING


def test_public_names_are_what_they_were_when_everything_is_imported() -> None:
    for module in pkgutil.walk_packages(hsr.__path__, "hsr."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    assert isinstance(hsr.testing, ModuleType)
    for name in ("causes", "compare", "history", "load", "load_map", "methods", "render", "view"):
        assert callable(getattr(hsr, name)) and not isinstance(getattr(hsr, name), ModuleType), name
    for name in ("Difference", "HsrError", "Method", "Scene", "View", "VisibilityMap"):
        assert isinstance(getattr(hsr, name), type), name
    for name in PLANNED:
        assert not isinstance(getattr(hsr, name, None), ModuleType), name
