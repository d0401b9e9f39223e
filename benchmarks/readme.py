"""Write what was measured into the README: python benchmarks/readme.py

The results are the files in ``benchmarks/results``; their tables go between the two marks of the README,
their charts beside them. To measure anew, empty the folder and run ``hsr bench ... -o benchmarks/results``.
"""

from __future__ import annotations

from pathlib import Path

from hsr.experiments.publish import to_markdown, to_svg
from hsr.experiments.results import Results, load_results

ROOT = Path(__file__).parent.parent
README = ROOT / "README.md"
RESULTS = ROOT / "benchmarks" / "results"

BEGIN = "<!-- measured: written by benchmarks/readme.py -->"
END = "<!-- end of what is measured -->"


def measured() -> list[Results]:
    """Return the committed results, speed before scaling."""
    found = [load_results(path) for path in sorted(RESULTS.glob("*.json"))]
    return sorted(found, key=lambda results: results.scaling)


def section(found: list[Results]) -> str:
    """Return what stands between the marks: a chart and tables for each run."""
    parts = []
    for results in found:
        what = "How times grow" if results.scaling else "Speed against error"
        parts.append(f"![{what}](benchmarks/results/{results.stem}.svg)\n")
        parts.append(to_markdown(results))
    return "\n".join([BEGIN, "", *parts, END])


def updated(readme: str, found: list[Results]) -> str:
    """Return the README with the section of the results between its marks."""
    before, begin, rest = readme.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise SystemExit(f"README.md: put the lines {BEGIN!r} and {END!r} where the table shall stand")
    return before + section(found) + after


def main() -> None:
    """Write the section, and the charts anew."""
    found = measured()
    if not found:
        raise SystemExit(f"{RESULTS}: no results; measure with 'hsr bench ... -o benchmarks/results'")
    README.write_text(updated(README.read_text(encoding="utf-8"), found), encoding="utf-8")
    for results in found:
        (RESULTS / f"{results.stem}.svg").write_text(to_svg(results), encoding="utf-8")


if __name__ == "__main__":
    main()
