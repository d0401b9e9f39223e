"""The decorators, and the care for their cache."""

from __future__ import annotations

import os
import subprocess
import sys
from multiprocessing import get_context
from pathlib import Path
from subprocess import run

import numpy as np
import pytest
from numba.np.ufunc.parallel import threading_layer

from hsr.base.errors import HsrError
from hsr.base.jit import forget_stale_kernels, jit, parallel_jit, prange


@jit
def difference_of_products(a: float, b: float, c: float, d: float) -> float:
    return a * b - c * d


@jit
def quotient(a: float, b: float) -> float:
    return a / b


@parallel_jit
def doubled(values: np.ndarray) -> np.ndarray:
    result = np.empty_like(values)
    for i in prange(len(values)):
        result[i] = 2.0 * values[i]
    return result


def test_products_are_rounded_before_they_are_subtracted() -> None:
    # A fused operation would leave the rounding error of the other product: 2**-54.
    x = 1.0 + 2.0**-27
    assert difference_of_products(x, x, x, x) == 0.0


def test_division_by_zero_is_infinite() -> None:
    with np.errstate(divide="ignore"):
        assert quotient(np.float64(1.0), np.float64(0.0)) == np.inf


def test_parallel_loops() -> None:
    assert doubled(np.arange(5.0)).tolist() == [0.0, 2.0, 4.0, 6.0, 8.0]


@pytest.mark.jit
@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are not forked here")
def test_a_forked_process_says_at_once_that_it_lacks_threads() -> None:
    doubled(np.arange(2.0))
    with get_context("fork").Pool(1) as pool:
        if threading_layer() == "omp":
            with pytest.raises(HsrError, match="'spawn'"):
                pool.apply_async(doubled, (np.arange(2.0),)).get(timeout=60)
        else:
            assert pool.apply_async(doubled, (np.arange(2.0),)).get(timeout=60).tolist() == [0.0, 2.0]
        assert pool.apply_async(quotient, (1.0, 2.0)).get(timeout=60) == 0.5


TOGETHER = """
from concurrent.futures import ThreadPoolExecutor
import numba, numpy as np
from tests.base.test_jit import doubled

with ThreadPoolExecutor(4) as pool:
    for found in pool.map(doubled, [np.arange(20000.0)] * 400):
        assert found[-1] == 39998.0
print(numba.threading_layer())
"""


@pytest.mark.jit
def test_threads_may_use_kernels_at_once_whatever_makes_their_threads() -> None:
    environment = os.environ | {"NUMBA_THREADING_LAYER": "workqueue", "NUMBA_NUM_THREADS": "2"}
    told = run([sys.executable, "-c", TOGETHER], env=environment, capture_output=True, text=True, check=True)
    assert told.stdout.strip() == "workqueue"


def test_a_changed_source_drops_the_cached_kernels_that_are_made_of_it(tmp_path: Path) -> None:
    text = {
        "kernels/edges": "BOUND = 1\n\n\n@jit\ndef kernel(): ...\n",
        "kernels/spans": "from hsr.kernels.edges import BOUND\n\n\n@jit\ndef kernel(): ...\n",
        "exact/filter": "from hsr.kernels.spans import kernel\n\n\n@jit\ndef visit(): ...\n",
        "exact/depths": "@jit\ndef kernel(): ...\n",
    }
    cached = {}
    for name, source in text.items():
        file = tmp_path / f"{name}.py"
        cached[name] = file.parent / "__pycache__" / f"{file.stem}.kernel-12.py311.1.nbc"
        cached[name].parent.mkdir(parents=True, exist_ok=True)
        file.write_text(source, encoding="utf-8")

    def left() -> list[str]:
        forget_stale_kernels(tmp_path)
        found = [name for name, file in cached.items() if file.exists()]
        for file in cached.values():
            file.write_bytes(b"compiled")
        return found

    assert left() == []
    assert left() == [*text]
    (tmp_path / "kernels" / "edges.py").write_text(
        "BOUND = 2\n\n\n@jit\ndef kernel(): ...\n", encoding="utf-8"
    )
    assert left() == ["exact/depths"]
    (tmp_path / "exact" / "filter.py").write_text(text["exact/filter"] + "\n", encoding="utf-8")
    assert left() == ["kernels/edges", "kernels/spans", "exact/depths"]
    assert left() == [*text]


@pytest.mark.parametrize("stamp", [None, '{"kernels/ed', "[]"])
def test_kernels_of_which_nobody_knows_what_they_are_made_of_are_dropped(
    tmp_path: Path, stamp: str | None
) -> None:
    source = tmp_path / "kernels" / "edges.py"
    cached = tmp_path / "kernels" / "__pycache__" / "edges.kernel-12.py311.1.nbc"
    cached.parent.mkdir(parents=True)
    source.write_text("@jit\ndef kernel(): ...\n", encoding="utf-8")
    cached.write_bytes(b"compiled")
    if stamp is not None:
        cached.with_name("sources.json").write_text(stamp, encoding="ascii")
    forget_stale_kernels(tmp_path)
    assert not cached.exists()
    cached.write_bytes(b"compiled")
    forget_stale_kernels(tmp_path)
    assert cached.exists()


def test_a_folder_that_cannot_be_written_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "kernels").mkdir()
    (tmp_path / "kernels" / "__pycache__").write_text("a file in the way", encoding="utf-8")
    forget_stale_kernels(tmp_path)


# ---------------------------------------------------------------- a cache that does not work

USED = """
import os
import subprocess
import sys
from pathlib import Path
from kernel import twice
print(twice(4), *sorted(file.suffix for file in Path("cache").rglob("*.nb*")))
"""


def used(folder: Path, **environment: str) -> tuple[str, str]:
    """Run a kernel in a process of its own; return what it prints, and its complaints."""
    source = "from hsr.base.jit import jit\n\n\n@jit\ndef twice(x):\n    return 2 * x\n"
    (folder / "kernel.py").write_text(source, encoding="utf-8")
    environment = {**os.environ, "NUMBA_CACHE_DIR": "cache", "PYTHONDONTWRITEBYTECODE": "1", **environment}
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, '.')\n{USED}"]
    run = subprocess.run(command, capture_output=True, text=True, check=True, env=environment, cwd=folder)
    return run.stdout, run.stderr


def test_damaged_kernels_are_compiled_again(tmp_path: Path) -> None:
    assert used(tmp_path) == ("8 .nbc .nbi\n", "")
    for ending in ("nbi", "nbc"):
        for content in (b"", b"no kernel", None):
            (file,) = (tmp_path / "cache").rglob(f"*.{ending}")
            file.write_bytes(file.read_bytes()[:-9] if content is None else content)
            assert used(tmp_path) == ("8 .nbc .nbi\n", "")


def test_where_nothing_can_be_kept_kernels_run_all_the_same(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    # Numba tries the folder that is named, the one of the source, and the user's.
    classes = "UserProvidedCacheLocator"
    shown, told = used(tmp_path, NUMBA_CACHE_DIR="file/cache", NUMBA_CACHE_LOCATOR_CLASSES=classes)
    assert shown == "8\n"
    assert told.startswith("hsr: compiled kernels cannot be kept") and told.count("\n") == 1
