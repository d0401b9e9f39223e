"""How long a newcomer waits: the first picture, a comparison, a render; kernels to compile, and compiled.

    python benchmarks/first_minute.py [-o benchmarks/results/first-minute.md]

Each command runs in a process of its own. *Cold* finds no compiled kernel and no kept result; *warm* finds
kernels, and computes all results anew; *again* finds results, too.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path

from hsr.base.files import write_whole
from hsr.lab.machine import commit, machine

ROOT = Path(__file__).parents[1]
SCENE = str(ROOT / "scenes" / "solids.toml")
COMMANDS = {
    "render by zbuffer": ["render", SCENE, "-a", "zbuffer"],
    "compare, with its page": ["compare", SCENE, "-o", "{folder}/page.html"],
}
FRESH = {"compare": ["--fresh"]}


def main() -> None:
    """Time the commands, and print or write the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("-o", "--output", type=Path)
    chosen = parser.parse_args()
    table = "\n".join(lines())
    if chosen.output:
        write_whole(chosen.output, table + "\n", "the table")
    print(table)


def lines() -> Iterator[str]:
    """Yield the lines of the table."""
    here = machine()
    versions = ", ".join(f"{name} {told}" for name, told in here.versions.items())
    yield f"# The first minute\n\n{here.cpu}, {here.processors} processors; commit {commit()}; {versions}.\n"
    yield "| | cold [s] | warm [s] | again [s] |\n|---|---:|---:|---:|"
    for name, command in COMMANDS.items():
        with tempfile.TemporaryDirectory() as folder:
            times = [f"{seconds:.1f}" for seconds in turns(folder, command)]
        yield f"| {name} | {' | '.join(times)} |"
    with tempfile.TemporaryDirectory() as folder:
        first, whole = demo(folder)
    yield f"\n`hsr demo`, cold: the first picture after {first:.1f} s, all methods after {whole:.1f} s."


def turns(folder: str, command: list[str]) -> Iterator[float]:
    """Yield the seconds of a command, cold, warm and again."""
    told = [part.format(folder=folder) for part in command]
    for more in ([], FRESH.get(command[0], []), []):
        start = time.perf_counter()
        run(folder, *told, *more).wait()
        yield time.perf_counter() - start


def demo(folder: str) -> tuple[float, float]:
    """Return the seconds until the demo's page has its first picture, and until it is whole."""
    page, start = Path(folder) / "demo.html", time.perf_counter()
    first: list[float] = []

    def watch() -> None:
        while not first:
            time.sleep(0.05)
            if page.exists() and "data:image" in page.read_text(encoding="utf-8"):
                first.append(time.perf_counter() - start)

    threading.Thread(target=watch, daemon=True).start()
    run(folder, "demo", SCENE, "--no-browse", "-o", str(page)).wait()
    return first[0], time.perf_counter() - start


def run(folder: str, *arguments: str) -> subprocess.Popen[bytes]:
    """Start the command with a cache and a store of its own."""
    places = {"NUMBA_CACHE_DIR": f"{folder}/kernels", "HSR_STORE": f"{folder}/store"}
    command = [sys.executable, "-c", "from hsr.cli import main; main()", *arguments]
    nowhere = subprocess.DEVNULL
    return subprocess.Popen(command, env=os.environ | places, stdout=nowhere, stderr=nowhere)


if __name__ == "__main__":
    main()
