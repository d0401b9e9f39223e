"""What the commands share: tables that fit, files that are what they are called."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from hsr.cli import common

HEAD = ("method", "scenes", "differ", "causes")
ROWS = [
    ("zbuffer", "3", "12", "vertex snapping 7, tessellation 5"),
    ("backface", "3", "0"),
    ("embree", "0", "missing"),
]


@pytest.fixture
def printed(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Print the table on a terminal of some width."""

    def call(width: int, **how: Any) -> list[str]:
        file = io.StringIO()
        monkeypatch.setattr(common, "out", Console(file=file, width=width, highlight=False))
        common.print_table(HEAD, ROWS, right=HEAD[1:3], **how)
        return [line.rstrip() for line in file.getvalue().splitlines()]

    return call


def test_a_table_with_room_is_whole(printed: Any) -> None:
    lines = printed(80, title="So far", below=["causes"], least=["scenes"])
    assert lines == [
        "So far",
        "method    scenes   differ  causes",
        "zbuffer        3       12  vertex snapping 7, tessellation 5",
        "backface       3        0",
        "embree         0  missing",
    ]


def test_texts_go_below_before_columns_are_left_out(printed: Any) -> None:
    below = ["zbuffer: vertex snapping 7, tessellation 5"]
    assert printed(30, below=["causes"], least=["scenes"])[0] == "method    scenes   differ"
    assert printed(30, below=["causes"], least=["scenes"])[4:] == below
    narrow = printed(20, below=["causes"], least=["scenes"])
    assert narrow[:2] == ["method     differ", "zbuffer        12"]
    assert narrow[4:5] == below and " ".join(narrow[5:]) == "Not shown for want of room: scenes."


def test_what_does_not_fit_goes_on_in_a_table_of_its_own(printed: Any) -> None:
    lines = printed(18)
    assert lines[0] == "method    scenes" and lines[4] == "method     differ"
    assert not any("…" in line for line in lines)


@pytest.mark.parametrize("width", range(17, 100))
def test_no_number_is_cut_at_any_width(printed: Any, width: int) -> None:
    text = "\n".join(printed(width, below=["causes"], least=["scenes"]))
    assert "…" not in text and all(
        name in text for name in ("zbuffer", "backface", "embree", "missing", "12")
    )


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (("render", "cube", "-o", "x.png"), "x.png: what is written ends in .npz; say x.npz"),
        (("render", "cube", "--png", "x.gif"), "x.gif: what is written ends in .png; say x.png"),
        (("compare", "cube", "-o", "r.pdf"), "r.pdf: what is written ends in .html; say r.html"),
        (("lesson", "culling", "-o", "l.txt"), "l.txt: what is written ends in .html; say l.html"),
        (
            ("shrink", "cube", "1,2", "-a", "zbuffer", "-b", "exact", "-o", "s.obj"),
            "s.obj: what is written ends in",
        ),
        (("compare", "cube", "-o", "nowhere/r.html"), "nowhere/r.html: there is no folder nowhere"),
        (("gallery", "cube", "-o", "g.html"), "g.html: what is written is a folder; say g"),
        (("lesson", "--all", "-o", "l.HTML"), "l.HTML: what is written is a folder; say l"),
        (("stability", "fan", "-o", "s.json"), "s.json: what is written is a folder; say s"),
        (("bench", "cube", "-o", "b.csv"), "b.csv: what is written is a folder; say b"),
    ],
)
def test_what_cannot_be_written_is_refused_before_any_work(
    run: Any, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], line: str
) -> None:
    monkeypatch.setattr("hsr.problem.view.load", lambda _: pytest.fail("work was done"))
    code, out, problem = run(*arguments)
    assert code == 2 and out == "" and problem.startswith(f"hsr: {line}") and problem.count("\n") == 1


def test_endings_may_be_written_in_capitals(tmp_path: Path) -> None:
    common.check_output(tmp_path / "A.HTML", ".html")


def test_a_folder_may_be_called_what_files_are_not(tmp_path: Path) -> None:
    common.check_output(tmp_path / "run.v2")
    common.check_output(tmp_path)


def test_the_shell_completes_methods_and_scenes() -> None:
    assert common.method_completion("zb") == ["zbuffer", "zbuffer-plain"]
    assert common.scene_completion("te") == ["teapot", "terrain"] and common.scene_completion("./te") == []
