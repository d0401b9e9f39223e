"""Names of objects and cameras, made of names that files give."""

from __future__ import annotations

from collections.abc import Sequence

SHORT = 70
"""Characters that are kept of a name: with a number behind it, it must be a name of a scene file."""


def printable(text: str) -> str:
    r"""Return a text whose characters that are not printable are escaped: ``a\xa0b``."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def unique(names: Sequence[str]) -> list[str]:
    """Return the names, printable, and numbered where they repeat: ``wheel``, ``wheel.1``, ``wheel.2``."""
    taken: dict[str, int] = {}
    for name in names:
        short = printable(name)[:SHORT] or "unnamed"
        new = short
        while new in taken:
            new = f"{short}.{taken[short]}"
            taken[short] += 1
        taken[new] = 1
    return list(taken)
