"""What a benchmark publishes: the results as JSON, CSV, Markdown, and a chart."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hsr.base.errors import HsrError
from hsr.base.files import write_whole
from hsr.lab import scaling
from hsr.lab.metrics import ERROR, METRICS, SPEED, STAGES, Metric, dominators
from hsr.lab.results import Results, Row, case_title
from hsr.lab.scaling import growth, sentences
from hsr.lab.tables import Table
from hsr.pictures.charts import Mark, Panel, growth_svg, speed_svg

TABLE: Sequence[Metric] = (*STAGES, ERROR)
"""The figures of a table; all of them are in the CSV file."""

NAMED = 2
"""How many methods a table names that dominate another."""


def publish(results: Results, folder: str | Path) -> list[Path]:
    """Write a run into a folder, named after machine and commit: .json, .csv, .md and .svg.

    Parameters
    ----------
    results : Results
    folder : str or Path

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    HsrError
        If a file cannot be written.
    """
    forms = {"json": Results.to_json, "csv": to_csv, "md": to_markdown, "svg": to_svg}
    texts = {Path(folder, f"{results.stem}.{ending}"): form(results) for ending, form in forms.items()}
    make_folder(Path(folder))
    for path, text in texts.items():  # all texts are there by now: nothing can fail but the disk
        write_whole(path, text, "the results")
    return list(texts)


def make_folder(folder: Path) -> None:
    """Make the folder of the results: before the work is done, not after.

    Raises
    ------
    HsrError
        If it cannot be made, or nothing can be written there.
    """
    try:
        folder.mkdir(exist_ok=True)
        probe = folder / ".hsr-bench"
        probe.touch()
        probe.unlink()
    except OSError as why:
        raise HsrError(f"{folder}: cannot write results there: {why.strerror}; choose another -o") from why


# ---------------------------------------------------------------- tables


def to_csv(results: Results) -> str:
    """Return one line a row: what it is, every metric, causes as ``name count``, rank and dominators."""
    facts = ("id", "series", "scene", "width", "height", "cull", "method", "faces", "triangles", "threads")
    lines = []
    for rows in results.cases.values():
        better = dominators(rows)
        for row in rows:
            figures = [metric.of(row) for metric in METRICS]
            ranked = (len(better[row.id]) + 1, " ".join(better[row.id])) if row.id in better else ("", "")
            lines.append([*(getattr(row, name) for name in facts), *figures, why(row), *ranked, row.absent])
    head = [*facts, *(metric.title for metric in METRICS), "why", "rank", "dominated by", "absent"]
    return Table(head, lines).csv()


def table(rows: Sequence[Row]) -> Table:
    """Return the table of one case, the best rank first.

    A row without figures comes last, its reason in the column "why".
    """
    better, titles = dominators(rows), [metric.title for metric in TABLE]
    head = ("rank", "method", *titles, "why", "dominated by")

    def cells(row: Row) -> tuple[str, ...]:
        figures = [metric.text(row) for metric in TABLE]
        if row.absent:
            return ("", row.method, *figures, row.absent, "")
        return (str(len(better[row.id]) + 1), row.method, *figures, why(row), _named(better[row.id]))

    order = sorted(rows, key=lambda row: (row.absent != "", len(better.get(row.id, ())), SPEED.of(row) or 0))
    return Table(head, list(map(cells, order)), ("rank", *titles), case_title(rows))


def tables(results: Results) -> list[Table]:
    """Return the table of every case, or the one of how times grow."""
    return [scaling.table(growth(results))] if results.scaling else list(map(table, results.cases.values()))


def _named(methods: Sequence[str]) -> str:
    more = len(methods) - NAMED
    return ", ".join(methods[:NAMED]) + (f" and {more} more" if more > 0 else "")


def why(row: Row) -> str:
    """Write the causes of the wrong samples of a row."""
    causes = (row.verdict and row.verdict.causes) or {}
    return ", ".join(f"{name} {count:,}" for name, count in causes.items())


def to_markdown(results: Results) -> str:
    """Return the tables of all cases, or of how times grow, with a line on the machine, as Markdown."""
    told: list[str] = list(map(case_markdown, results.cases.values()))
    if results.scaling:
        series = growth(results)
        lines = "\n".join(f"- {sentence}" for sentence in sentences(series))
        told = [lines, scaling.table(series).markdown()]
    return "\n\n".join([conditions(results), *told]) + "\n"


def case_markdown(rows: Sequence[Row]) -> str:
    """Return the title and the table of one case as Markdown."""
    return f"**{case_title(rows)}**\n\n{table(rows).markdown()}"


def conditions(results: Results) -> str:
    """Say in a sentence or two under what conditions the figures were measured."""
    machine = results.machine
    versions = ", ".join(f"{name} {number}" for name, number in machine.versions.items())
    drivers = dict.fromkeys(row.driver for row in results.rows if row.driver)
    single = dict.fromkeys(row.method for row in results.rows if row.threads == 1)
    text = (
        f"Medians of {results.repeat} interleaved turns on {machine.threads} threads of {machine.processors} "
        f"processors ({machine.cpu}), {results.date[:10]}, commit {results.commit or 'unknown'}; "
        f"{'; '.join([versions, *drivers])}."
    )
    if single and machine.threads > 1:
        text += f" One thread only: {', '.join(single)}."
    if results.foreign_load is not None:
        text += f" Other programs kept up to {results.foreign_load:.2f} processors busy."
    return text


# ---------------------------------------------------------------- charts


def panels(results: Results) -> list[Panel]:
    """Return the panel of every case: time against error."""
    return [_panel(rows) for rows in results.cases.values()]


def _panel(rows: Sequence[Row]) -> Panel:
    better = dominators(rows)
    marks = [_mark(row, row.verdict.wrong, not better[row.id]) for row in rows if row.verdict is not None]
    return Panel(case_title(rows), marks, [f"{row.method}: {row.absent}" for row in rows if row.absent])


def _mark(row: Row, wrong: int, frontier: bool) -> Mark:
    told = {metric.title: metric.text(row) for metric in METRICS} | {"why": why(row)}
    about = "\n".join([row.id, *(f"{name}: {text}" for name, text in told.items() if text)])
    time = row.times[SPEED.name]
    return Mark(row.method, row.family, float(wrong), time.median, time.low, time.high, frontier, about)


def to_svg(results: Results) -> str:
    """Return the chart: speed against error, of a scaling run how times grow."""
    if results.scaling:
        return growth_svg(growth(results), SPEED.axis)
    return speed_svg(panels(results), ERROR.axis, SPEED.axis)
