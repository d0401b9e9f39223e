"""The command ``hsr algos``: which methods there are."""

from __future__ import annotations

import hsr
from hsr.cli import options as opt
from hsr.cli.console import new_table, out, print_json


def algos(as_json: opt.Json = False) -> None:
    """List the methods."""
    known = hsr.methods().values()
    if as_json:
        rows = [{"name": m.name, "about": m.about, "curved": m.curved, "needs": m.needs} for m in known]
        print_json({"hsr": 1, "methods": rows})
        return
    table = new_table("method", "curved shapes", "needs", "what it does", right=())
    for m in known:
        table.add_row(m.name, "exact" if m.curved else "tessellated", m.needs or "-", m.about)
    out.print(table)
