"""The file of results: read as written, or refused in one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hsr.base.errors import HsrError
from hsr.lab.regression import changes, table
from hsr.lab.results import case_title, load_results
from tests.damage import damaged
from tests.lab.made_up import results, row


def test_what_is_written_is_read(tmp_path: Path) -> None:
    made = results(row("zbuffer", wrong=3), row("lame", absent="cannot"))
    file = tmp_path / "run.json"
    file.write_text(made.to_json(), encoding="utf-8")
    assert load_results(file) == made
    assert json.loads(made.to_json())["rows"][0]["times"]["render"]["samples"] == [1.0, 1.0, 1.0]


def test_rows_of_a_case_stand_together() -> None:
    made = results(row("a"), row("a", scene="ball"), row("b"))
    assert {case: [r.method for r in rows] for case, rows in made.cases.items()} == {
        "box/64x64/scene": ["a", "b"],
        "ball/64x64/scene": ["a"],
    }
    assert case_title(made.rows) == "box, 12 triangles, 64x64"
    assert row("raycast-single").family == "raycast"


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"hsr": 2}, "hsr"),
        ({"kind": "study"}, "kind"),
        ({"rows": [{"id": 3}]}, "rows.0.id"),
        ({"more": 1}, "more"),
    ],
)
def test_another_schema_is_refused(tmp_path: Path, change: dict[str, object], named: str) -> None:
    file = tmp_path / "run.json"
    file.write_text(json.dumps(json.loads(results(row("a")).to_json()) | change), encoding="utf-8")
    with pytest.raises(HsrError, match=rf"run\.json: no benchmark results of version 1 \({named}: ") as told:
        load_results(file)
    assert "\n" not in str(told.value)


def test_files_that_are_no_results(tmp_path: Path) -> None:
    with pytest.raises(HsrError, match=r"nothing\.json: cannot read the results: No such file"):
        load_results(tmp_path / "nothing.json")
    (tmp_path / "text.json").write_bytes(b"\xff\xfe")
    with pytest.raises(HsrError, match="no benchmark results of version 1"):
        load_results(tmp_path / "text.json")


def test_damaged_results_are_refused_or_compared(tmp_path: Path) -> None:
    made, file = (
        results(row("zbuffer", wrong=3), row("lame", absent="cannot"), row("raycast")),
        tmp_path / "b.json",
    )
    refused = 0
    for value in damaged(json.loads(made.to_json()), 300):
        file.write_text(json.dumps(value), encoding="utf-8")
        try:
            found = load_results(file)
            table(changes(made, found), "")
            table(changes(found, made), "")
        except HsrError as error:
            refused += "\n" not in str(error)
    assert 100 < refused < 300
