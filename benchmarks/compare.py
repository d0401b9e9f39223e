"""Compare algorithms: scenes or mesh files x methods x sizes, fairly timed.

    python benchmarks/compare.py scenes/teapot.toml bunny.obj -a zbuffer -a raycast -a opengl --size 1024

Every method gets the same view, and nothing is timed that is not judged: the first map of each is held
against exact arithmetic, its wrong samples counted by cause. Then the methods take turns, so that a drift
of the machine touches all alike, and the median of every stage is reported. Each turn gets a view of its
own, so nothing prepared in an earlier turn is reused: ``prepare`` (arrays, upload), ``build``
(hierarchies) and ``render`` are measured anew each time.
"""

from __future__ import annotations

import json
import platform
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from statistics import median, quantiles
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.progress import track
from rich.table import Table

import hsr
from hsr.errors import HsrError, MethodError, UnavailableError
from hsr.viewing import View

STAGES = ("prepare", "build", "render", "read")
DEFAULT = ("scanline", "zbuffer", "scanline-float32", "raycast", "opengl", "embree")

console = Console(highlight=False, width=None if sys.stdout.isatty() else 130)


def fresh(view: View) -> View:
    """Return an equal view that shares nothing a method may have cached on the old one."""
    shapes = {id(p.shape): replace(p.shape) for p in view.placements}
    return replace(view, placements=tuple(replace(p, shape=shapes[id(p.shape)]) for p in view.placements))


def measure(view: View, methods: Sequence[str], repeat: int, label: str) -> Iterator[dict[str, Any]]:
    """Judge the methods on one view, then time them in turns; yield one row a method."""
    truth = hsr.render(view, "exact")
    judged, skipped = {}, {}
    for name in methods:
        try:
            judged[name] = hsr.causes(view, hsr.render(view, name), truth)
        except (UnavailableError, MethodError) as error:
            skipped[name] = str(error)
    samples: dict[str, list[dict[str, float]]] = {name: [] for name in judged}
    for _ in track(range(repeat), description=label, console=Console(stderr=True), transient=True):
        for name in judged:
            samples[name].append(hsr.render(fresh(view), name).seconds)
    for name in methods:
        if name in skipped:
            yield {"method": name, "skipped": skipped[name]}
            continue
        stages = {stage: _spread([one[stage] for one in samples[name] if stage in one]) for stage in STAGES}
        yield {"method": name, "wrong": judged[name].wrong, "causes": judged[name].counts} | stages


def _spread(seconds: Sequence[float]) -> dict[str, Any] | None:
    """Milliseconds: median, quartiles, minimum and all samples."""
    if not seconds:
        return None
    low, _, high = quantiles(seconds, n=4) if len(seconds) > 1 else (seconds[0],) * 3
    figures = {"median": median(seconds), "q1": low, "q3": high, "min": min(seconds)}
    milliseconds = {name: round(1e3 * value, 4) for name, value in figures.items()}
    return milliseconds | {"samples": [round(1e3 * value, 4) for value in seconds]}


def machine() -> dict[str, Any]:
    """What the figures were measured on."""
    import numba

    cpu = next(
        (
            line.split(":")[1].strip()
            for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
            if line.startswith("model name")
        ),
        platform.processor(),
    )
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "cpu": cpu,
        "threads": numba.get_num_threads(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": numba.__version__,
        "hsr": hsr.__version__,
    }


def show(rows: Sequence[dict[str, Any]]) -> None:
    """Print the rows as one table, milliseconds by stage."""
    table = Table(box=None, pad_edge=False)
    for column in ("scene", "faces", "size", "method"):
        table.add_column(column)
    for column in (*STAGES, "render q1-q3", "wrong"):
        table.add_column(column, justify="right")
    for row in rows:
        head = (row["scene"], f"{row['faces']:,}", row["size"], row["method"])
        if "skipped" in row:
            table.add_row(*head, f"[dim]{row['skipped']}[/dim]")
            continue
        stages = ["" if row[stage] is None else f"{row[stage]['median']:.2f}" for stage in STAGES]
        spread = f"{row['render']['q1']:.2f}-{row['render']['q3']:.2f}"
        table.add_row(*head, *stages, spread, f"{row['wrong']:,}")
    console.print(table)


def markdown(rows: Sequence[dict[str, Any]]) -> str:
    """Return the medians as the table of the README."""
    lines = [
        "| mesh | method | build ms | render ms | against OpenGL | wrong samples | why |",
        "|---|---|---:|---:|---:|---:|---|",
    ]
    opengl = {row["scene"]: row["render"]["median"] for row in rows if row["method"] == "opengl"}
    for row in rows:
        build = "" if row["build"] is None else f"{row['build']['median']:.1f}"
        render = row["render"]["median"]
        faster = f"{opengl[row['scene']] / render:.1f}x" if row["scene"] in opengl else ""
        name = f"{row['scene']}, {row['faces']:,} triangles"
        why = ", ".join(f"{cause} {count}" for cause, count in row["causes"].items())
        figures = f"{build} | {render:.1f} | {faster} | {row['wrong']:,} | {why}"
        lines.append(f"| {name} | {row['method']} | {figures} |")
    return "\n".join(lines)


def main(
    scenes: Annotated[list[Path], typer.Argument(help="Scenes or mesh files.")],
    method: Annotated[list[str] | None, typer.Option("--method", "-a", help="Method, repeatable.")] = None,
    size: Annotated[list[int] | None, typer.Option("--size", help="Side in pixels, repeatable.")] = None,
    repeat: Annotated[int, typer.Option("--repeat", min=1, help="Turns of every method.")] = 15,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Write JSON.")] = None,
    as_markdown: Annotated[bool, typer.Option("--markdown", help="Print the table of the README.")] = False,
) -> None:
    """Compare algorithms on scenes or meshes."""
    try:
        loaded = [(path, hsr.load(path)) for path in scenes]
        rows = []
        for path, scene in loaded:
            for side in size or [512]:
                view = hsr.view(scene, (side, side))
                head = {"scene": path.stem, "faces": view.faces, "size": f"{side}x{side}"}
                label = f"{path.stem} {side}x{side}"
                rows += [head | row for row in measure(view, method or DEFAULT, repeat, label)]
    except HsrError as error:
        typer.echo(f"compare.py: {error}", err=True)
        raise typer.Exit(2) from None
    if as_markdown:
        print(markdown([row for row in rows if "skipped" not in row]))
    else:
        show(rows)
    if output is not None:
        output.write_text(json.dumps({"hsr": 1, "machine": machine(), "rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    typer.run(main)
