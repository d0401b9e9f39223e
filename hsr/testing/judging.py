"""From two maps to a judgement: what they show, what differs, why, and which limit that breaks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from hsr.algorithms.registry import methods, render
from hsr.base.arrays import Bools
from hsr.base.errors import CheckError
from hsr.difference.cause import Causes, explained
from hsr.difference.classes import OTHER_OWNER, Cluster, Difference, agreed_depths, compare, depth_step
from hsr.difference.diagnosis import Diagnosis, diagnose
from hsr.difference.history import explain, history
from hsr.mistakes.planted import MISTAKES, planted
from hsr.models.foreign import has_model, modelled, told_of
from hsr.models.stages import Cause
from hsr.problem.map import VisibilityMap
from hsr.problem.view import View, view
from hsr.scene.files import load
from hsr.scene.model import Scene
from hsr.testing.limits import REFERENCE_WRONG, Limits

Showing = Scene | View | str | Path | None
"""What a test may give as its scene: a scene, its file, the view itself, or nothing."""


Files = Iterable[str | Path]

Maps = Mapping[str, VisibilityMap]
"""Maps by the name under which a message speaks of them."""


@dataclass(frozen=True, eq=False)
class Subject:
    """What the maps of a check show, where the test says so: it makes the truth known.

    Attributes
    ----------
    view : View
    file : str
        The scene file, empty if the test names none.
    scene : Scene or None
        The scene, None if the test gives a view alone.
    camera : str
        Name of the camera in it, empty for the first.
    """

    view: View
    file: str = ""
    scene: Scene | None = None
    camera: str = ""

    @cached_property
    def truth(self) -> VisibilityMap:
        """The exact map, with its ties."""
        return render(self.view, "exact")


@dataclass(frozen=True, eq=False)
class Group:
    """The samples that differ for one cause.

    Attributes
    ----------
    label : str
        The cause, or the class of difference where no cause is known.
    allowed : bool
        Whether the test forgives it.
    clusters : tuple of Cluster
        The largest first.
    story : str
        What happened at the first sample, in one sentence; empty where the scene is not known.
    """

    label: str
    allowed: bool
    clusters: tuple[Cluster, ...]
    story: str = ""

    @property
    def count(self) -> int:
        """Number of samples."""
        return sum(cluster.size for cluster in self.clusters)


@dataclass(frozen=True, eq=False)
class Judgement:
    """What became of one map.

    Attributes
    ----------
    name : str
        How the test calls the map.
    difference : Difference
        From the map it was judged against.
    groups : tuple of Group
        By cause: those that count before those forgiven, each by falling number of samples.
    ties : int
        Samples with another face that may own them as well. They never count.
    counted : int
        Samples that count.
    broken : tuple of str
        The limits that are broken, in words.
    subject : Subject or None
        What both maps show, where the test says so.
    causes : Causes or None
        Why samples are wrong, where the truth is known and the method has models.
    """

    name: str
    difference: Difference
    groups: tuple[Group, ...]
    ties: int
    counted: int
    broken: tuple[str, ...]
    subject: Subject | None
    causes: Causes | None

    @property
    def passed(self) -> bool:
        """Whether no limit is broken."""
        return not self.broken

    @property
    def counts(self) -> dict[str, int]:
        """Number of samples by cause."""
        return {group.label: group.count for group in self.groups}

    @property
    def sample(self) -> tuple[int, int] | None:
        """(row, column) of the sample to look at first."""
        return self.groups[0].clusters[0].sample if self.groups else self.difference.depth.where

    @property
    def modelled(self) -> list[str]:
        """By which model the causes were found, in words, if the map notes one."""
        made_by = told_of(self.difference.a)
        return [f"causes by the model {made_by}"] if self.causes and made_by else []

    @cached_property
    def diagnoses(self) -> tuple[Diagnosis, ...]:
        """Mistakes that account for what differs; see :func:`hsr.diagnose`."""
        view = None if self.subject is None else self.subject.view
        return diagnose(self.difference.a, self.difference.b, view)

    def text(self) -> str:
        """Return the judgement as lines for people."""
        return "\n".join(self._lines())

    def command(self, scene_file: str = "", map_file: str = "", sample: str = "") -> str:
        """Return the command that tells all about a sample; empty without a scene file.

        Parameters
        ----------
        scene_file : str
            Where the scene was written, if the test names no file of it.
        map_file : str
            Where the judged map was written, if it was.
        sample : str
            Column and row, the first sample by default.
        """
        if self.subject is None or self.sample is None or not (self.subject.file or scene_file):
            return ""
        row, column = self.sample
        shown, scene = self.difference.a, self.subject.file or scene_file
        known = ["-a", shown.method] if shown.method in methods() else []
        asked = ["--map", map_file] if map_file else known
        place, size = sample or f"{column},{row}", (shown.width, shown.height)
        return explain(scene, place, size, self.subject.camera, asked)

    def _lines(self) -> Iterator[str]:
        shown, expected = self.difference.a, self.difference.b
        forgiven = sum(group.count for group in self.groups if group.allowed)
        parts = [f"{self.counted} samples count as different"]
        parts += [f"{forgiven} allowed by cause"] if forgiven else []
        parts += [f"{self.ties} ties, which never count"] if self.ties else []
        yield f"{self.name} vs {expected.method}, {shown.width}x{shown.height}: {', '.join(parts)}"
        for group in self.groups:
            number, allowed = len(group.clusters), " (allowed)" if group.allowed else ""
            clusters = f"{number} cluster{'' if number == 1 else 's'}"
            largest = self.difference.describe(group.clusters[0])
            yield f"  {group.label} {group.count}{allowed}, {clusters}, the largest: {largest}"
            if group.story:
                yield f"    {group.story}"
        yield from (f"  {line}" for line in self.modelled)
        yield from (f"  limit {line}" for line in self.broken)
        if not self.passed:
            yield from (f"  diagnosis: {found}" for found in self.diagnoses)


# ---------------------------------------------------------------- judging


def subject_of(scene: Showing, camera: str | None, shown: VisibilityMap) -> Subject | None:
    """Return what a map shows, from what a test says of it; nothing if it says nothing.

    Parameters
    ----------
    scene : Scene, View, str, Path or None
    camera : str or None
        Name of the camera; the scene's first by default.
    shown : VisibilityMap
        Gives the size of the image.

    Raises
    ------
    HsrError
        If the scene cannot be read, has no such camera, or the map is not one of its faces.
    """
    if scene is None:
        return None
    file = str(scene) if isinstance(scene, str | Path) else ""
    given = load(file) if file else scene
    if isinstance(given, Scene):
        found = Subject(view(given, (shown.width, shown.height), camera), file, given, camera or "")
    elif isinstance(given, View):
        found = Subject(given)
    else:
        raise CheckError(f"scene must be a scene, its file or a view, not {type(scene).__name__}")
    if (found.view.width, found.view.height) != (shown.width, shown.height):
        sizes = f"{shown.width}x{shown.height} samples and the view {found.view.width}x{found.view.height}"
        raise CheckError(f"the map of {shown.method} has {sizes}; render it at that size")
    if shown.manifest and shown.manifest != found.view.manifest:
        raise CheckError(f"the map of {shown.method} has other faces than the scene; leave 'scene' out")
    return found


def judge(
    name: str, shown: VisibilityMap, expected: VisibilityMap, limits: Limits, subject: Subject | None = None
) -> Judgement:
    """Judge a map against another, by face id.

    The truth is known if ``expected`` knows its ties, as a map by ``exact`` does, or if the subject is
    given. Then samples at which both faces may be the owner are ties, and no differences; with the
    subject given, the others are told apart by the cause that makes them wrong, see
    :func:`hsr.difference.cause.causes`, where the method of ``shown`` has models.

    Parameters
    ----------
    name : str
        How the test calls the map.
    shown : VisibilityMap
    expected : VisibilityMap
    limits : Limits
    subject : Subject, optional
        What both show.

    Returns
    -------
    Judgement

    Raises
    ------
    MapError
        If the maps differ in size, scene or camera.
    CheckError
        If depths are to be judged that a map does not tell.
    """
    if limits.made_by and not has_model(shown):
        shown = modelled(shown, **limits.made_by)
    difference = compare(shown, expected)
    truth = expected if expected.admissible is not None or subject is None else subject.truth
    other = shown.face != expected.face
    tied = other & truth.admits(shown.face) & truth.admits(expected.face)
    apart, why = other & ~tied, None
    if subject is not None and apart.any():
        shown, why = explained(subject.view, shown, truth)
        difference = replace(difference, a=shown)
    masks = _masks(difference, apart, apart & ~truth.admits(shown.face), why)
    counted = apart & ~np.any([mask for label, mask in masks.items() if label in limits.allow], axis=0)
    groups = [_group(label, mask, difference, limits, subject) for label, mask in masks.items()]
    groups.sort(key=lambda group: (group.allowed, -group.count))
    broken = (*_broken_counts(difference, counted, limits), *_broken_depths(difference, limits))
    ties, count = int(np.count_nonzero(tied)), int(np.count_nonzero(counted))
    return Judgement(name, difference, tuple(groups), ties, count, broken, subject, why)


# ---------------------------------------------------------------- what differs, and why


def _masks(difference: Difference, apart: Bools, wrong: Bools, why: Causes | None) -> dict[str, Bools]:
    """Part the samples that differ by what makes them so: by cause if that is known, else by class."""
    kinds, found = (OTHER_OWNER, difference.classes) if why is None else (Cause, why.cause)
    masks = {REFERENCE_WRONG: apart & ~wrong, **{kind.label: wrong & (found == kind) for kind in kinds}}
    return {label: mask for label, mask in masks.items() if mask.any()}


def _group(label: str, mask: Bools, difference: Difference, limits: Limits, subject: Subject | None) -> Group:
    clusters, allowed = difference.clusters_of(mask), label in limits.allow
    if subject is None:
        return Group(label, allowed, clusters)
    wrong = difference.b if label == REFERENCE_WRONG else difference.a
    y, x = clusters[0].sample
    told = history(subject.view, [wrong], x=x, y=y)
    return Group(label, allowed, clusters, told.stories[0].sentence)


# ---------------------------------------------------------------- limits


def _broken_counts(difference: Difference, counted: Bools, limits: Limits) -> Iterator[str]:
    count = int(np.count_nonzero(counted))
    if limits.max_diff_pixels is not None and count > limits.max_diff_pixels:
        yield f"{limits.told('max_diff_pixels')}: {count} differ"
    if limits.max_diff_ratio is not None and count > limits.max_diff_ratio * counted.size:
        yield f"{limits.told('max_diff_ratio')}: {count / counted.size:.3g} of the samples differ"
    if limits.expect_diff is not None and not limits.expect_diff[0] <= count <= limits.expect_diff[1]:
        yield f"{limits.told('expect_diff')}: {count} differ"
    if limits.max_in_window is not None:
        yield from _broken_window(counted, limits)
    if limits.max_cluster is not None and count:
        largest = difference.clusters_of(counted)[0]
        if largest.size > limits.max_cluster:
            row, column = largest.sample
            together = f"{largest.size} hang together at column {column}, row {row}"
            yield f"{limits.told('max_cluster')}: {together}"


def _broken_window(counted: Bools, limits: Limits) -> Iterator[str]:
    """Count the samples in every window, by sums of all that lies above and left of a corner."""
    side, most = limits.max_in_window or (0, 0)
    high, wide = (min(side, length) for length in counted.shape)
    total = np.pad(counted.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    inside = total[high:, wide:] - total[:-high, wide:] - total[high:, :-wide] + total[:-high, :-wide]
    if inside.max() > most:
        row, column = np.unravel_index(inside.argmax(), inside.shape)
        where = f"in the window from column {column}, row {row}"
        yield f"{limits.told('max_in_window')}: {inside.max()} differ {where}"


def _broken_depths(difference: Difference, limits: Limits) -> Iterator[str]:
    """Compare the depths of samples at which both maps show the same face."""
    if limits.depth_ulps is None:
        return
    a, b = difference.a, difference.b
    for shown in (a, b):
        if not shown.tells_depth:
            raise CheckError(f"{limits.told('depth_ulps')}: the map of {shown.method} tells no depths")
    samples, depth, expected = agreed_depths(a, b)
    with np.errstate(invalid="ignore"):  # infinite depths: no number, so never within a limit
        gap = np.abs(depth - expected) / depth_step(a, depth)
    beyond = ~(gap <= limits.depth_ulps)
    if beyond.any():
        row, column = divmod(int(samples[gap.argmax()]), a.width)
        worst = f"most at column {column}, row {row}, by {gap.max():.3g}"
        yield f"{limits.told('depth_ulps')}: {beyond.sum()} depths differ, {worst}"


# ---------------------------------------------------------------- self-check


def let_through(
    shown: VisibilityMap, expected: VisibilityMap, limits: Limits, subject: Subject
) -> dict[str, int]:
    """Find the mistakes that a check would not notice.

    Parameters
    ----------
    shown, expected : VisibilityMap
        What the check compares.
    limits : Limits
    subject : Subject

    Returns
    -------
    dict of str to int
        By mistake, the number of samples that it makes wrong and the check lets pass. Mistakes that
        do not show in this view are not among them.
    """
    found = {}
    for mistake in MISTAKES:
        changed = planted(mistake, shown, subject.view)
        wrong = int(np.count_nonzero(~subject.truth.admits(changed.face) & (changed.face != shown.face)))
        if wrong and judge(mistake, changed, expected, limits, subject).passed:
            found[mistake] = wrong
    return found
