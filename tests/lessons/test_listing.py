"""Listings are the real source, trimmed to what ran."""

from __future__ import annotations

from hsr.kernels import scanline
from hsr.lessons.listing import Source, listing_of, source_of

EXAMPLE = Source(
    "f",
    {
        1: "def f(x):",
        2: "    # Halve.",
        3: "    if x:",
        4: "        y = (",
        5: "            1)",
        6: "    else:",
        7: "        y = 2",
    },
    {1: 1, 2: 3, 3: 3, 4: 4, 5: 4, 6: 7, 7: 7},
)


def documented(x: int) -> int:
    """Say nothing of this."""
    # Head of a paragraph.
    if x > 0:
        return 1
    return abs(
        x
    )  # fmt: skip


def test_a_source_has_no_docstring_and_knows_its_statements() -> None:
    source = source_of(documented)
    text = [line.strip() for line in source.lines.values()]
    assert text == [
        "def documented(x: int) -> int:",
        "# Head of a paragraph.",
        "if x > 0:",
        "return 1",
        "return abs(",
        "x",
        ")  # fmt: skip",
    ]
    first = min(source.lines)
    heads = [source.statement[n] - first for n in source.lines]
    assert heads == [0, 3, 3, 4, 5, 5, 5]


def test_lines_that_did_not_run_become_one_gap() -> None:
    listing = listing_of([EXAMPLE], {("f", 3), ("f", 7)})
    assert listing.text == (
        "def f(x):",
        "    # Halve.",
        "    if x:",
        "        …",
        "    else:",
        "        y = 2",
    )
    assert listing.place["f", 7] == 5 and ("f", 4) not in listing.place


def test_a_function_that_did_not_run_is_left_out() -> None:
    other = source_of(scanline.draw)
    assert listing_of([other, EXAMPLE], {("f", 3)}).text[0] == "def f(x):"


def test_kernels_are_listed_without_decorator() -> None:
    assert next(iter(source_of(scanline.draw).lines.values())).startswith("def draw(")
