"""Whether the pages for people run as written, from the built wheel, in fresh environments.

    python -m tests.proof_readme [3.11 3.13 ...]

Builds sdist and wheel and looks into the wheel. Then, for Python 3.11 and the newest Python on this machine
for which all dependencies have wheels (or those that are named): a new environment, the wheel, and in a
folder with nothing but the built-in scenes and what a reader has (:data:`READER`), every command and
snippet of the README and of the API reference's front page, but for :data:`NOT_RUN`. The README's recipes,
which change the package, are followed by ``tests/test_house_guide.py``. Ends with exit code 1 if something
does not run.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path
from zipfile import ZipFile

ROOT = Path(__file__).parent.parent
PAGES = tuple((ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "docs/index.md"))
PYTHONS = ("3.14", "3.13", "3.12", "3.11")
OLDEST = "3.11"

NOT_RUN = {
    "make ": "sets up a checkout",
    "python benchmarks/": "measures in a checkout",
    "sudo apt-get": "changes the machine",
    "hsr bench stanford-bunny.obj": "takes an hour, and meshes that are not in the package",
    "hsr bench scaling -o": "takes an hour; --quick is run",
    "hsr stability -o": "takes most of an hour; one family is run",
    "hsr accept": "takes what a person has decided on a page",
}
"""Beginnings of commands that are not run, and why."""

MAY_DIFFER = ("hsr compare", "hsr diff", "hsr explain", "hsr bench compare")
"""Commands whose exit code 1 is an answer."""

READER = """
from pathlib import Path

import numpy as np
from PIL import Image
from skimage.measure import marching_cubes

import hsr

corners, faces, *_ = marching_cubes((np.mgrid[-2:2:9j, -2:2:9j, -2:2:9j] ** 2).sum(axis=0), 3.0)
rows = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
Path("bunny.obj").write_text("\\n".join(rows))
view = hsr.view(hsr.load("scene.toml"), (512, 512))
face = hsr.render(view, "exact").face
first = np.searchsorted(view.triangle_face, np.arange(face.max() + 1))
ids = np.where(face < 0, 0, first[face] + 1)
Image.fromarray(np.stack([ids >> 16, ids >> 8, ids], -1).astype(np.uint8)).save("ids.png")
"""
"""What a reader has: a mesh, and ids of triangles that another renderer drew of the scene shown."""

PREPARE = (
    "hsr render scenes/cube.toml -a zbuffer -o a.npz",
    "hsr render scenes/cube.toml -a raycast -o b.npz",
    "hsr bench scenes/cube.toml --size 64 -a zbuffer -o made",
    "cp made/*.json a.json; cp a.json b.json",
    "cp scenes/cube.toml my.toml",
    "pytest --hsr-update=new || true",
)


def fenced(language: str) -> list[str]:
    found = [
        pair for text in PAGES for pair in re.findall(r"^```(\w*)\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    ]
    return [block for tongue, block in found if tongue == language]


def commands() -> list[str]:
    """Every command of the pages: of their blocks, and those of two words and more within the text."""
    lines = "\n".join(fenced("")).splitlines()
    steps = [step for block in fenced("yaml") for step in re.findall(r"run: (.*)", block)]
    spoken = [
        " ".join(code.split())
        for text in PAGES
        for code in re.findall(r"`([^`]+)`", re.sub(r"```.*?```", "", text, flags=re.DOTALL))
    ]
    found = [
        re.sub(r"\s+#.*", "", line)
        for line in (*lines, *(part for one in steps for part in one.split(" && ")))
    ]
    found += [
        code for code in spoken if len(code.split()) > 2 and not re.search(r"\.\.\.|\b[A-Z]{3,}\b", code)
    ]
    return [
        line
        for line in dict.fromkeys(found)
        if line.startswith(("hsr ", "make ", "python ", "pytest", "sudo "))
    ]


def skipped(command: str) -> bool:
    return command.startswith(tuple(NOT_RUN))


def build(folder: Path) -> Path:
    """Build both distributions and hold the wheel's content to what is tracked."""
    subprocess.run([sys.executable, "-m", "build", "--outdir", folder, ROOT], check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    placed = project["tool"]["hatch"]["build"]["targets"]["wheel"].get("force-include", {})
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    want = {name for name in tracked.splitlines() if name.startswith("hsr/")}
    for source, target in placed.items():
        want |= {
            name.replace(source, target, 1) for name in tracked.splitlines() if name.startswith(f"{source}/")
        }
    names = {name for name in ZipFile(wheel).namelist() if ".dist-info/" not in name}
    licences = [name for name in ZipFile(wheel).namelist() if name.endswith("licenses/LICENSE")]
    assert names == want, f"the wheel lacks {sorted(want - names)}, and has {sorted(names - want)}"
    assert licences and {"hsr/py.typed", "hsr/pages/templates/frame.html"} <= names
    print(f"{wheel.name}: {len(names)} files, {wheel.stat().st_size / 1e6:.1f} MB")
    return wheel


def python_of(version: str) -> str | None:
    """Find a Python that starts."""
    pyenv = Path(os.environ.get("PYENV_ROOT", "~/.pyenv")).expanduser()
    for path in (*pyenv.glob(f"versions/{version}.*/bin/python"), shutil.which(f"python{version}")):
        if path and not subprocess.run([path, "-c", ""], capture_output=True).returncode:
            return str(path)
    return None


def installed(version: str, wheel: Path, folder: Path) -> Path | None:
    """Make an environment with the wheel; tell why not if that Python or a dependency's wheel is missing."""
    python = python_of(version)
    if python is None:
        print(f"{version}: not tried, there is none here")
        return None
    subprocess.run([python, "-m", "venv", folder], check=True)
    pip = [folder / "bin" / "python", "-m", "pip", "install", "-q", "--disable-pip-version-check"]
    done = subprocess.run(
        [*pip, "--no-compile", "--only-binary=:all:", f"{wheel}[embree]", "pytest"],
        capture_output=True,
        text=True,
    )
    if done.returncode:
        print(f"{version}: not tried, not all dependencies have wheels\n{done.stderr}")
        return None
    return folder / "bin"


def steps(bins: Path) -> Iterator[tuple[str, list[str]]]:
    """Name everything that is run, and its words."""
    yield "what the reader has", [str(bins / "python"), "-c", READER]
    for command in (*PREPARE, *(command for command in commands() if not skipped(command))):
        yield command, ["bash", "-c", command]
    for number, snippet in enumerate(fenced("python"), 1):
        yield f"snippet {number}", [str(bins / "python"), "-c", snippet]


def failures(bins: Path, folder: Path) -> list[str]:
    """Run everything in a folder; return what did not run."""
    shutil.copytree(ROOT / "scenes", folder / "scenes")
    (folder / "scene.toml").write_text(fenced("toml")[0], encoding="utf-8")
    (folder / "test_mine.py").write_text(
        next(one for one in fenced("py") if "def test_" in one), encoding="utf-8"
    )
    env = {
        name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "CI", "NUMBA"))
    }
    env["PATH"] = f"{bins}{os.pathsep}{env['PATH']}"
    failed = []
    for name, words in steps(bins):
        start = time.perf_counter()
        done = subprocess.run(words, cwd=folder, env=env, capture_output=True, text=True)
        good = done.returncode == 0 or (done.returncode == 1 and name.startswith(MAY_DIFFER))
        print(f"  {'ok' if good else 'FAILED':6} {time.perf_counter() - start:6.1f} s  {name}", flush=True)
        if not good:
            failed.append(name)
            print(f"exit code {done.returncode}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
    return failed


def main(versions: list[str]) -> int:
    """Run the proof; return the exit code."""
    failed: list[str] = []
    tried = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        wheel = build(folder)
        for version in versions or PYTHONS:
            if not versions and tried and version != OLDEST:
                print(f"{version}: not tried, lies between")
                continue
            bins = installed(version, wheel, folder / version)
            if bins is None:
                continue
            tried.append(version)
            print(f"{version}:")
            (folder / f"reader{version}").mkdir()
            failed += failures(bins, folder / f"reader{version}")
    for command in filter(skipped, commands()):
        print(
            f"not run, {next(why for start, why in NOT_RUN.items() if command.startswith(start))}: {command}"
        )
    print(f"tried on {sys.platform} with Python {', '.join(tried)}: {len(failed)} failed")
    return int(bool(failed) or OLDEST not in (versions or tried) or not tried)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
