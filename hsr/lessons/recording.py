"""Recording a method at work: which line runs, what its variables become, what it writes where.

The method's own ``render`` runs, its kernels as the Python functions they are written as, under Python's own
trace function. Nothing of the algorithm is repeated here.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import chain
from types import FrameType, FunctionType
from typing import Any, NamedTuple

import numpy as np
from numba.core.dispatcher import Dispatcher

from hsr.algorithms.registry import Method
from hsr.base.errors import MethodError
from hsr.lessons.listing import Listing, Source, begins, listing_of, python_of, source_of
from hsr.lessons.probes import Buffers, Look, Names, Probe
from hsr.problem.map import BACKGROUND, VisibilityMap
from hsr.problem.view import View

KERNELS = "hsr.kernels."

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
def interpreted() -> Iterator[None]:
    """Let the kernels, and whoever calls them, have the Python functions instead of the compiled ones.

    The names change in every module that has them, and only until the end of the ``with`` block. Keys of
    depth buffers are unsigned and wrap around on purpose, of which NumPy would warn.
    """
    compiled = [
        (vars(module), name, value)
        for module in list(sys.modules.values())
        for name, value in vars(module).items()
        if isinstance(value, Dispatcher | FunctionType) and python_of(value) is not value
        if python_of(value).__module__.startswith(KERNELS)
    ]
    try:
        for names, name, kernel in compiled:
            names[name] = python_of(kernel)
        with np.errstate(over="ignore"):
            yield
    finally:
        for names, name, kernel in compiled:
            names[name] = kernel


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
        self.rivals = {} if probe.rival is None else {python_of(probe.rival[0]).__code__: probe.rival[1]}
        self.until = probe.until and python_of(probe.until).__code__
        self.ended = False
        self.looked: FrameType | None = None
        self.read: Callable[[], Buffers] | None = None
        self.face = np.full((view.height, view.width), BACKGROUND, np.int32)
        self.depth = np.full(self.face.shape, np.inf)
        self.values: dict[int, Any] = {}
        self.at: dict[FrameType, int] = {}
        self.statements: list[tuple[str, int]] = []
        self.steps: list[Step] = []
        self.begun: list[tuple[int, int, set[int]]] = []

    # ------------------------------------------------------------ events

    def enter(self, frame: FrameType, event: str, argument: Any) -> Any:
        """Take the call of a function; return what takes the events within it."""
        code = frame.f_code
        if self.ended or not (code in self.sources or code in self.looks or code in self.rivals):
            return None
        if code in self.rivals and self.begun:
            self.begun[-1][2].add(self.rivals[code](frame.f_locals))
        return self.within(frame, event, argument)

    def within(self, frame: FrameType, event: str, _argument: Any) -> Any:
        """Take an event within a watched function."""
        if self.ended:
            return None
        names, source = frame.f_locals, self.sources.get(frame.f_code)
        if self.steps:
            self._settle(names, source, self.steps[-1])
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

    def _settle(self, names: Names, source: Source | None, step: Step) -> None:
        """Note what the last step has changed."""
        for slot, (function, _) in enumerate(self.slots):
            if source is None or source.name != function:
                continue
            with suppress(NameError):  # not assigned yet
                value = plain(eval(self.watched[slot], {}, names))
                if repr(self.values.get(slot)) != repr(value):
                    self.values[slot] = value
                    step.changes.append((slot, value))
        if self.read is not None:
            face, depth = self.read()
            changed = np.flatnonzero((face != self.face) | (depth != self.depth))
            if len(changed):
                found = (changed, face.flat[changed], depth.flat[changed])
                step.writes.extend(zip(*(array.tolist() for array in found), strict=True))
                self.face[:], self.depth[:] = face, depth

    def _step(self, frame: FrameType, names: Names, source: Source) -> None:
        """Begin a step, unless this is another line of the statement that is running."""
        statement = source.statement[frame.f_lineno]
        if self.at.get(frame) == statement:
            return
        if len(self.steps) == MOST_STEPS:
            told = f"more than {MOST_STEPS:,} steps are too many to record"
            raise MethodError(f"{told}; take a scene of fewer faces, such as scenes/cube.toml")
        self.at[frame] = statement
        for beat in self.probe.beats:
            if source.name == beat.function.__name__ and begins(source.lines[statement], beat.line):
                place = beat.sample(names)
                if place is not None:
                    sample, faces = place[0] * self.face.shape[1] + place[1], {beat.face(names)}
                    self.begun.append((len(self.steps), sample, faces | {int(self.face[place])}))
        self.statements.append((source.name, statement))
        self.steps.append(Step(-1, [], []))

    # ------------------------------------------------------------ the recording

    def recording(self, answer: VisibilityMap) -> Recording:
        """Put everything together."""
        listing = listing_of(list(self.sources.values()), set(self.statements))
        lines = [listing.place[statement] for statement in self.statements]
        steps = [step._replace(line=line) for step, line in zip(self.steps, lines, strict=True)]
        counters = {
            name: line
            for name, (function, text) in self.probe.counters.items()
            for line in listing.lines(text, function.__name__)[:1]
        }
        return Recording(answer, listing, self.slots, steps, list(self._turns()), counters)

    def _turns(self) -> Iterator[Turn]:
        """Yield the turns, with the owners that the writes during them leave."""
        held = np.full(self.face.size, BACKGROUND, np.int32)
        ends, done = [*(step for step, _, _ in self.begun[1:]), len(self.steps)], 0
        for (step, sample, faces), end in zip(self.begun, ends, strict=True):
            for written, face, _ in chain.from_iterable(each.writes for each in self.steps[done:end]):
                held[written] = face
            done = end
            yield Turn(step, sample, tuple(sorted(faces - {BACKGROUND})), int(held[sample]))


def plain(value: Any) -> Any:
    """Return a variable's value as a number, text, or lists of them."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return [plain(part) for part in value] if isinstance(value, tuple) else value
