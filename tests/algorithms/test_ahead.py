"""Kernels compiled by a second process: what it is asked for, and what waits for it."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hsr.algorithms import ahead
from hsr.algorithms.ahead import Ahead
from hsr.algorithms.registry import method_named

CUBE = Path(__file__).parents[2] / "scenes" / "cube.toml"


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """The commands of processes that would have been started; nothing is compiled yet."""
    commands: list[list[str]] = []

    def start(command: list[str], **_: Any) -> Any:
        commands.append(command)
        return SimpleNamespace(
            wait=lambda: commands.append(["waited"]), kill=lambda: commands.append(["killed"])
        )

    monkeypatch.setattr(ahead.subprocess, "Popen", start)
    monkeypatch.setattr(ahead.os, "cpu_count", lambda: 2)
    monkeypatch.setattr(ahead, "is_compiled", lambda name: name == "raycast")
    return commands


def test_what_is_not_compiled_is_compiled_elsewhere_and_comes_last(asked: list[list[str]]) -> None:
    methods = [method_named(name) for name in ("zbuffer", "raycast", "painter")]
    second = Ahead(CUBE, [method.name for method in methods])
    assert asked[0][-2:] == [str(CUBE), "zbuffer"]
    assert [method.name for method in second.order(methods)] == ["raycast", "painter", "zbuffer"]
    for method in methods:
        second.wait(method)
    assert asked[1:] == [["waited"]]


@pytest.mark.parametrize("methods", [["zbuffer"], ["painter"], ["raycast", "exact"]])
def test_nothing_is_started_for_what_would_be_waited_for_at_once(
    asked: list[list[str]], methods: list[str]
) -> None:
    second = Ahead(CUBE, methods)
    second.wait(method_named(methods[0]))
    assert not asked


def test_what_nobody_waits_for_any_more_ends(asked: list[list[str]]) -> None:
    with Ahead(CUBE, ["zbuffer", "painter"]):
        pass
    assert asked[1:] == [["killed"], ["waited"]]


def test_the_second_process_draws_a_tiny_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[str] = []
    monkeypatch.setattr("hsr.algorithms.registry.Method.warm_up", lambda self, _: drawn.append(self.name))
    ahead.main(str(CUBE), "zbuffer", "raycast")
    assert drawn == ["zbuffer", "raycast"]
