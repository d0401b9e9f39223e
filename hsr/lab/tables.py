"""A table as it is written down: as Markdown for people, as CSV for programs."""

from __future__ import annotations

import csv
import io
from collections.abc import Collection, Sequence
from typing import NamedTuple


class Table(NamedTuple):
    """A table of texts.

    Attributes
    ----------
    head : sequence of str
        Names of the columns.
    rows : sequence of sequences
        The cells below them.
    right : collection of str
        The columns that hold numbers.
    title : str
        For people: neither form holds it.
    """

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    right: Collection[str] = ()
    title: str = ""

    def markdown(self) -> str:
        """Return the table as Markdown; columns of numbers are aligned to the right."""
        rule = "|".join("---:" if name in self.right else "---" for name in self.head)
        escaped = [[cell.replace("|", "\\|") for cell in cells] for cells in (self.head, *self.rows)]
        head, *lines = (f"| {' | '.join(cells)} |" for cells in escaped)
        return "\n".join([head, f"|{rule}|", *lines])

    def csv(self) -> str:
        """Return the table as CSV."""
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([self.head, *self.rows])
        return text.getvalue()
