"""The API reference leads where it says: names in docstrings resolve, and no link between pages is dead."""

from __future__ import annotations

import ast
import importlib
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import hsr
from tests.test_house import ROOT as PACKAGE
from tests.test_house import sources

ROOT = Path(__file__).parent.parent
SOURCES = sources()
ROLE = re.compile(r":(mod|func|data|class|meth|attr|exc):`([^`]+)`|``(hsr\.[a-zA-Z_.]+)``")
WAYS = ("compare", "benchmark", "teach", "test", "extend")


def docstrings(tree: ast.Module) -> Iterator[str]:
    """Every docstring of a module, those of attributes included."""
    for node in ast.walk(tree):
        match node:
            case ast.Expr(value=ast.Constant(value=str(text))):
                yield text


def resolves(name: str, module: ModuleType) -> bool:
    """Whether a name leads to something from a module, its classes or the whole package."""
    if name.startswith("."):
        return whole(f"{module.__package__}{name}")
    classes = [thing for thing in vars(module).values() if isinstance(thing, type)]
    return any(has(home, name.split(".")) for home in (module, *classes)) or whole(name)


def has(home: Any, parts: list[str]) -> bool:
    for part in parts:
        fields = {**getattr(home, "__annotations__", {}), **getattr(home, "__pydantic_fields__", {})}
        if not hasattr(home, part) and part not in fields:
            return False
        home = getattr(home, part, None)
    return True


@cache
def whole(name: str) -> bool:
    """Whether a dotted name is a module of the package, or something in one."""
    parts = name.split(".")
    for end in range(len(parts), 0, -1):
        try:
            home = importlib.import_module(".".join(parts[:end])) if parts[0] == "hsr" else None
        except ModuleNotFoundError:
            continue
        return home is not None and has(home, parts[end:])
    return False


@pytest.mark.parametrize("name", sorted(SOURCES))
def test_every_reference_of_a_docstring_resolves(name: str) -> None:
    text = "\n".join(docstrings(SOURCES[name]))
    references = [target or code for _, target, code in ROLE.findall(text)]
    module = importlib.import_module(name) if references else hsr
    assert [one for one in references if not resolves(one, module)] == []


class Page(HTMLParser):
    """The anchors of a page, and where its links lead."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for key, value in attrs:
            if key == "id" and value:
                self.anchors.add(value)
            if (tag, key) == ("a", "href") and value:
                self.links.append(value)


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[Path, Page]:
    folder = tmp_path_factory.mktemp("api").resolve()
    env = {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
    subprocess.run([sys.executable, str(ROOT / "docs" / "api.py"), str(folder)], env=env, check=True)
    return {file: Page(file.read_text(encoding="utf-8")) for file in folder.rglob("*.html")}


def test_no_link_is_dead(pages: dict[Path, Page]) -> None:
    assert len(pages) > 30
    dead = []
    for file, page in pages.items():
        for link in page.links:
            path, _, anchor = link.partition("#")
            there = pages.get((file.parent / path).resolve() if path else file)
            if there is None or (anchor and anchor not in there.anchors):
                dead.append(f"{file.name}: {link}")
    assert dead == []


def test_the_front_page_has_the_five_ways_and_leads_to_every_name_it_tells(pages: dict[Path, Page]) -> None:
    (front,) = [file for file in pages if file.name == "index.html"]
    text = front.read_text(encoding="utf-8")
    assert all(re.search(rf"<h2[^>]*>To {way}", text) for way in WAYS)
    assert re.findall(r"<code>hsr\.[\w.]+</code>", text) == []


def test_every_public_name_is_told_with_its_docstring(pages: dict[Path, Page]) -> None:
    (home,) = [page for file, page in pages.items() if file.name == "hsr.html"]
    assert set(hsr.__all__) - home.anchors <= {"testing"}
