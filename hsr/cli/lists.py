"""The commands ``hsr scenes``, ``hsr algos`` and ``hsr schema``: what there is, and what JSON is made of."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Annotated, Any

from typer import Argument

import hsr
from hsr.base.errors import named
from hsr.cli import common as cli


def scenes(as_json: cli.Json = False) -> None:
    """List the built-in scenes; every verb takes their names, and those of hard cases, in place of files.

    For example:

        hsr scenes
        hsr compare teapot
        hsr compare needle
    """
    from hsr.scene.files import built_in

    found = [{"name": name, "title": hsr.load(path).title} for name, path in built_in().items()]
    cli.print_list(as_json, "scenes", found)


def algos(as_json: cli.Json = False) -> None:
    """List the methods.

    For example:

        hsr algos
        hsr render teapot -a raycast-single
    """
    keys = ("name", "curved", "needs", "about")
    found = [{key: getattr(method, key) for key in keys} for method in hsr.methods().values()]
    cli.print_list(as_json, "methods", found, least=("needs", "curved"))


def schema(
    kind: Annotated[str | None, Argument(help="What 'kind' says in the JSON; all by default.")] = None,
) -> None:
    """Print the JSON Schema of what verbs print with --json.

    For example:

        hsr schema compare
    """
    whole: dict[str, Any] = json.loads(files("hsr.cli").joinpath("formats.json").read_text(encoding="utf-8"))
    if kind is not None:
        named(kind, whole["$defs"], "no JSON is of the kind")
        whole["$ref"] = f"#/$defs/{kind}"
    print(json.dumps(whole, indent=1))
