"""Maps of other programs on the command line: from a file to every cause, the page and one sample."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import hsr

CONCAVE = "scenes/concave.toml"  # every face is one triangle


@pytest.fixture(scope="module")
def files(scenes: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One map, which snaps vertices to 1/16 pixel, as other programs write it."""
    shown = hsr.render(hsr.load(scenes / "concave.toml"), "scanline", (64, 48), subpixel_bits=4)
    face, folder = shown.face, tmp_path_factory.mktemp("ids")
    Image.fromarray(np.stack([4 * (face + 1), 0 * face, 0 * face], axis=-1).astype(np.uint8)).save(
        folder / "bgr.png"
    )
    np.save(folder / "ids.npy", face[::-1])
    (face + 1).astype("<u2").tofile(folder / "ids.raw")
    rows = [f"#{4 * (k + 1):06x},{shown.name_of(k)}" for k in range(face.max() + 1)]
    (folder / "faces.csv").write_text("\n".join(["id,face", *rows]))
    return folder


def options(files: Path) -> dict[str, list[str]]:
    return {
        "bgr.png": ["--ids", "bgr24", "--faces", str(files / "faces.csv")],
        "ids.npy": ["--flip"],
        "ids.raw": ["--ids", "r16", "--size", "64x48", "--background", "#0000"],
    }


@pytest.mark.jit
@pytest.mark.parametrize("name", ["bgr.png", "ids.npy", "ids.raw"])
def test_diff_tells_every_cause(run: Any, files: Path, name: str) -> None:
    code, out, _ = run("diff", str(files / name), CONCAVE, *options(files)[name], "--json")
    found = json.loads(out)
    assert code == 1 and set(found["causes"]) == {"vertex snapping"}
    assert found["model"] == {"model": "float32", "subpixel_bits": 4}
    code, out, _ = run("diagnose", str(files / name), CONCAVE, *options(files)[name])
    assert code == 1 and out == "rounded as by vertex snapping, no mistake\n"


@pytest.mark.jit
def test_compare_shows_maps_beside_methods(run: Any, files: Path, tmp_path: Path) -> None:
    how, page = options(files)["bgr.png"], str(tmp_path / "page.html")
    arguments = ("compare", CONCAVE, "-a", "zbuffer", "--map", f"mine={files / 'bgr.png'}", *how)
    code, out, _ = run(*arguments, "-o", page)
    assert code == 0 and "concave, 64x48, against exact" in out
    assert re.search(r"^mine: vertex snapping \d+$", out, re.MULTILINE)
    assert run(*arguments, "--fail-on", "missing,extra,wrong face")[0] == 1
    (study,) = json.loads(run(*arguments, "--json")[1])["studies"]
    assert (
        list(study["methods"]) == ["zbuffer", "exact", "mine"] and study["causes"]["mine"]["unexplained"] == 0
    )
    text = Path(page).read_text(encoding="utf-8")
    assert ">mine<" in text and "vertex snapping" in text and '<td class="number quiet">–</td></tr>' in text
    command = next(line for line in re.findall(r'hsr explain [^"<]*', text) if "--map" in line)
    place = "{x},{y}".format(**study["differences"]["mine"]["clusters"][0]["sample"])
    code, out, _ = run(*shlex.split(command.replace("X,Y", place))[1:])
    assert code == 0 and re.search("^mine shows .* rounded .vertex snapping.", out, re.MULTILINE)
    assert "zbuffer is right" in out


@pytest.mark.jit
def test_two_maps_of_other_programs_are_compared(run: Any, files: Path) -> None:
    face = np.load(files / "ids.npy")
    np.save(files / "b.npy", face)
    assert run("diff", str(files / "ids.npy"), str(files / "b.npy"))[0] == 0
    face[30, 30] = 7
    np.save(files / "b.npy", face)
    code, out, _ = run("diff", str(files / "ids.npy"), str(files / "b.npy"))
    assert code == 1 and "1 differ" in out


@pytest.mark.jit
@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (("compare", CONCAVE, "--map", "zbuffer={}/ids.npy"), "zbuffer is a method; call the map otherwise"),
        (("compare", CONCAVE, "--map", "a={}/ids.npy", "--map", "a={}/ids.npy"), "are called alike"),
        (("compare", CONCAVE, "--orbit", "2", "--map", "{}/ids.npy"), "a map shows one view, not 2"),
        (
            ("compare", CONCAVE, "--size", "9", "--map", "{}/ids.npy"),
            "64x48 is not the size of the view, 9x9",
        ),
        (("compare", CONCAVE, "--map", "no.npy"), "no.npy: no such file"),
        (("diff", "{}/ids.npy", CONCAVE, "--background", "red"), "'red': write a number or #rrggbb"),
        (("diff", "{}/ids.npy", CONCAVE, "--subpixel-bits", "4"), "belong to a model: name it"),
        (("diff", "{}/ids.raw", CONCAVE), "give ids, such as r32, and size"),
        (("explain", CONCAVE, "3,3", "--map", "{}/bgr.png"), "is no triangle: they run from 0 to"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line(run: Any, files: Path, arguments: Any, problem: str) -> None:
    code, out, told = run(*(word.format(files) for word in arguments))
    assert code == 2 and out == "" and problem in " ".join(told.split())


def test_accept_makes_a_map_a_baseline(
    run: Any, files: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tests").mkdir()
    baseline, raw = "tests/__visibility__/pictures/concave.npz", options(files)["ids.raw"]
    code, out, _ = run("accept", "--map", f"{baseline}={files / 'ids.raw'}", *raw)
    assert code == 0 and out == f"wrote {baseline}\n"
    assert run("diff", str(files / "ids.npy"), baseline, "--flip")[0] == 0
    assert np.array_equal(hsr.load_map(baseline).face, np.load(files / "ids.npy")[::-1])


@pytest.mark.parametrize(
    ("given", "problem"),
    [
        ([], "name a file of decisions, or --map BASELINE=FILE"),
        (["--map", "ids.raw"], "--map: write BASELINE=FILE"),
        (["--map", "elsewhere.npz={file}"], "elsewhere.npz: has no baseline in this project"),
        (["--map", "../__visibility__/a/b.npz={file}"], "has no baseline in this project"),
        (["--map", "none/__visibility__/a/b.npz={file}"], "there is no folder none here"),
    ],
)
def test_accept_writes_baselines_of_this_project_only(
    run: Any, files: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, given: list[str], problem: str
) -> None:
    monkeypatch.chdir(tmp_path)
    given = [word.format(file=files / "ids.raw") for word in given]
    code, _, told = run("accept", *given, *options(files)["ids.raw"])
    assert code == 2 and problem in " ".join(told.split()) and not [*tmp_path.iterdir()]
