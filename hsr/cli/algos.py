"""The command ``hsr algos``: which methods there are."""

from __future__ import annotations

import hsr
from hsr.cli import common as cli


def algos(as_json: cli.Json = False) -> None:
    """List the methods.

    For example:

        hsr algos
        hsr render teapot -a raycast-single
    """
    keys = ("name", "curved", "needs", "about")
    found = [{key: getattr(method, key) for key in keys} for method in hsr.methods().values()]
    cli.print_list(as_json, "methods", found, least=("needs", "curved"))
