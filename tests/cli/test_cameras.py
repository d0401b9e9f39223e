"""The options that say where to look from."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hsr

CUBE = "scenes/cube.toml"


def test_the_command_sees_what_python_sees(run: Any, tmp_path: Path, scenes: Path) -> None:
    place = ("--eye", "-1,2,5", "--target", "0,0.5,0", "--fov", "50", "--near", "1", "--far", "20")
    code, _, _ = run("render", CUBE, "--size", "20", *place, "-o", str(tmp_path / "m.npz"))
    camera = hsr.Perspective(eye=(-1, 2, 5), target=(0, 0.5, 0), fov=50.0, near=1.0, far=20.0)
    here = hsr.render(hsr.load(scenes / "cube.toml"), "zbuffer", (20, 20), camera)
    assert code == 0 and np.array_equal(hsr.load_map(tmp_path / "m.npz").face, here.face)


def test_render_names_files_after_cameras(run: Any, two: str, tmp_path: Path) -> None:
    run(
        "render",
        two,
        "--size",
        "8",
        "--camera",
        "all",
        "-a",
        "zbuffer",
        "-a",
        "exact",
        "-o",
        str(tmp_path / "m.npz"),
    )
    made = sorted(path.name for path in tmp_path.glob("*.npz"))
    assert made == ["m.front.exact.npz", "m.front.zbuffer.npz", "m.side.exact.npz", "m.side.zbuffer.npz"]


@pytest.mark.parametrize(
    ("options", "names"),
    [
        ((), ["front"]),
        (("--camera", "side"), ["side"]),
        (("--camera", "side", "--camera", "front"), ["side", "front"]),
        (("--camera", "all"), ["front", "side"]),
        (("--orbit", "3"), ["front-0", "front-120", "front-240"]),
        (("--camera", "all", "--orbit", "2"), ["front-0", "front-180", "side-0", "side-180"]),
    ],
)
def test_cameras_are_chosen(run: Any, two: str, options: tuple[str, ...], names: list[str]) -> None:
    told = json.loads(run("render", two, "--size", "8", "--json", *options)[1])
    assert [row["camera"] for row in told["maps"]] == names


def test_compare_tells_wrong_samples_by_camera_in_one_table(run: Any) -> None:
    arguments = ("compare", "scenes/convex-behind.toml", "--size", "24", "-a", "backface", "-a", "raycast")
    code, out, _ = run(*arguments, "--ref", "zbuffer", "--orbit", "2")
    table = out[out.index("by camera") :].splitlines()
    assert code == 0 and [line.split() for line in table[1:2]] == [["scene,", "camera", "backface"]]
    assert [line.split()[:2] for line in table[2:4]] == [
        ["convex-behind,", "main-0"],
        ["convex-behind,", "main-180"],
    ]
    assert table[-1] == "nowhere: raycast"


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (("--camera", "back"), "no camera is named 'back'; the scene has main"),
        (("--eye", "0,0,0", "--target", "0,0,0"), "camera 'main': eye and target must differ"),
        (
            ("--fov", "40", "--parallel", "3"),
            "a perspective camera has fov, a parallel one height: leave one out",
        ),
    ],
)
def test_cameras_that_cannot_be_are_one_line(run: Any, options: tuple[str, ...], line: str) -> None:
    code, out, problem = run("render", CUBE, *options)
    assert code == 2 and out == "" and problem.startswith(f"hsr: {line}") and problem.count("\n") == 1


def test_one_sample_is_seen_by_one_camera(run: Any) -> None:
    for verb in (("explain", CUBE, "3,4"), ("shrink", CUBE, "3,4", "-a", "zbuffer", "-b", "raycast")):
        code, _, problem = run(*verb, "--orbit", "2")
        assert code == 2 and "needs one camera, not 2" in problem


def test_a_vector_has_three_numbers(run: Any) -> None:
    code, _, problem = run("render", CUBE, "--eye", "1,2")
    assert code == 2 and "X,Y,Z" in problem
