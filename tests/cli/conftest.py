from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

from hsr.cli import app


@pytest.fixture
def run(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    scenes: Path,
    tmp_path_factory: pytest.TempPathFactory,
) -> Any:
    """Run the command in this process: ``run("render", ...) -> (exit code, stdout, stderr)``."""

    monkeypatch.setenv("HSR_STORE", str(tmp_path_factory.mktemp("store")))

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.chdir(scenes.parent)
        monkeypatch.setattr(sys, "argv", ["hsr", *arguments])
        with pytest.raises(SystemExit) as ended:
            app.main()
            raise SystemExit(0)
        captured = capsys.readouterr()
        return int(ended.value.code or 0), captured.out, captured.err

    return call


TWO = """
[[camera]]
name = "front"
type = "perspective"
eye = [0.0, 0.0, 5.0]

[[camera]]
name = "side"
type = "perspective"
eye = [5.0, 0.0, 0.0]

[[object]]
name = "box"
shape = "cube"
"""


@pytest.fixture
def two(tmp_path: Path) -> str:
    """A scene with two cameras."""
    file = tmp_path / "two.toml"
    file.write_text(TWO, encoding="utf-8")
    return str(file)
