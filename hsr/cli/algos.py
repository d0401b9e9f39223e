"""The command ``hsr algos``: which methods there are."""

from __future__ import annotations

import hsr
from hsr.cli import common as cli


def algos(as_json: cli.Json = False) -> None:
    """List the methods."""
    known = hsr.methods().values()
    if as_json:
        rows = [{"name": m.name, "about": m.about, "curved": m.curved, "needs": m.needs} for m in known]
        cli.print_json({"hsr": 1, "methods": rows})
    else:
        cells = [(m.name, "exact" if m.curved else "tessellated", m.needs or "-", m.about) for m in known]
        cli.print_table(("method", "curved shapes", "needs", "what it does"), cells, right=())
