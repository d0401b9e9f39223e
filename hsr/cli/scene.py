"""The command ``hsr scene``: scene files checked and described."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Annotated

from typer import Argument, Exit, Typer

import hsr
from hsr.base.errors import SceneError
from hsr.base.files import write_whole
from hsr.cli import common as cli
from hsr.cli.cameras import Cameras, with_cameras
from hsr.scene.names import printable

SchemaFile = Annotated[Path | None, Argument(help="File to write; standard output by default.")]

scene_app = Typer(help="Check, describe and export scene files.", no_args_is_help=True)


@scene_app.command()
def init(mesh: cli.SceneFile, output: cli.SceneOutput = None) -> None:
    """Write a scene file for a mesh, with a comment on every key: to be edited.

    For example:

        hsr scene init bunny.obj -o bunny.toml
    """
    from hsr.scene.writing import to_toml, with_files

    loaded = hsr.load(mesh)
    folder = Path(os.path.relpath(loaded.folder, output.parent if output else "."))
    text = to_toml(with_files(loaded, lambda file: (folder / file).as_posix()), explained=True)
    if output is None:
        print(text, end="")
    else:
        write_whole(output, text, "the scene", SceneError)
        cli.say(f"wrote {output}; 'hsr render {output}' shows it")


@scene_app.command()
@with_cameras
def export(
    file: cli.SceneFile, output: cli.ExportFolder, size: cli.Size = "512x512", *, cameras: Cameras
) -> None:
    """Write a scene for other programs: OBJ, GLB, camera matrices, and the faces they should show.

    The truth is that of the float32 coordinates that are written, curved shapes cut into triangles; a README
    in the folder says how to compare.

    For example:

        hsr scene export teapot -o teapot --size 640x480
        hsr diff yours.png teapot/expected.npz
    """
    scene = cameras.one(hsr.load(file))
    tell_export(hsr.view(scene, cli.parse_size(size)), output, scene.title or str(file))


def tell_export(view: hsr.View, folder: Path, title: str) -> None:
    """Write a view for other programs, and say what to do with it."""
    from hsr.lab.export import export

    export(view, folder, title)
    cli.say(f"wrote {folder}; {folder / 'README.md'} says how to compare")


@scene_app.command()
def check(files: cli.SceneFiles, as_json: cli.Json = False, quiet: cli.Quiet = False) -> None:
    """Check scene files; all errors of all files at once, exit 2 if there are any.

    For example:

        hsr scene check my.toml teapot
    """
    problems: dict[str, list[str]] = {}
    for file in files:
        problems[str(file)] = []
        try:
            hsr.load(file)
        except SceneError as error:
            problems[str(file)] += error.problems
    lines = ("\n".join(found) or f"{printable(name)}: ok" for name, found in problems.items())
    cli.tell(as_json, "scene-check", {"problems": problems}, () if quiet else lines)
    if any(problems.values()):
        raise Exit(cli.USAGE)


@scene_app.command()
def info(file: cli.SceneFile, size: cli.Size = "512x512", as_json: cli.Json = False) -> None:
    """Say what is in a scene: objects, faces, bounds, cameras, where culling would be lossless.

    For example:

        hsr scene info solids
    """
    from hsr.scene.info import describe, lines

    found = describe(hsr.load(file), cli.parse_size(size))
    cli.tell(as_json, "scene-info", found, lines(found))


@scene_app.command()
def schema(file: SchemaFile = None) -> None:
    """Print the JSON Schema of scene files, for editors.

    For example:

        hsr scene schema schema.json
    """
    from hsr.scene.info import schema as scene_schema

    text = json.dumps(scene_schema(), indent=2)
    if file is None:
        print(text)
    else:
        write_whole(file, text + "\n", "the schema")
