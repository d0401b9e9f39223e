"""The README leads to the code: every link of its table holds, and every recipe works as written."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")

LINK = re.compile(r"^\| (.+) \| \[`(.+)`\]\((.+)\)(?: `(\w+)`)? \|$", re.MULTILINE)
RECIPE = re.compile(
    r"```(?:py|text|html)\n(?:# |\{# )(hsr/[\w/.]+)(?:, (in|before) (\w+))?(?: #\})?\n(.*?)```",
    re.DOTALL,
)


@pytest.mark.parametrize(("words", "shown", "path", "name"), LINK.findall(README))
def test_the_words_of_the_textbook_lead_to_the_code(words: str, shown: str, path: str, name: str) -> None:
    assert path == f"hsr/{shown}", words
    tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
    assert not name or name in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}, words


def test_the_table_is_there() -> None:
    assert len(LINK.findall(README)) >= 20


@pytest.mark.parametrize("kernel", ["culling", "scanline", "rays", "hits"])
def test_the_textbooks_kernels_are_short(kernel: str) -> None:
    assert len((ROOT / "hsr" / "kernels" / f"{kernel}.py").read_text(encoding="utf-8").splitlines()) <= 200


@pytest.fixture(scope="module")
def changed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Follow all recipes of the README in a copy of the package."""
    copy = tmp_path_factory.mktemp("copy")
    shutil.copytree(ROOT / "hsr", copy / "hsr", ignore=shutil.ignore_patterns("__pycache__"))
    recipes = RECIPE.findall(README)
    assert len(recipes) == 7
    for path, where, name, text in recipes:
        file = copy / path
        if where:
            file.write_text(inserted(file.read_text(encoding="utf-8"), where, name, text), encoding="utf-8")
        else:
            assert not file.exists()
            file.write_text(text, encoding="utf-8")
    return copy


def inserted(source: str, where: str, name: str, text: str) -> str:
    """Put a text before a name's statement, or into its literal."""
    body = ast.parse(source).body
    (place,) = [node for node in body if re.search(rf"^ *{name}(?: =|:)", ast.unparse(node), re.MULTILINE)]
    at = (place.lineno if where == "before" else place.end_lineno or 0) - 1
    lines = source.splitlines(keepends=True)
    return "".join([*lines[:at], text, "\n", *lines[at:]])


def run(copy: Path, code: str, ends: int = 0) -> str:
    env = {**os.environ, "PYTHONPATH": str(copy), "NUMBA_DISABLE_JIT": "1", "NO_COLOR": "1"}
    done = subprocess.run([sys.executable, "-c", code], cwd=copy, env=env, capture_output=True, text=True)
    assert done.returncode in (0, ends), done.stderr
    return done.stdout


def test_a_new_method_is_in_the_tables(changed: Path) -> None:
    assert "nothing" in run(changed, "import sys; from hsr.cli import main; sys.argv[1:] = ['algos']; main()")
    shown = run(
        changed,
        "import hsr\n"
        "scene = hsr.Scene.model_validate({'hsr': 1, 'camera': [{'type': 'perspective', 'eye': [2, 2, 4]}],\n"
        "    'object': [{'name': 'cube', 'shape': 'cube'}]})\n"
        "print(hsr.render(scene, 'nothing', size=(4, 3)).face.max())",
    )
    assert shown == "-1\n"


def test_a_new_method_is_compared(changed: Path) -> None:
    scenes = [str(ROOT / "scenes" / f"{name}.toml") for name in ("cube", "cyclic")]
    words = ["compare", *scenes, "-a", "nothing", "--ref", "backface", "--size", "8"]
    assert "nothing" in run(
        changed, f"import sys; from hsr.cli import main; sys.argv[1:] = {words}; main()", 1
    )


def test_a_new_shape_is_seen(changed: Path) -> None:
    shown = run(
        changed,
        "import hsr\n"
        "scene = hsr.Scene.model_validate({'hsr': 1, 'camera': [{'type': 'perspective', 'eye': [2, 3, 4]}],\n"
        "    'object': [{'name': 'gem', 'shape': 'octahedron', 'cull': 'back'}]})\n"
        "print(sorted(set(hsr.render(scene, 'exact', size=(24, 24)).face.ravel().tolist())))",
    )
    assert shown == "[-1, 0, 1, 3]\n"


def test_a_new_hard_case_is_a_family_that_breaks_where_it_says(changed: Path) -> None:
    shown = run(
        changed,
        "from hsr.lab.stability.cases import family_named\n"
        "from hsr.lab.stability.judge import judge\n"
        "result = judge(family_named('half-a-picture'), quick=True, asked=('scanline-snap-4',))\n"
        "print([row.verdict.name for row in result.rows])",
    )
    assert shown == "['AS_PREDICTED']\n"


def test_a_new_page_stands_in_the_frame(changed: Path) -> None:
    page = run(changed, "from hsr.pages.greeting import greeting; print(greeting())")
    assert "<h1>Which surface does the eye see?</h1>" in page and "default-src &#39;none&#39;" in page
