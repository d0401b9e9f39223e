"""Recording a method at work: which line runs, what its variables become, what it writes where.

The method's own ``render`` runs, its kernels as the Python functions they are written as, under Python's own
trace function. Nothing of the algorithm is repeated here.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any, NamedTuple

import numpy as np

from hsr.algorithms.registry import Method
from hsr.base.errors import MethodError
from hsr.lessons.interpret import interpreted, python_of
from hsr.lessons.listing import Listing, Source, listing_of, source_of
from hsr.lessons.probes import Buffers, Look, Names, Probe
from hsr.problem.map import BACKGROUND, VisibilityMap
from hsr.problem.view import View

MOST_STEPS = 60_000
"""Lines that a recording may run: on a page about half a megabyte."""


class Step(NamedTuple):
    """One statement that has run.

    Attributes
    ----------
    line : int
        Its first line in the listing.
    changes : list of (int, value)
        The variables, by their slots, that are different after it.
    writes : list of (int, int, float)
        Samples ``row * W + column`` whose face or depth is different after it, and both.
    """

    line: int
    changes: list[tuple[int, Any]]
    writes: list[tuple[int, int, float]]


class Turn(NamedTuple):
    """The steps during which a method is busy with one sample, up to the next turn.

    Attributes
    ----------
    step : int
        The first of them.
    sample : int
        ``row * W + column``.
    faces : tuple of int
        The faces that compete for the sample: what the buffer holds before, and what arrives. Ascending.
    owner : int
        The face that holds the sample after.
    """

    step: int
    sample: int
    faces: tuple[int, ...]
    owner: int


class Recording(NamedTuple):
    """A method at work on one view.

    Attributes
    ----------
    answer : VisibilityMap
        What it returned.
    listing : Listing
    slots : tuple of (str, str)
        The variables shown: function and name.
    steps : list of Step
    turns : list of Turn
    counters : dict of str to int
        The line of the listing whose runs are the count.
    """

    answer: VisibilityMap
    listing: Listing
    slots: tuple[tuple[str, str], ...]
    steps: list[Step]
    turns: list[Turn]
    counters: dict[str, int]


def record(view: View, method: Method, probe: Probe, **options: Any) -> Recording:
    """Run a method on a view and record it.

    Parameters
    ----------
    view : View
        Small: a statement is a step.
    method : Method
    probe : Probe
    **options
        Of the method.

    Raises
    ------
    MethodError
        If it runs more than :data:`MOST_STEPS` statements, the method refuses, or the probe watches what the
        method does not have.
    """
    probe.check()
    recorder = _Recorder(probe, view)
    with interpreted(), _traced(recorder.enter):
        answer = method.render(view, **options)
    return recorder.recording(answer)


@contextmanager
def _traced(trace: Any) -> Iterator[None]:
    """Have a trace function called; the one that was there, of a debugger or for coverage, comes back."""
    before = sys.gettrace()
    sys.settrace(trace)
    try:
        yield
    finally:
        sys.settrace(before)


class _Recorder:
    """Collects steps from the events of Python's trace function."""

    def __init__(self, probe: Probe, view: View) -> None:
        self.probe = probe
        self.sources = {python_of(f).__code__: source_of(f) for f in probe.shown}
        self.slots = tuple((f.__name__, name) for f, names in probe.shown.items() for name in names)
        self.watched = [compile(name, "<watched>", "eval") for _, name in self.slots]
        self.looks = {python_of(f).__code__: look for f, look in probe.buffers.items()}
        self.rival = probe.rival and python_of(probe.rival[0]).__code__
        self.until = probe.until and python_of(probe.until).__code__
        self.ended = False
        self.width = view.width
        self.size = (view.height, view.width)
        self.looked: FrameType | None = None
        self.read: Callable[[], Buffers] | None = None
        self.face = np.full(self.size, BACKGROUND, np.int32)
        self.depth = np.full(self.size, np.inf)
        self.values: dict[int, Any] = {}
        self.at: dict[FrameType, int] = {}
        self.lines: list[tuple[str, int]] = []
        self.changes: list[list[tuple[int, Any]]] = []
        self.writes: list[list[tuple[int, int, float]]] = []
        self.begun: list[tuple[int, int, set[int]]] = []

    # ------------------------------------------------------------ events

    def enter(self, frame: FrameType, event: str, argument: Any) -> Any:
        """Take the call of a function; return what takes the events within it."""
        code = frame.f_code
        if self.ended or not (code in self.sources or code in self.looks or code == self.rival):
            return None
        if code == self.rival and self.begun:
            assert self.probe.rival is not None
            self.begun[-1][2].add(self.probe.rival[1](frame.f_locals))
        return self.within(frame, event, argument)

    def within(self, frame: FrameType, event: str, _argument: Any) -> Any:
        """Take an event within a watched function."""
        if self.ended:
            return None
        names, source = frame.f_locals, self.sources.get(frame.f_code)
        if self.lines:
            self._settle(names, source)
        if frame.f_code in self.looks:
            self._look(frame, self.looks[frame.f_code])
        if event == "line" and source is not None:
            self._step(frame, names, source)
        if event == "return":
            self.at.pop(frame, None)
            self.ended = frame.f_code == self.until
        return self.within

    def _look(self, frame: FrameType, look: Look) -> None:
        """Find the buffers among the variables of a running function, once they are there."""
        if look.once not in frame.f_locals:
            if look.before:
                look.before(frame.f_locals)
        elif frame is not self.looked and look.read:
            self.looked, self.read = frame, look.read(frame.f_locals)

    def _settle(self, names: Names, source: Source | None) -> None:
        """Note what the last step has changed."""
        for slot, (function, _) in enumerate(self.slots):
            if source is None or source.name != function:
                continue
            with suppress(NameError):  # not assigned yet
                value = plain(eval(self.watched[slot], {}, names))
                if repr(self.values.get(slot)) != repr(value):
                    self.values[slot] = value
                    self.changes[-1].append((slot, value))
        if self.read is not None:
            face, depth = self.read()
            changed = np.flatnonzero((face != self.face) | (depth != self.depth))
            for sample in changed:
                self.writes[-1].append((int(sample), int(face.flat[sample]), float(depth.flat[sample])))
            if len(changed):
                self.face[:], self.depth[:] = face, depth

    def _step(self, frame: FrameType, names: Names, source: Source) -> None:
        """Begin a step, unless this is another line of the statement that is running."""
        statement = source.statement[frame.f_lineno]
        if self.at.get(frame) == statement:
            return
        if len(self.lines) == MOST_STEPS:
            raise MethodError(
                f"more than {MOST_STEPS:,} steps are too many to record; "
                "take a scene of fewer faces, such as scenes/cube.toml"
            )
        self.at[frame] = statement
        for beat in self.probe.beats:
            if source.name == beat.function.__name__ and source.lines[statement].strip().startswith(
                beat.line
            ):
                self._begin(beat.sample(names), beat.face(names))
        self.lines.append((source.name, statement))
        self.changes.append([])
        self.writes.append([])

    def _begin(self, place: tuple[int, int] | None, face: int) -> None:
        """Begin the turn of a sample."""
        if place is not None:
            self.begun.append(
                (len(self.lines), place[0] * self.width + place[1], {face, int(self.face[place])})
            )

    # ------------------------------------------------------------ the recording

    def recording(self, answer: VisibilityMap) -> Recording:
        """Put everything together."""
        listing = listing_of(list(self.sources.values()), set(self.lines))
        steps = [
            Step(listing.place[line], changes, writes)
            for line, changes, writes in zip(self.lines, self.changes, self.writes, strict=True)
        ]
        counters = {
            name: self._line(listing, function.__name__, text)
            for name, (function, text) in self.probe.counters.items()
        }
        return Recording(answer, listing, self.slots, steps, list(self._turns()), counters)

    def _line(self, listing: Listing, function: str, text: str) -> int:
        """Return the line of the listing at which a statement of a function begins, -1 if it has not run."""
        found = [
            index
            for (name, _), index in listing.place.items()
            if name == function and listing.text[index].strip().startswith(text)
        ]
        return found[0] if found else -1

    def _turns(self) -> Iterator[Turn]:
        """Yield the turns, with the owners that the writes during them leave."""
        held = np.full(self.size, BACKGROUND, np.int32).ravel()
        ends = [*(step for step, _, _ in self.begun[1:]), len(self.lines)]
        done = 0
        for (step, sample, faces), end in zip(self.begun, ends, strict=True):
            for writes in self.writes[done:end]:
                for written, face, _ in writes:
                    held[written] = face
            done = end
            yield Turn(step, sample, tuple(sorted(faces - {BACKGROUND})), int(held[sample]))


def plain(value: Any) -> Any:
    """Return a variable's value as a number, text, or lists of them."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return [plain(part) for part in value] if isinstance(value, tuple) else value
