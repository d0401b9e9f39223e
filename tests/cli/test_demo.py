"""The command ``hsr demo``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

from hsr.cli import common as cli
from hsr.cli import demo


def test_the_page_is_there_at_once_and_whole_at_the_end(
    run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pages: list[str] = []
    page = tmp_path / "demo.html"

    def read(name: str) -> None:
        pages.append(f"{name} {page.read_text(encoding='utf-8')}")

    monkeypatch.setattr(cli, "names", lambda _: ["painter", "exact", "zbuffer"])
    monkeypatch.setattr(cli, "progress", lambda *_: _Stepping(read))
    code, out, _ = run("demo", "scenes/cube.toml", "--size", "24", "-o", str(page))
    assert code == 0 and page.as_uri() in out
    assert [text.split()[0] for text in pages] == ["exact", "painter", "zbuffer"]
    assert all("reload" in text for text in pages)
    assert "location.reload" not in page.read_text(encoding="utf-8")


class _Stepping:
    """Stands for a bar: calls what reads the page before each step."""

    def __init__(self, step: Any) -> None:
        self.step = step

    def __enter__(self) -> Any:
        return self.step

    def __exit__(self, *_: object) -> None:
        pass


@pytest.mark.parametrize("screen", [True, False])
def test_a_browser_opens_where_there_is_a_desktop(
    run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, screen: bool
) -> None:
    opened: list[str] = []
    monkeypatch.setattr(cli, "names", lambda _: ["exact"])
    monkeypatch.setattr(demo, "_has_desktop", lambda: screen)
    monkeypatch.setattr(demo.webbrowser, "open", opened.append)
    page = tmp_path / "demo.html"
    for more in ([], ["--no-browse"]):
        run("demo", "scenes/cube.toml", "--size", "16", "-q", "-o", str(page), *more)
    assert opened == [page.as_uri()] * screen


def test_no_arguments_show_the_demo_in_a_terminal_and_help_elsewhere(
    run: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[Any] = []
    monkeypatch.setattr("hsr.cli.app.demo", lambda **_: shown.append(True))
    code, out, _ = run()
    assert code == 0 and "COMMAND [ARGS]" in out and not shown
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    run()
    assert shown == [True]
