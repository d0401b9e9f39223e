"""Pages of lessons: whole, self-contained, the same twice; and the command that writes them."""

from __future__ import annotations

import base64
import json
import re
import zlib
from pathlib import Path
from typing import Any

import pytest

from hsr.cli import app
from hsr.lessons.lesson import lesson_of
from hsr.lessons.topics import topics
from hsr.pages.lesson import write_course, write_lesson
from tests.pages.policies import assert_strict


def test_a_page_holds_its_recording_and_nothing_from_elsewhere(tmp_path: Path) -> None:
    topic, path = topics()["ties"], tmp_path / "ties.html"
    write_lesson(topic, path)
    page = path.read_text(encoding="utf-8")
    packed = re.search(r'id="recording">([^<]*)<', page)
    assert packed is not None
    found = json.loads(zlib.decompress(base64.b64decode(packed[1])))
    assert found == json.loads(json.dumps(lesson_of(topic)))
    assert_strict(page)
    assert not re.search(r"""(?:src|href)\s*=|@import|url\(|https?://(?!www\.w3\.org/2000/svg)""", page)


def test_the_same_lesson_has_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one.html", "two.html"):
        write_lesson(topics()["culling"], tmp_path / name)
    assert (tmp_path / "one.html").read_bytes() == (tmp_path / "two.html").read_bytes()


def test_a_course_lists_its_lessons(tmp_path: Path) -> None:
    course = {name: topics()[name] for name in ("ties", "culling")}
    write_course(course, tmp_path)
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert re.findall(r'href="([^"]+)"', page) == ["ties.html", "culling.html"]
    assert_strict(page)
    assert all((tmp_path / f"{name}.html").exists() for name in course)


def run(monkeypatch: pytest.MonkeyPatch, *arguments: Any) -> int:
    """Run the command; return its exit code."""
    monkeypatch.setattr("sys.argv", ["hsr", *map(str, arguments)])
    with pytest.raises(SystemExit) as ended:
        app.main()
    return int(ended.value.code or 0)


def test_the_command_writes_a_lesson_on_another_scene(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, scenes: Path
) -> None:
    path = tmp_path / "lesson.html"
    assert run(monkeypatch, "lesson", "depth-buffer", scenes / "cube.toml", "-o", path) == 0
    assert "The depth buffer" in path.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["zbufer", "-o", "lesson.html"], "no lesson is about 'zbufer'; there are culling, depth-buffer"),
        (["-o", "lesson.html"], "name a topic or say --all; the topics are culling"),
        (["ties", "--all", "-o", "lesson.html"], "name a topic or say --all"),
        (["ties"], "say where to write by -o"),
        (["ties", "-o", "absent/lesson.html"], "there is no folder absent"),
        (["depth-buffer", "TEAPOT", "-o", "lesson.html"], "faces are too many to follow step by step, 48 is"),
        (["ties", "absent.toml", "-o", "lesson.html"], "absent.toml"),
    ],
)
def test_bad_input_is_one_line_and_leaves_no_file(
    arguments: list[str],
    complaint: str,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    scenes: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    named = [str(scenes / "teapot.toml") if word == "TEAPOT" else word for word in arguments]
    assert run(monkeypatch, "lesson", *named) == 2
    told = capsys.readouterr().err
    assert complaint in told and told.count("\n") == 1
    assert not list(tmp_path.iterdir())
