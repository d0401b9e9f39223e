"""Write what was measured into the README: python benchmarks/readme.py

The results are the files in ``benchmarks/results``; their tables go between two marks of the README, their
charts beside them. To measure anew, empty the folder and run ``hsr bench ... -o benchmarks/results``. The
table of hard cases goes between two other marks; it is that of ``hsr stability -o reports/stability``.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from hsr.lab.publish import case_markdown, conditions, to_markdown, to_svg
from hsr.lab.results import Results, load_results
from hsr.lab.stability.summary import headline, markdown

ROOT = Path(__file__).parent.parent
README = ROOT / "README.md"
RESULTS = ROOT / "benchmarks" / "results"
MATRIX = ROOT / "reports" / "stability" / "matrix.json"

BEGIN = "<!-- measured: written by benchmarks/readme.py -->"
END = "<!-- end of what is measured -->"

RATIOS = (
    "How many times faster than the peer, medians of the stage `render` in the same run, and of `build` and "
    "`render` together (*with hierarchies*); last, by how much certification slows the same kernel down."
)

HARD_BEGIN = "<!-- hard cases: written by benchmarks/readme.py -->"
HARD_END = "<!-- end of hard cases -->"


def measured() -> list[Results]:
    """Return the committed results, speed before scaling."""
    found = [load_results(path) for path in sorted(RESULTS.glob("*.json"))]
    return sorted(found, key=lambda results: results.scaling)


def section(found: list[Results]) -> str:
    """Return what stands between the marks: charts of the runs, and tables or what is fastest."""
    parts = []
    for results in found:
        file = f"benchmarks/results/{results.stem}"
        if results.scaling:
            fastest = [line for line in to_markdown(results).splitlines() if line.startswith("- At ")]
            parts += [f"![How times grow]({file}.svg)\n", *fastest, ""]
            parts += [f"Which method overtakes which, and where: [all that was measured]({file}.md).\n"]
        else:
            parts += [f"![Speed against error]({file}.svg)\n", conditions(results), "", *ratios(results)]
            parts += ["", case_markdown(next(iter(results.cases.values())))]
            parts += ["", f"The other scenes: [all tables]({file}.md).\n"]
    return "\n".join([BEGIN, "", *parts, END])


def ratios(results: Results) -> list[str]:
    """Return the lines of a table: how many times faster than its peer a certified method is on each case."""
    names = (
        "zbuffer : opengl",
        "scanline : opengl",
        "raycast : embree-packets",
        "with hierarchies",
        "certified zbuffer",
        "certified raycast",
    )
    lines = [f"| scene | culled | {' | '.join(names)} |", f"|---|---|{'---:|' * len(names)}"]
    for rows in results.cases.values():
        took = {row.method: row.times for row in rows if not row.absent}
        cells = [
            _times(took, "opengl", "zbuffer"),
            _times(took, "opengl", "scanline"),
            _times(took, "embree-packets", "raycast"),
            _times(took, "embree-packets", "raycast", ("build", "render")),
            _cost(took, "zbuffer"),
            _cost(took, "raycast"),
        ]
        lines.append(f"| {rows[0].scene} | {rows[0].cull} | {' | '.join(cells)} |")
    return [*lines, "", RATIOS]


def _times(took: dict[str, Any], peer: str, ours: str, stages: tuple[str, ...] = ("render",)) -> str:
    if not {peer, ours} <= took.keys():
        return "absent"
    spent = [sum(took[method][stage].median for stage in stages) for method in (peer, ours)]
    return f"{spent[0] / spent[1]:.1f}"


def _cost(took: dict[str, Any], method: str) -> str:
    if not {method, f"{method}-plain"} <= took.keys():
        return "absent"
    return f"{took[method]['render'].median / took[f'{method}-plain']['render'].median - 1.0:+.0%}"


def hard_cases(matrix: dict[str, Any]) -> str:
    """Return what stands between the marks of the hard cases: a chart, a table, and how it was made."""
    versions = ", ".join(f"{name} {version}" for name, version in matrix["versions"].items())
    drivers = {driver for family in matrix["families"] for driver in family["drivers"].values()}
    made_with = "; ".join([f"Commit {matrix['commit'] or 'unknown'}", versions, *sorted(drivers)])
    told = f"{headline(matrix['families'])}. {made_with}. Written by `hsr stability -o reports/stability`."
    chart = "![Resolution of depth formats](reports/stability/parallel-pair.svg)"
    return "\n\n".join([HARD_BEGIN, chart, markdown(matrix["families"]), told, HARD_END])


def between(readme: str, begin: str, end: str, fresh: str) -> str:
    """Return the README with a fresh section, its marks included, in place of what stands there."""
    before, first, rest = readme.partition(begin)
    _, last, after = rest.partition(end)
    if not (first and last):
        raise SystemExit(f"README.md: put the lines {begin!r} and {end!r} where the table shall stand")
    return before + fresh + after


def updated(readme: str, found: list[Results]) -> str:
    """Return the README with the section of the results between its marks."""
    return between(readme, BEGIN, END, section(found))


def main() -> None:
    """Write both sections, and the charts of the results anew."""
    found = measured()
    if not found:
        raise SystemExit(f"{RESULTS}: no results; measure with 'hsr bench ... -o benchmarks/results'")
    matrix = json.loads(MATRIX.read_text(encoding="utf-8"))
    readme = updated(README.read_text(encoding="utf-8"), found)
    README.write_text(between(readme, HARD_BEGIN, HARD_END, hard_cases(matrix)), encoding="utf-8")
    for results in found:
        (RESULTS / f"{results.stem}.svg").write_text(to_svg(results), encoding="utf-8")
        (RESULTS / f"{results.stem}.md").write_text(to_markdown(results), encoding="utf-8")


if __name__ == "__main__":
    main()
