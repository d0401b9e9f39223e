"""The certified ray caster: rounding decides nothing, and nothing else leaves a trace."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import hsr
from hsr.algorithms import raytiles
from hsr.algorithms.registry import method_named
from hsr.exact.oracle import truth
from tests.conftest import JIT
from tests.exact.adversarial import adversarial

SEEDS = 160 if JIT else 24


@pytest.mark.parametrize("curved", [False, True])
@pytest.mark.parametrize("share", range(4))
def test_adversarial_views_are_right_at_every_sample(share: int, curved: bool) -> None:
    for seed in range(share, SEEDS, 4):
        seen = adversarial(seed, curved)
        answer, exact = hsr.render(seen, "raycast"), truth(seen)
        assert np.array_equal(answer.face, exact.face), f"seed {seed}"
        shown = exact.face >= 0
        assert answer.depth[shown] == pytest.approx(exact.depth[shown], rel=1e-5, abs=1e-12), f"seed {seed}"


@pytest.mark.jit
@pytest.mark.parametrize("name", ["coplanar", "near-cut", "mirrored", "cyclic", "room", "solids", "terrain"])
def test_scenes_are_right_at_every_sample(name: str, scenes: Any) -> None:
    seen = hsr.view(hsr.load(scenes / f"{name}.toml"), (80, 64))
    assert np.array_equal(hsr.render(seen, "raycast").face, hsr.render(seen, "exact").face)


@pytest.mark.jit
def test_on_planar_scenes_it_shows_what_the_depth_buffer_shows() -> None:
    for seed in range(1, 40):
        seen = adversarial(seed)
        assert np.array_equal(hsr.render(seen, "raycast").face, hsr.render(seen, "zbuffer").face), (
            f"seed {seed}"
        )


def test_more_doubts_than_room_are_all_decided(monkeypatch: pytest.MonkeyPatch, scenes: Any) -> None:
    seen = hsr.view(hsr.load(scenes / "coplanar.toml"), (24, 24))
    expected = hsr.render(seen, "raycast")
    monkeypatch.setattr(raytiles, "ROOM", 1)
    again = hsr.render(seen, "raycast")
    assert np.array_equal(again.face, expected.face) and np.array_equal(again.depth, expected.depth)
    assert expected.work["uncertain"] > 100


def test_left_alone_nothing_is_decided_exactly(scenes: Any) -> None:
    seen = hsr.view(hsr.load(scenes / "coplanar.toml"), (24, 24))
    assert method_named("raycast-plain").render(seen).work.get("uncertain", 0) == 0


SHOWN = """
import json, hsr
from tests.exact.adversarial import adversarial
maps = [hsr.render(adversarial(seed, True), "raycast") for seed in (1, 2, 3, 5, 6, 7)]
print(json.dumps([[m.face.tolist(), m.depth.tobytes().hex()] for m in maps]))
"""


@pytest.mark.jit
@pytest.mark.parametrize("setting", [{"NUMBA_NUM_THREADS": "1"}, {"NUMBA_DISABLE_JIT": "1"}], ids=str)
def test_threads_and_compiler_leave_no_trace(setting: dict[str, str]) -> None:
    """Bit for bit the same faces and depths."""
    here = [hsr.render(adversarial(seed, True), "raycast") for seed in (1, 2, 3, 5, 6, 7)]
    run = subprocess.run(
        [sys.executable, "-c", SHOWN],
        env={**os.environ, **setting},
        capture_output=True,
        text=True,
        check=True,
    )
    for mine, (face, depth) in zip(here, json.loads(run.stdout), strict=True):
        assert mine.face.tolist() == face and mine.depth.tobytes().hex() == depth
