"""The command ``hsr render``: one scene by some methods, as maps and pictures."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

from typer import Argument, Option

import hsr
from hsr.cli import common as cli


def render(
    scene: Annotated[Path, Argument(help="Scene (TOML, JSON) or mesh file.")],
    method: cli.Methods = None,
    size: cli.Size = "512x512",
    camera: cli.CameraName = None,
    output: Annotated[Path | None, cli.output("Write the map, .npz.")] = None,
    png: Annotated[Path | None, Option(help="Write the shaded picture.")] = None,
    as_json: cli.Json = False,
    quiet: cli.Quiet = False,
    verbose: cli.Verbose = False,
) -> None:
    """Render one scene and say what is seen.

    With several methods the files are named after them: map.npz becomes map.zbuffer.npz.
    """
    from hsr.algorithms.registry import method_named

    cli.check_folder(output)
    cli.check_folder(png)
    view = hsr.view(hsr.load(scene), cli.parse_size(size), camera)
    names = method or ["zbuffer"]
    rows = []
    with cli.progress(quiet, len(names)) as step:
        for name in names:
            step(name)
            method_named(name).warm_up(view)
            answer = hsr.render(view, name)
            files = list(_written(view, answer, output, png, several=len(names) > 1))
            rows.append(_summary(answer) | {"files": files})
    if as_json:
        cli.print_json({"hsr": 1, "scene": str(scene), "maps": rows})
    else:
        _print(rows, verbose)


def _written(
    view: hsr.View, answer: hsr.VisibilityMap, output: Path | None, png: Path | None, several: bool
) -> Iterator[str]:
    """Write what was asked for; of several methods each file carries its method's name."""

    def save_shaded(path: Path) -> None:
        from hsr.pages.shading import shade
        from hsr.pictures.png import save_picture

        save_picture(shade(answer, view), path)

    for path, write in ((output, answer.save), (png, save_shaded)):
        if path is not None:
            named = path.with_name(f"{path.stem}.{answer.method}{path.suffix}") if several else path
            write(named)
            yield str(named)


def _summary(answer: hsr.VisibilityMap) -> dict[str, Any]:
    import numpy as np

    covered = answer.face >= 0
    size, nearest = [answer.width, answer.height], float(answer.depth.min()) if covered.any() else None
    faces = len(np.unique(answer.face[covered]))
    seen = {"size": size, "covered": int(covered.sum()), "faces_seen": faces, "nearest": nearest}
    made = {"seconds": answer.seconds, "work": answer.work, "notes": answer.notes}
    return {"method": answer.method, **seen, **made}


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    share = f"{row['covered'] / (row['size'][0] * row['size'][1]):.1%}"
    nearest = "-" if row["nearest"] is None else f"{row['nearest']:.6g}"
    return (row["method"], share, f"{row['faces_seen']:,}", nearest, cli.milliseconds(row["seconds"]))


def _print(rows: list[dict[str, Any]], verbose: bool) -> None:
    """Print one row a map, and what was written."""
    cli.print_table(("method", "covered", "faces seen", "nearest", "render"), map(_cells, rows))
    for row in rows:
        work = ", ".join(f"{name} {count:,}" for name, count in row["work"].items())
        told = [f"{row['method']}: {work}"] if verbose else []
        cli.say(*told, *(f"wrote {file}" for file in row["files"]))
