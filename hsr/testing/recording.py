"""The checks of one test under pytest: judged, recorded, and raised if they fail."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from hsr.base.arrays import Pixels
from hsr.base.errors import CheckError, HsrError, VisibilityError
from hsr.base.files import make_folder, write_whole
from hsr.pages.checks import kept
from hsr.pages.inspector import fragment
from hsr.pages.stories import Shown
from hsr.pictures.png import save_picture
from hsr.problem.map import VisibilityMap
from hsr.scene.writing import with_files, write_scene
from hsr.testing.baselines import FOLDER, SUFFIXES, contents, file_stem, match, variants, write
from hsr.testing.checks import MIN_SIMILARITY, agreement, compared
from hsr.testing.judging import Judgement, Maps, Showing, let_through, subject_of
from hsr.testing.limits import Limits, merged

ITEMS = "items"
"""Folder among the results with a JSON file and the failed maps of every test."""

PAGE = "report.html"


@dataclass
class Check:
    """What became of one check, as the results tell it.

    Attributes
    ----------
    key : str
        Tells it from all other checks of the run.
    name : str
        How the test calls what it checked.
    passed : bool
    text : str
        The judgement, as lines.
    counts : dict of str to int
        Samples that differ, by cause.
    sample : list of 2 int or None
        [column, row] to look at first.
    shown, expected : str
        Files among the results with what was shown, and what it was judged against.
    inspection : str
        File among the results with what the page shows of them; empty without a map.
    link : str
        The end of the page's address that opens it there.
    contents : dict of str to str
        Content hashes of what was shown.
    baseline : str
        File of the baseline, seen from the project's root; empty without one.
    depths : bool
        Whether that baseline keeps depths.
    written : bool
        Whether this run wrote it.
    weaker : bool
        Whether colours were compared, and not ids.
    lets_pass : dict of str to int or None
        Planted mistakes that the check overlooks, and the samples they make wrong; None if none
        were planted.
    """

    key: str
    name: str
    passed: bool
    text: str
    counts: dict[str, int] = field(default_factory=dict)
    sample: list[int] | None = None
    shown: str = ""
    expected: str = ""
    inspection: str = ""
    link: str = ""
    contents: dict[str, str] = field(default_factory=dict)
    baseline: str = ""
    depths: bool = False
    written: bool = False
    weaker: bool = False
    lets_pass: dict[str, int] | None = None


@dataclass
class Record:
    """What became of the checks of one test, which baselines it may use, and which it has used."""

    test: str
    checks: list[Check]
    baselines: str
    used: list[str]


class Visibility:
    """Checks visibility; the fixture of that name.

    Parameters
    ----------
    test : pytest.Item
        The test, with the options that hold for it; it takes what the JUnit file says.
    results : Path
        Those of this run.
    prepare : callable
        Makes that folder ready to be written, again and again; raises an HsrError where that fails.
    limits : sequence of (str, mapping)
        Limits and who set them, the strongest first.
    """

    def __init__(
        self,
        test: Any,
        results: Path,
        prepare: Callable[[], object],
        limits: Sequence[tuple[str, Mapping[str, Any]]],
    ) -> None:
        self._test, self._results, self._prepare, self._limits = test, results, prepare, limits
        self._lost = ""
        self._baselines = test.path.parent / FOLDER / test.path.stem
        self._checks: list[Check] = []
        self._used: set[str] = set()
        self._stems: set[str] = set()
        # The names of the test's module, of its classes and of its function with its parameters.
        module, *self._names = test.nodeid.split("::")
        self._id = file_stem(module, *self._names)

    @cached_property
    def limits(self) -> Limits:
        """The limits that hold for this test."""
        return merged(self._limits)

    # ------------------------------------------------------------ checks

    def agree(
        self, maps: Maps, reference: VisibilityMap, *, scene: Showing = None, camera: str | None = None
    ) -> None:
        """Check that maps show what a reference shows; see :func:`hsr.testing.assert_agree`.

        Parameters
        ----------
        maps : mapping of str to VisibilityMap
            By the name under which a message speaks of them.
        reference : VisibilityMap
            Best the exact one.
        scene : Scene, View, str or Path, optional
            What all of them show; makes the truth known.
        camera : str, optional
            Name of the scene's camera, its first by default.

        Raises
        ------
        VisibilityError
            If a map breaks a limit.
        HsrError
            If the check cannot be made.
        """
        __tracebackhide__ = True
        found = agreement(maps, reference, self.limits, scene, camera)
        self._demand([self._judged(judgement, judgement.text()) for judgement in found])

    def equal(
        self, a: VisibilityMap, b: VisibilityMap, *, scene: Showing = None, camera: str | None = None
    ) -> None:
        """Check that map ``a`` shows the faces of map ``b``; otherwise like :meth:`agree`."""
        __tracebackhide__ = True
        self.agree({a.method: a}, b, scene=scene, camera=camera)

    def check(
        self, map: VisibilityMap, name: str | None = None, *, scene: Showing = None, camera: str | None = None
    ) -> None:
        """Check that a map shows what a stored baseline shows.

        Parameters
        ----------
        map : VisibilityMap
        name : str, optional
            Tells several checks of one test apart.
        scene, camera
            As for :meth:`agree`.

        Raises
        ------
        VisibilityError
            If no baseline matches, or there is none.
        HsrError
            If a baseline cannot be read.
        """
        __tracebackhide__ = True
        stem, called = self._stem(name), name or self._names[-1]
        subject, files = subject_of(scene, camera, map), variants(self._baselines, stem)
        if files:
            found = match(called, map, files, self.limits, subject)
            text, target = "\n".join(found.lines), found.file
            judged = found.judgement
            check = self._judged(judged, text) if judged else self._new(called, found.passed, text)
        else:
            target = self._baselines / f"{stem}{SUFFIXES[self._test.config.getini('hsr_baselines')]}"
            check = self._new(called, False, f"{called}: there is no baseline {self._seen_from_root(target)}")
        check.contents, check.baseline = contents(map), self._seen_from_root(target)
        check.depths = self.limits.depth_ulps is not None
        self._used |= {file.name for file in (*files, target)}
        if not check.passed and not check.shown:
            check.shown = self._keep(check, "shown.npz", map.save)
            view, stored = subject.view if subject else None, found.stored if files else None
            self._inspect(check, Shown(check.key, view, {called: map}, None, {}, {}, stored))
        due = "new" if not files else "failed" if not check.passed else "all"
        if self._test.config.getoption("hsr_update") in (due, "all"):
            write(target, map, check.depths)
            check.written = True
            check.text += f"\n  wrote {check.baseline}: look at it, then run again without --hsr-update"
        elif not files:
            check.text += "\n  look at what it shows, then accept it, or run with --hsr-update=new"
        self._demand([check])

    def similar(self, picture: Pixels, reference: Pixels, min_similarity: float = MIN_SIMILARITY) -> None:
        """Check that two shaded pictures look alike: weaker than any check by face id.

        Parameters
        ----------
        picture, reference : (H, W) or (H, W, 3) uint8
        min_similarity : float
            Least structural similarity, 1 for equal pictures.

        Raises
        ------
        VisibilityError
            If they look less alike.
        HsrError
            If they cannot be compared.
        """
        __tracebackhide__ = True
        passed, text = compared(picture, reference, min_similarity)
        check = self._new("pictures", passed, text)
        check.weaker = True
        if not passed:
            check.expected = self._keep(check, "expected.png", partial(save_picture, reference))
            check.shown = self._keep(check, "shown.png", partial(save_picture, picture))
            check.link = f"#{check.key}"
        self._demand([check])

    # ------------------------------------------------------------ baselines

    def _stem(self, name: str | None) -> str:
        stem = file_stem(*self._names, *([name] if name is not None else []))
        if stem in self._stems:
            raise CheckError("two checks of one test need different names: visibility.check(map, name=...)")
        self._stems.add(stem)
        return stem

    # ------------------------------------------------------------ records

    def finish(self) -> None:
        """Write what became of the checks, for whoever gathers the results of the run."""
        if not self._checks:
            return
        baselines = self._seen_from_root(self._baselines)
        record = asdict(Record(self._test.nodeid, self._checks, baselines, sorted(self._used)))
        text = json.dumps({"hsr": 1, **record}, indent=1, ensure_ascii=False)
        self._write(f"{ITEMS}/{self._id}/checks.json", partial(write_whole, data=text, what="the record"))
        if self._lost:
            self._test.user_properties.append(("visibility results", self._lost))

    def _judged(self, judgement: Judgement, text: str) -> Check:
        """Record a judgement; of a failed one keep the maps, of a passed one try planted mistakes."""
        shown, expected = judgement.difference.a, judgement.difference.b
        check = self._new(judgement.name, judgement.passed, text)
        check.counts, check.contents = judgement.counts, contents(shown)
        check.sample = list(judgement.sample[::-1]) if judgement.sample else None
        if not judgement.passed:
            check.shown = self._keep(check, "shown.npz", shown.save)
            check.expected = self._keep(check, "expected.npz", expected.save)
            commands = self._commands(check, judgement)
            self._inspect(check, _compared(check.key, judgement, commands[-1]), judgement.sample)
            check.text += f"\n  {commands[0]}" if commands[0] else ""
        elif self._test.config.getoption("hsr_selfcheck") and judgement.subject is not None:
            check.lets_pass = let_through(shown, expected, self.limits, judgement.subject)
        return check

    def _commands(self, check: Check, judgement: Judgement) -> tuple[str, str]:
        """Return the commands that explain the first sample, and any X,Y; they need a scene file."""
        scene = judgement.subject and judgement.subject.scene
        if not judgement.subject or not scene or not check.shown:
            return "", ""
        written = self._results / ITEMS / f"{check.key}-scene.toml"
        if not judgement.subject.file:
            moved = with_files(scene, lambda file: str((scene.folder / file).resolve()))
            self._keep(check, "scene.toml", partial(write_scene, moved))
        shown = self._seen_from_root(self._results / check.shown)
        how = partial(judgement.command, self._seen_from_root(written), shown)
        return how(), how("X,Y")

    def _new(self, name: str, passed: bool, text: str) -> Check:
        check = Check(f"{self._id}/{len(self._checks) + 1}", name, passed, text)
        self._checks.append(check)
        return check

    def _demand(self, checks: Sequence[Check]) -> None:
        __tracebackhide__ = True
        for check in checks:
            words = ", ".join(f"{count} {label}" for label, count in check.counts.items())
            outcome = ": ".join(filter(None, ("passed" if check.passed else "failed", words)))
            self._test.user_properties.append((f"visibility {check.name}", outcome))
            if check.shown:
                check.text += f"\n  {(self._results / PAGE).as_uri()}{check.link}"
            elif self._lost and not check.passed:
                check.text += f"\n  it is not kept: {self._lost}"
        failed = [check.text for check in checks if not check.passed]
        if failed:
            raise VisibilityError("\n".join(failed))

    # ------------------------------------------------------------ files

    def _inspect(self, check: Check, shown: Shown, sample: tuple[int, int] | None = None) -> None:
        """Keep what the page shows of maps, and how its address names what to look at first."""
        text = json.dumps(kept(shown, [sample] if sample else []))
        write = partial(write_whole, data=text, what="what the page shows")
        check.inspection = self._keep(check, "inspection.json", write)
        check.link = fragment(check.key, list(shown.maps)[-1], sample)

    def _keep(self, check: Check, what: str, write: Callable[[Path], object]) -> str:
        """Write a file of a check; return its name seen from the results, empty if that fails."""
        return self._write(f"{ITEMS}/{check.key}-{what}", write)

    def _write(self, file: str, write: Callable[[Path], object]) -> str:
        """Write a file among the results. A full disk changes no judgement: then nothing is there."""
        try:
            self._prepare()
            make_folder(self._results / ITEMS / self._id)
            write(self._results / file)
        except HsrError as error:
            self._lost = self._lost or str(error)
            return ""
        return file

    def _seen_from_root(self, file: Path) -> str:
        root = self._test.config.rootpath
        return file.relative_to(root).as_posix() if file.is_relative_to(root) else str(file)


def _compared(key: str, judgement: Judgement, command: str) -> Shown:
    """Return what the inspector shows of a judgement: what was expected, then what was judged against it."""
    found, name, subject = judgement.difference, judgement.name, judgement.subject
    expected = found.b.method if found.b.method != name else f"{name}, expected"
    why = {} if judgement.causes is None else {name: judgement.causes}
    maps = {expected: found.b, name: found.a}
    return Shown(key, subject.view if subject else None, maps, expected, {name: found}, why, command=command)
