"""The results as a matrix of cells, and as lines for a README."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from hsr.algorithms.registry import certified_methods
from hsr.lab.machine import commit, machine
from hsr.lab.stability.judge import Result, Row, Verdict
from hsr.lab.tables import Table

INSTRUCTIVE = (
    ("parallel-pair", "D24"),
    ("parallel-pair", "D32F reversed"),
    ("triangle-separation", "D24, 8 bits"),
    ("composed-matrix", "opengl"),
    ("long-span", "scanline-float32"),
    ("t-junction", "scanline-snap-8"),
    ("vertex-aimed-rays", "raycast-moller-trumbore"),
    ("distant-sphere", "naive float32"),
    ("cyclic-overlap", "painter"),
    ("integer-overflow", "int32"),
)
"""The family and the variant of the ten rows that teach most."""


def table(results: Sequence[Result]) -> Table:
    """Return a line a family, and below it one for everyone who took part."""
    head = ("variant", "wrong", "mostly by", "unexplained of traced", "predicted", "measured", "verdict")
    rows: list[tuple[str, ...]] = []
    for result in results:
        rows += [(result.family.name,), *map(_cells, result.rows)]
    return Table(head, rows, ("wrong", "unexplained of traced", "predicted", "measured"))


def _cells(row: Row) -> tuple[str, ...]:
    mostly = max(row.causes, key=lambda cause: row.causes[cause], default="")
    broken = (number(row.predicted), number(row.measured))
    unexplained = f"{row.unexplained:,} of {row.traced:,}"
    return (f"  {row.variant}", f"{row.wrong:,}", mostly, unexplained, *broken, str(row.verdict))


def closing(results: Sequence[Result]) -> list[str]:
    """Return who was skipped, and why, and the headline."""
    skipped = {name: reason for result in results for name, reason in result.skipped.items()}
    told = headline([result.to_json() for result in results])
    return [*(f"{name}: {reason}" for name, reason in skipped.items()), told]


def number(value: float | None) -> str:
    """Write a value in three figures, as ``1,290`` or ``1.91e-6``; ``-`` if there is none."""
    if value is None:
        return "-"
    if value == 0.0 or 1e-3 <= abs(value) < 1e6:
        return f"{float(f'{value:.3g}'):,.9g}"
    figures, exponent = f"{value:.2e}".split("e")
    return f"{figures}e{int(exponent)}"


def headline(families: Sequence[Mapping[str, Any]]) -> str:
    """Sum up in one sentence: rows, verdicts, what certified methods got wrong, what is unexplained.

    Of many wrong samples in a picture only some are traced to a cause: the unexplained are counted among
    those.

    Parameters
    ----------
    families : sequence of mapping
        Those of :func:`matrix`.
    """
    rows = [row for family in families for row in family["rows"]]
    counts = [f"{sum(row['verdict'] == verdict for row in rows)} {verdict}" for verdict in Verdict]
    certified = sum(row["wrong"] for row in rows if row["variant"] in certified_methods())
    unexplained: Counter[str] = Counter()
    for row in rows:
        unexplained[row["variant"]] += row["unexplained"]
    traced = sum(row["traced"] for row in rows)
    whose = ", ".join(f"{name} {count}" for name, count in unexplained.items() if count)
    return (
        f"{len(families)} {'family' if len(families) == 1 else 'families'}, {len(rows)} rows: "
        f"{', '.join(counts)}; certified methods: {certified} wrong samples; "
        f"{unexplained.total()} unexplained of {traced:,} traced{f' ({whose})' if whose else ''}"
    )


def matrix(results: Sequence[Result]) -> dict[str, Any]:
    """Return the rows without their points, and what they were made with, as JSON values."""
    families = [result.to_json() for result in results]
    for row in (row for family in families for row in family["rows"]):
        del row["points"], row["curve"]
    return {"hsr": 1, "commit": commit(), "versions": machine().versions, "families": families}


def markdown(families: Sequence[Mapping[str, Any]]) -> str:
    """Write the ten most instructive rows, as far as they are there, as a Markdown table.

    Parameters
    ----------
    families : sequence of mapping
        Those of :func:`matrix`.
    """
    everyone = [(family, row) for family in families for row in family["rows"]]
    found = {(family["family"], row["variant"]): (family, row) for family, row in everyone}
    rows = [_facts(*found[key]) for key in INSTRUCTIVE if key in found]
    head = ("hard case", "variant", "what is measured", "theory", "predicted", "measured", "certified, wrong")
    return Table(head, rows, head[4:]).markdown()


def _facts(family: Mapping[str, Any], row: Mapping[str, Any]) -> tuple[str, ...]:
    what = f"first wrong face: {family['parameter']}"
    if row["at"] is not None:
        what = f"{family['figure']} ({family['parameter']}: {number(row['at'])})"
    certified = sum(other["wrong"] for other in family["rows"] if other["variant"] in certified_methods())
    broken = (number(row["predicted"]), number(row["measured"]), str(certified))
    return (family["family"], row["variant"], what, f"`{row['because']}`", *broken)
