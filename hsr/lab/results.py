"""What a benchmark found: one row a method and case, and the machine, as plain JSON.

The file keeps every sample, so that statistics can be done again; the figures beside the samples are for
those who read the file with other tools.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from hsr.base.errors import HsrError, told_briefly

FEWEST = 3
"""Turns without which a median has no interval worth the name."""


class Record(BaseModel):
    """Base of every part of the file: frozen, no unknown key, no NaN."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Timing(Record):
    """Wall time of one stage, in milliseconds.

    ``q1`` and ``q3`` are the quartiles of the samples, ``low`` and ``high`` the bootstrap interval of
    their median (:mod:`hsr.lab.statistics`).
    """

    median: float
    q1: float
    q3: float
    low: float
    high: float
    samples: Annotated[tuple[float, ...], Field(min_length=FEWEST)]


class DepthOff(Record):
    """How far depths lie from the exact ones, where the method shows the exact owner.

    ``max`` and ``median`` of the absolute difference in scene units along the view axis; ``max_ulp``
    and ``median_ulp`` in float64 spacings of the exact depth. All 0 without any such sample.
    """

    samples: int
    max: float
    median: float
    max_ulp: float
    median_ulp: float


class Verdict(Record):
    """What exact arithmetic says of one map.

    ``wrong`` counts samples whose owner is not admissible; ``ties`` those with an admissible owner
    other than the oracle's, which are not wrong. ``causes`` is empty if nothing is wrong, and None if
    nobody asked.
    """

    wrong: int
    ties: int
    clusters: int
    largest_cluster: int
    causes: dict[str, int] | None
    depth: DepthOff


class Row(Record):
    """One method on one case: a scene at a size, culled in one way.

    Attributes
    ----------
    id : str
        ``scene/WxH/cull/method``: names the row in tables, charts and comparisons.
    series : str
        The series of a scaling run the case belongs to; else empty.
    cull : {"scene", "none", "back"}
        ``scene``: as each object of the scene says.
    absent : str
        Why the method has no figures; empty if it has. Without figures all that follows is empty.
    threads : int or None
        That the method may use; None for a driver that does not say.
    warm_up : float or None
        Milliseconds of the method's first, tiny picture of the scene: compiling or reading compiled
        kernels, opening drivers.
    times : dict of str to Timing
        By stage, ``total`` being the sum of all stages of a turn.
    work : dict of str to int
        What the method counted.
    peak_bytes : int or None
        How far the process's resident memory rose while it rendered; None where the system does not say.
    buffer_bytes : int or None
        Of the ids and depths that it returned.
    foreign_load : float or None
        Processors that other programs kept busy while the case was measured, on average; None where the
        system does not say.
    yardstick : float or None
        Milliseconds of a fixed piece of work on one thread, done once a turn, median: tells runs on one
        machine how fast the machine itself was.
    """

    id: str
    series: str = ""
    scene: str
    width: int
    height: int
    cull: Literal["scene", "none", "back"]
    method: str
    faces: int
    triangles: int
    hashes: dict[str, str]
    absent: str = ""
    driver: str = ""
    threads: int | None = None
    warm_up: float | None = None
    times: dict[str, Timing] = {}
    verdict: Verdict | None = None
    work: dict[str, int] = {}
    peak_bytes: int | None = None
    buffer_bytes: int | None = None
    foreign_load: float | None = None
    yardstick: float | None = None

    @model_validator(mode="after")
    def _has_figures(self) -> Self:
        total = self.times.get("total")
        if not self.absent and (self.verdict is None or total is None or total.median <= 0.0):
            raise ValueError("it has neither figures nor a reason to have none")
        return self

    @property
    def case(self) -> str:
        """The id without the method: rows of one case were measured in turns and may be compared."""
        return self.id.rpartition("/")[0]

    @property
    def family(self) -> str:
        """The first part of the method's name: ``raycast`` of ``raycast-single``."""
        return self.method.partition("-")[0]


class Machine(Record):
    """What the figures were measured on; ``environment`` holds the variables that bear on time."""

    name: str
    cpu: str
    processors: int
    threads: int
    system: str
    versions: dict[str, str]
    environment: dict[str, str]


class Results(Record):
    """One run of a benchmark."""

    hsr: Literal[1]
    format: Literal[1] = 1
    kind: Literal["bench"]
    date: str
    commit: str | None
    repeat: int
    machine: Machine
    rows: tuple[Row, ...]

    @cached_property
    def cases(self) -> dict[str, list[Row]]:
        """The rows of every case, in order."""
        found: dict[str, list[Row]] = {}
        for row in self.rows:
            found.setdefault(row.case, []).append(row)
        return found

    @property
    def scaling(self) -> bool:
        """Whether the run is one of series that grow."""
        return any(row.series for row in self.rows)

    @property
    def foreign_load(self) -> float | None:
        """Processors that other programs kept busy, of all rows the most; None if none says."""
        return max((row.foreign_load for row in self.rows if row.foreign_load is not None), default=None)

    @property
    def stem(self) -> str:
        """Name for the files of the run: what was measured, machine and commit."""
        what = "scaling" if self.scaling else "speed"
        return f"{what}-{self.machine.name}-{self.commit or self.machine.versions.get('hsr-lab', 'unknown')}"

    def to_json(self) -> str:
        """Return the text of the file."""
        return self.model_dump_json(indent=1) + "\n"


def case_title(rows: Sequence[Row]) -> str:
    """Name a case for people: ``teapot, 16,256 triangles, 512x512``."""
    row = rows[0]
    culled = {"scene": "", "none": ", nothing culled", "back": ", back faces culled"}[row.cull]
    return f"{row.scene}, {row.triangles:,} triangles, {row.width}x{row.height}{culled}"


def load_results(path: str | Path) -> Results:
    """Read a file of results.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Results

    Raises
    ------
    HsrError
        If the file cannot be read, or is not of this version.
    """
    try:
        return Results.model_validate_json(Path(path).read_bytes())
    except OSError as error:
        raise HsrError(f"{path}: cannot read the results: {error.strerror}") from error
    except ValidationError as error:
        told = f"{path}: no benchmark results of version 1 ({told_briefly(error)}); measure with 'hsr bench'"
        raise HsrError(told) from None
