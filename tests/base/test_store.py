"""The store of results: what is found, what is not, and what goes when it is full."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from hsr.base import store
from hsr.base.errors import HsrError
from hsr.base.store import Store


def test_what_is_kept_is_found_by_all_that_it_is_made_of(tmp_path: Path) -> None:
    kept = Store(tmp_path)
    kept.put(np.arange(3), "map", {"size": "3x1"})
    assert kept.get("map", {"size": "3x1"}).tolist() == [0, 1, 2]
    assert kept.get("map", {"size": "3x2"}) is None
    assert Store(tmp_path).get("map", {"size": "3x1"}) is not None
    assert Store(tmp_path, fresh=True).get("map", {"size": "3x1"}) is None


def test_other_code_finds_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Store(tmp_path).put("old", "map")
    monkeypatch.setattr(store, "code", lambda: "changed")
    assert Store(tmp_path).get("map") is None


@pytest.mark.parametrize("data", [b"", b"nonsense"])
def test_what_cannot_be_read_is_made_again(tmp_path: Path, data: bytes) -> None:
    kept = Store(tmp_path)
    kept.put("whole", "map")
    kept.place("map").write_bytes(data)
    assert kept.get("map") is None


def test_those_not_asked_for_the_longest_go_first(tmp_path: Path) -> None:
    kept = Store(tmp_path, megabytes=1)
    noise = np.random.default_rng(7)
    for k in range(3):
        kept.put(noise.bytes(400_000), k)
        os.utime(kept.place(k), (k, k))
    assert kept.get(0) is not None  # asked for just now
    kept.trim()
    assert [kept.get(k) is None for k in range(3)] == [False, True, False]


def test_a_place_where_nothing_can_be_written_keeps_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    kept = Store(tmp_path / "file")
    kept.put("result", "map")
    kept.trim()
    assert kept.get("map") is None


def test_a_limit_that_is_no_number_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HSR_STORE_MB", "1 GB")
    with pytest.raises(HsrError, match="HSR_STORE_MB=1 GB: write a number of megabytes"):
        Store()
