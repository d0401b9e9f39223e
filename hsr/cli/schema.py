"""The command ``hsr schema``: what the JSON of the verbs is made of."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Annotated, Any

from typer import Argument

from hsr.base.errors import named


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
