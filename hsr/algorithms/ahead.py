"""Kernels compiled by a second process, while the first goes on with what needs none of them.

That process runs ``python -m hsr.algorithms.ahead SCENE METHOD...``.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from hsr.algorithms.registry import Method, method_named
from hsr.base.jit import is_compiled
from hsr.problem.view import load, view

LONG = ("zbuffer", "raycast")
"""What takes half of all the time, most of it for kernels that both share."""


class Ahead:
    """Methods whose kernels another process compiles.

    Parameters
    ----------
    scene : Path
        By which they are compiled.
    methods : iterable of str
        All that will run.
    """

    def __init__(self, scene: Path, methods: Iterable[str]) -> None:
        wanted = {*methods}
        self.cold = [name for name in LONG if name in wanted and not is_compiled(name)]
        self.process: subprocess.Popen[bytes] | None = None
        # Alone, they would have to be waited for.
        if self.cold and wanted - {*LONG} and (os.cpu_count() or 1) > 1:
            command = [sys.executable, "-m", __name__, str(scene), *self.cold]
            self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def __enter__(self) -> Ahead:
        return self

    def __exit__(self, *_: object) -> None:
        """End what nobody waits for any more; each kernel is kept as soon as it is compiled."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()

    def order(self, methods: Sequence[Method]) -> list[Method]:
        """Put what is being compiled elsewhere last."""
        return sorted(methods, key=lambda method: method.name in self.cold)

    def wait(self, method: Method) -> None:
        """Wait for the kernels of a method; if compiling fails there, it will do so here, and be told."""
        if self.process is not None and method.name in self.cold:
            self.process.wait()


def main(scene: str, *names: str) -> None:
    """Compile the kernels of methods by drawing a tiny picture of a scene."""
    problem = view(load(scene), (1, 1))
    for name in names:
        method_named(name).warm_up(problem)


if __name__ == "__main__":
    main(*sys.argv[1:])
