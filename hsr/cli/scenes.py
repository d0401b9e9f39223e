"""The command ``hsr scenes``: which scenes there are."""

from __future__ import annotations

import hsr
from hsr.cli import common as cli


def scenes(as_json: cli.Json = False) -> None:
    """List the built-in scenes; every verb takes their names in place of files.

    For example:

        hsr scenes
        hsr compare teapot
    """
    from hsr.scene.files import built_in

    found = [{"name": name, "title": hsr.load(path).title} for name, path in built_in().items()]
    cli.print_list(as_json, "scenes", found)
