"""The command ``hsr diff``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import hsr

CUBE = "scenes/cube.toml"


def test_diff_of_equal_maps_is_0(run: Any, tmp_path: Path) -> None:
    for name in ("a", "b"):
        run("render", CUBE, "--size", "16", "-o", str(tmp_path / f"{name}.npz"))
    code, out, _ = run("diff", str(tmp_path / "a.npz"), str(tmp_path / "b.npz"))
    assert code == 0 and "0 differ" in out


def test_diff_of_other_faces_is_1(run: Any, tmp_path: Path) -> None:
    run("render", CUBE, "--size", "16", "-o", str(tmp_path / "a.npz"))
    answer = hsr.load_map(tmp_path / "a.npz")
    answer.face[8, 8] = 1
    answer.save(tmp_path / "b.npz")
    code, out, _ = run("diff", str(tmp_path / "a.npz"), str(tmp_path / "b.npz"))
    assert code == 1 and "1 differ" in out
    code, out, _ = run("diff", str(tmp_path / "a.npz"), str(tmp_path / "b.npz"), "--json")
    found = json.loads(out)
    assert code == 1 and found["counts"]["wrong face"] == 1
    assert found["files"] == [str(tmp_path / "a.npz"), str(tmp_path / "b.npz")]


def test_diff_of_other_sizes_is_2(run: Any, tmp_path: Path) -> None:
    for side in ("8", "16"):
        run("render", CUBE, "--size", side, "-o", str(tmp_path / f"{side}.npz"))
    code, _, problem = run("diff", str(tmp_path / "8.npz"), str(tmp_path / "16.npz"))
    assert code == 2 and problem.startswith("hsr: ") and "8x8" in problem and "16x16" in problem


def picture(face: Any, file: Path) -> str:
    """Write faces as a PNG of ids from 1 on, such as other renderers write."""
    Image.fromarray(np.stack([0 * face, 0 * face, face + 1], axis=-1).astype(np.uint8)).save(file)
    return str(file)


@pytest.fixture(scope="module")
def shown(scenes: Path) -> Any:
    return hsr.render(hsr.load(scenes / "concave.toml"), "scanline", (64, 48), subpixel_bits=4).face


CONCAVE = "scenes/concave.toml"  # every face is one triangle


@pytest.mark.jit
def test_a_picture_of_ids_is_judged_by_its_scene(run: Any, tmp_path: Path, shown: Any) -> None:
    snapped = picture(shown, tmp_path / "ids.png")
    code, out, _ = run("diff", snapped, CONCAVE, "--model", "float64", "--subpixel-bits", "4", "--json")
    found = json.loads(out)
    assert code == 1 and set(found["causes"]) == {"vertex snapping"} and found["different"] > 0
    assert found["model"] == {"model": "float64", "subpixel_bits": 4} and found["diagnoses"] == []
    code, out, _ = run("diff", snapped, CONCAVE)
    assert " by vertex snapping\n" in out and "  causes by the model float32, subpixel_bits 4\n" in out
    code, out, _ = run("diagnose", snapped, CONCAVE)
    assert code == 1 and out == "rounded as by vertex snapping, no mistake\n"
    code, _, problem = run("diff", snapped, CONCAVE, "--model", "flaot64")
    assert code == 2 and "did you mean 'float64'?" in problem


def test_a_mistake_is_named(run: Any, tmp_path: Path, shown: Any) -> None:
    good, bad = picture(shown, tmp_path / "good.png"), picture(np.roll(shown, 1, 1), tmp_path / "bad.png")
    code, out, _ = run("diagnose", bad, good, "--json")
    assert code == 1 and [one["mistake"] for one in json.loads(out)["diagnoses"]] == ["shifted by (1, 0)"]
    code, out, _ = run("diff", bad, good)
    assert code == 1 and "  shifted by (1, 0): explains " in out
    code, out, _ = run("diagnose", bad, CONCAVE)
    assert code == 1 and out.startswith("shifted by (1, 0): explains ")
    assert run("diagnose", good, good)[:2] == (0, "nothing differs\n")
    other = picture(np.random.default_rng(0).permutation(shown), tmp_path / "other.png")
    assert run("diagnose", other, good)[:2] == (1, "no mistake that is known explains it\n")
