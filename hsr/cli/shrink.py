"""The command ``hsr shrink``: the smallest scene in which two methods still disagree."""

from __future__ import annotations

from typing import Annotated

import typer

import hsr
from hsr.cli import common as cli


def shrink(
    scene: cli.SceneFile,
    sample: cli.Sample,
    a: Annotated[str, typer.Option("-a", help="One method.")],
    b: Annotated[str, typer.Option("-b", help="The other.")],
    output: cli.SceneOutput = None,
    size: cli.Size = "512x512",
    camera: cli.CameraName = None,
    as_json: cli.Json = False,
) -> None:
    """Find the smallest scene in which two methods still disagree at a sample."""
    from hsr.difference.shrink import shrink as smallest
    from hsr.scene.writing import to_toml, write_scene

    loaded = hsr.load(scene)
    column, row = cli.parse_sample(sample, hsr.view(loaded, cli.parse_size(size), camera))
    found = smallest(loaded, row, column, a, b, cli.parse_size(size), camera)
    if output is not None:
        write_scene(found.scene, output)
    if as_json:
        facts = {"faces": len(found.faces), "shown": dict(zip((a, b), found.shown, strict=True))}
        cli.print_json({"hsr": 1, "sample": [column, row], **facts, "scene": to_toml(found.scene)})
    elif output is None:
        print(to_toml(found.scene), end="")
    else:
        kept = "1 face" if len(found.faces) == 1 else f"{len(found.faces)} faces"
        cli.say(f"wrote {output}: {kept} left; {a} shows {found.shown[0]}, {b} {found.shown[1]}")
