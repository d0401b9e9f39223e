"""How far two maps may differ, and who said so."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from hsr.base.errors import CheckError, nearest
from hsr.difference.classes import OTHER_OWNER
from hsr.models.foreign import MODEL, PARAMETERS
from hsr.models.stages import Cause

REFERENCE_WRONG = "reference wrong"
"""The cause of samples at which the judged map is right, and the map it is judged against is not."""

CAUSES = (*(cause.label for cause in Cause if cause), *(kind.label for kind in OTHER_OWNER), REFERENCE_WRONG)
"""What ``allow`` may name: causes where they are known, else classes of difference."""

COUNTS = ("max_diff_pixels", "max_diff_ratio", "max_cluster", "max_in_window", "expect_diff")
"""The limits of how many samples may differ. All that are set apply; with none set no sample may."""

MADE_BY = (MODEL, *PARAMETERS)
"""How the judged map was made: see :func:`hsr.testing.modelled`."""

NAMES = (*COUNTS, "depth_ulps", "allow", *MADE_BY)
"""All limits, and what else a check goes by."""

Holds = Callable[[Any], bool]


def _number(kind: Any) -> Holds:
    return lambda value: isinstance(value, kind) and not isinstance(value, bool) and value >= 0


def _pair(holds: Callable[[int, int], bool]) -> Holds:
    """Tell whether a value is a pair of whole numbers of which this holds."""
    return lambda value: isinstance(value, tuple) and [*map(type, value)] == [int, int] and holds(*value)


EXPECTED: dict[str, tuple[Holds, str]] = {
    "max_diff_pixels": (_number(int), "a whole number from 0"),
    "max_cluster": (_number(int), "a whole number from 0"),
    "depth_ulps": (_number(int | float), "a number from 0"),
    "max_diff_ratio": (_number(int | float), "a number from 0 to 1"),
    "max_in_window": (_pair(lambda side, most: side >= 1 and most >= 0), "(side, most), such as (8, 3)"),
    "expect_diff": (_pair(lambda low, high: 0 <= low <= high), "(low, high), such as (10, 20)"),
}
"""What a limit may be that is set."""


@dataclass(frozen=True)
class Limits:
    """How far a map may differ from the one it is judged against.

    Attributes
    ----------
    max_diff_pixels : int or None
        How many samples may show another owner.
    max_diff_ratio : float or None
        Which share of all samples may, from 0 to 1.
    max_cluster : int or None
        How many of those may hang together, over sides or corners.
    max_in_window : (int, int) or None
        ``(side, most)``: how many of those may lie in any window of so many samples a side.
    expect_diff : (int, int) or None
        ``(low, high)``: how many there must be, from at least to at most, where a difference is expected.
    depth_ulps : float or None
        How many spacings of the stored depths (see ``depth_step``; an ulp or up to two of a float)
        the depths of one face may lie apart, equality included; depths are not judged by default.
    allow : frozenset of str
        Causes that are forgiven: samples put down to them do not count. See ``CAUSES``.
    model, subpixel_bits, depth_format, fill_rule
        By which model the judged map was made, see :func:`hsr.testing.modelled`, if it does not say so itself
        and its method has no models. Without one it is the one of several that explains most, if it explains
        half: see ``hsr.models.foreign.CANDIDATES``.
    origin : mapping
        Who set each limit, by its name.

    Raises
    ------
    CheckError
        If a limit is out of range, or a cause does not exist.
    """

    max_diff_pixels: int | None = None
    max_diff_ratio: float | None = None
    max_cluster: int | None = None
    max_in_window: tuple[int, int] | None = None
    expect_diff: tuple[int, int] | None = None
    depth_ulps: float | None = None
    allow: frozenset[str] = frozenset()
    model: str | None = None
    subpixel_bits: int | None = None
    depth_format: str | None = None
    fill_rule: str | None = None
    origin: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, (holds, expected) in EXPECTED.items():
            value = getattr(self, name)
            if value is not None and not holds(value):
                raise CheckError(f"{name}={value!r}{self._by(name)}: expected {expected}")
        if self.model is None and any(getattr(self, name) is not None for name in PARAMETERS):
            raise CheckError(f"{', '.join(PARAMETERS)} belong to a model: name it, such as model='float32'")
        if (self.max_diff_ratio or 0.0) > 1.0:
            raise CheckError(f"max_diff_ratio={self.max_diff_ratio}{self._by('max_diff_ratio')}: at most 1")
        if isinstance(self.allow, str):
            raise CheckError(f"allow={self.allow!r}{self._by('allow')}: write a set, {{{self.allow!r}}}")
        for name in self.allow:
            if name not in CAUSES:
                what = f"there is no cause {name!r}{self._by('allow')}; {nearest(name, CAUSES)}"
                raise CheckError(f"allow: {what}causes are {', '.join(CAUSES)}")
        if all(getattr(self, name) is None for name in COUNTS):
            object.__setattr__(self, "max_diff_pixels", 0)

    @property
    def made_by(self) -> dict[str, Any]:
        """How the judged map was made, as :func:`hsr.testing.modelled` takes it; empty if nothing says so."""
        return {name: getattr(self, name) for name in MADE_BY} if self.model else {}

    def _by(self, name: str) -> str:
        return f" ({self.origin[name]})" if name in self.origin else ""

    def told(self, name: str) -> str:
        """Return a limit with who set it: ``max_cluster=4 (marker)``."""
        return f"{name}={getattr(self, name)} ({self.origin.get(name, 'default')})"


def merged(sources: Iterable[tuple[str, Mapping[str, Any]]]) -> Limits:
    """Put limits together from several places.

    Parameters
    ----------
    sources : iterable of (str, mapping)
        Who sets limits, and which by name; who comes first has precedence.

    Returns
    -------
    Limits

    Raises
    ------
    CheckError
        If a limit does not exist or makes no sense.
    """
    values: dict[str, Any] = {}
    origin: dict[str, str] = {}
    for who, given in sources:
        for name, value in given.items():
            if name not in NAMES:
                raise CheckError(f"{who}: there is no limit {name!r}; there are {', '.join(NAMES)}")
            values.setdefault(name, value)
            origin.setdefault(name, who)
    if not isinstance(values.get("allow", ""), str):
        values["allow"] = frozenset(values["allow"])
    return Limits(**values, origin=origin)
