"""Compare methods on scenes or meshes, fairly timed: a script to copy and change.

    python benchmarks/compare.py scenes/teapot.toml bunny.obj -a zbuffer -a raycast -a opengl --size 1024

``hsr bench`` does the same and more; this shows how to do it from Python. Every method gets the same view,
the first map of each is judged by exact arithmetic, and then they take turns.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

import hsr
from hsr.lab.publish import publish, to_markdown
from hsr.lab.speed import make_case, measure


def main(
    scenes: Annotated[list[Path], typer.Argument(help="Scenes or mesh files.")],
    method: Annotated[list[str] | None, typer.Option("--method", "-a", help="Method, repeatable.")] = None,
    size: Annotated[int, typer.Option("--size", help="Side in pixels.")] = 512,
    repeat: Annotated[int, typer.Option("--repeat", min=3, help="Turns of every method.")] = 15,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Folder to write.")] = None,
) -> None:
    """Compare methods on scenes or meshes."""
    try:
        cases = [make_case(path.stem, hsr.load(path), (size, size)) for path in scenes]
        results = measure(cases, method or ["scanline", "zbuffer", "raycast", "opengl"], repeat)
        if output is not None:
            publish(results, output)
    except hsr.HsrError as error:
        sys.exit(f"compare.py: {error}")
    print(to_markdown(results))


if __name__ == "__main__":
    typer.run(main)
