"""The command ``hsr render``: one scene by some methods, as maps and pictures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import hsr
from hsr.cli import common as cli
from hsr.cli.cameras import Cameras, with_cameras


@with_cameras
def render(
    scene: cli.SceneFile,
    method: cli.Methods = None,
    size: cli.Size = "512x512",
    output: Annotated[Path | None, cli.output("Write the map, .npz.", ".npz")] = None,
    png: Annotated[Path | None, cli.output("Write the shaded picture, .png.", ".png", name="--png")] = None,
    as_json: cli.Json = False,
    quiet: cli.Quiet = False,
    verbose: cli.Verbose = False,
    *,
    cameras: Cameras,
) -> None:
    """Render one scene and say what is seen.

    With several methods or cameras the files are named after them: map.npz becomes map.zbuffer.npz.

    For example:

        hsr render teapot --png teapot.png
        hsr render bunny.obj -a zbuffer -a raycast --eye 2,2,4 -o map.npz
        hsr render solids --orbit 8 --parallel 4 --png around.png --size 640x480
    """
    from hsr.algorithms.registry import method_named
    from hsr.difference.nothing import why_nothing

    names, seen = method or ["zbuffer"], cameras.scenes("", hsr.load(scene))
    views = [(one.camera[0].name, hsr.view(one, cli.parse_size(size))) for _, one in seen]
    rows = []
    with cli.progress(quiet, len(names) * len(views)) as step:
        for (camera, view), name in product(views, names):
            step(name)
            method_named(name).warm_up(view)
            answer = hsr.render(view, name)
            parts = [camera.replace("/", "-")] * (len(views) > 1) + [name] * (len(names) > 1)
            files = [str(file) for file in _written(view, answer, output, png, parts)]
            nothing = why_nothing(view, name) if (answer.face < 0).all() else None
            rows.append({"camera": camera, **_summary(answer), "nothing": nothing, "files": files})
    if as_json:
        cli.print_json("render", {"scene": str(scene), "maps": rows})
    else:
        _print(rows, verbose)


def _written(
    view: hsr.View, answer: hsr.VisibilityMap, output: Path | None, png: Path | None, parts: Sequence[str]
) -> Iterator[Path]:
    """Write what was asked for, with these parts in the names of the files."""

    def save_shaded(path: Path) -> None:
        from hsr.pages.shading import shade
        from hsr.pictures.png import save_picture

        save_picture(shade(answer, view), path)

    for path, write in ((output, answer.save), (png, save_shaded)):
        if path is not None:
            named = path.with_name(".".join([path.stem, *parts]) + path.suffix)
            write(named)
            yield named


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
    seen = (share, f"{row['faces_seen']:,}", nearest, cli.milliseconds(row["seconds"]))
    return (row["camera"], row["method"], *seen)


def _print(rows: list[dict[str, Any]], verbose: bool) -> None:
    """Print one row a map, and what was written."""
    head = ("camera", "method", "covered", "faces seen", "nearest", "render")
    told = slice(0 if len({row["camera"] for row in rows}) > 1 else 1, None)
    cells = [_cells(row)[told] for row in rows]
    cli.print_table(head[told], cells, right=head[2:], least=("nearest", "faces seen"))
    for row in rows:
        work = ", ".join(f"{name} {count:,}" for name, count in row["work"].items())
        lines = [f"{row['method']}: {work}"] if verbose else []
        lines += [f"nothing is seen by {row['camera']}: {row['nothing']}"] if row["nothing"] else []
        cli.say(*lines, *(f"wrote {file}" for file in row["files"]))
