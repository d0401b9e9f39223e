"""The command ``hsr shrink``: the smallest scene in which two methods still disagree."""

from __future__ import annotations

from typing import Annotated

import typer

import hsr
from hsr.cli import common as cli
from hsr.cli.cameras import Cameras, with_cameras


@with_cameras
def shrink(
    scene: cli.SceneFile,
    sample: cli.Sample,
    a: Annotated[str, typer.Option("-a", help="One method.")],
    b: Annotated[str, typer.Option("-b", help="The other.")],
    output: cli.SceneOutput = None,
    size: cli.Size = "512x512",
    as_json: cli.Json = False,
    *,
    cameras: Cameras,
) -> None:
    """Find the smallest scene in which two methods still disagree at a sample.

    For example:

        hsr shrink solids 221,320 -a opengl -b zbuffer -o small.toml
    """
    from hsr.difference.shrink import shrink as smallest
    from hsr.scene.writing import to_toml, write_scene

    loaded = cameras.one(hsr.load(scene))
    column, row = cli.parse_sample(sample, hsr.view(loaded, cli.parse_size(size)))
    found = smallest(loaded, a, b, cli.parse_size(size), x=column, y=row)
    if output is not None:
        write_scene(found.scene, output)
    if as_json:
        facts = {"faces": len(found.faces), "shown": dict(zip((a, b), found.shown, strict=True))}
        sample_at = {"x": column, "y": row}
        cli.print_json("shrink", {"sample": sample_at, **facts, "scene": to_toml(found.scene)})
    elif output is None:
        print(to_toml(found.scene), end="")
    else:
        kept = "1 face" if len(found.faces) == 1 else f"{len(found.faces)} faces"
        cli.say(f"wrote {output}: {kept} left; {a} shows {found.shown[0]}, {b} {found.shown[1]}")
