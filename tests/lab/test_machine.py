"""What the machine is and does."""

from __future__ import annotations

import os
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from hsr.lab import machine
from hsr.lab.machine import clocks, commit, foreign_load, peak_of, yardstick


def test_foreign_load_is_what_others_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two processors busy for ten seconds each, while this process did next to nothing."""
    ticks = os.sysconf("SC_CLK_TCK")
    file = tmp_path / "stat"
    monkeypatch.setattr(machine, "STAT", file)
    monkeypatch.setattr(time, "perf_counter", iter([100.0, 110.0]).__next__)
    file.write_text(f"cpu  {0} 0 0 7 7 0 0 0 0 0\n")
    begun = clocks()
    file.write_text(f"cpu  {10 * ticks} {5 * ticks} {2 * ticks} 99 99 {ticks} {ticks} {ticks} 0 0\n")
    assert foreign_load(begun) == pytest.approx(2.0, abs=0.1)


def test_a_system_that_does_not_tell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "STAT", tmp_path / "nothing")
    monkeypatch.setattr(machine, "CLEAR_REFS", tmp_path / "no folder" / "nothing")
    assert foreign_load(clocks()) is None and peak_of(lambda: 3) == (3, None)


@pytest.mark.skipif(not os.access(machine.CLEAR_REFS, os.W_OK), reason="this system tells no peak memory")
def test_peak_memory_is_seen_though_it_is_given_back() -> None:
    made, peak = peak_of(lambda: np.ones(4_000_000).sum())
    _, calm = peak_of(lambda: None)
    assert made == 4e6 and peak is not None and 30e6 < peak < 40e6
    assert calm is not None and calm < 5e6


def test_the_commit_is_that_of_the_checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "ROOT", tmp_path)
    assert commit() is None

    def git(*arguments: str) -> str:
        told = subprocess.run(["git", "-C", tmp_path, *arguments], check=True, capture_output=True, text=True)
        return told.stdout.strip()

    git("init", "-q")
    (tmp_path / "file").write_text("one")
    git("add", "file")
    git("-c", "user.name=a", "-c", "user.email=a@b", "commit", "-q", "-m", "one")
    assert commit() == git("rev-parse", "--short", "HEAD")
    (tmp_path / "file").write_text("two")
    assert commit() == git("rev-parse", "--short", "HEAD") + "-dirty"


def test_the_machine_has_a_name_for_files(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GOMP_SPINCOUNT", "7")
    found = machine.machine()
    assert found.name == found.name.lower() and "/" not in found.name and " " not in found.name
    assert found.name.endswith(f"-{found.threads}")
    assert found.environment["GOMP_SPINCOUNT"] == "7" and "numba" in found.versions


def test_the_yardstick_takes_time() -> None:
    assert all(0.0 < yardstick() < 1000.0 for _ in range(3))
