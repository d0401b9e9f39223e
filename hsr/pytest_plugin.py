"""The pytest plug-in: the fixture ``visibility``, and the results of all its checks.

It is on wherever the package is installed, and costs nothing until a test asks for the fixture: only the
standard library and pytest are imported before.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Generator, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from hsr.base.errors import HsrError, NoOpenGLError, UnavailableError
from hsr.base.files import make_folder, write_whole

if TYPE_CHECKING:
    from hsr.testing.recording import Visibility

FIXTURE = "visibility"
UPDATES = ("failed", "new", "all")
UNUSED = ("warn", "fail", "ignore")
RESULTS = ".hsr-results"
MARK = ".gitignore"
LOST = "visibility results"
"""Among a test's properties: why some of its results are not kept."""
OURS = "# results of visibility checks, written anew by every run\n*\n"
"""What the .gitignore says in the folder of results: that it is ours to empty."""


def _causes(text: str) -> frozenset[str]:
    return frozenset(name.strip() for name in text.split(",") if name.strip())


def _pair(text: str) -> tuple[int, ...]:
    return tuple(int(number) for number in text.split(","))


LIMITS: dict[str, tuple[Any, str]] = {
    "max_diff_pixels": (int, "samples that may show another face"),
    "max_diff_ratio": (float, "share of samples that may show another face"),
    "max_cluster": (int, "samples of another face that may hang together"),
    "max_in_window": (_pair, "SIDE,MOST: samples of another face that may lie in any window of that side"),
    "expect_diff": (_pair, "LOW,HIGH: how many samples must show another face"),
    "depth_ulps": (float, "spacings of stored depths that depths may differ by"),
    "allow": (_causes, "causes that are forgiven, comma separated"),
    "model": (str, "what made the maps: exact, opengl, float32, float64 or a method"),
    "subpixel_bits": (int, "of the model: bits of a pixel that corners keep"),
    "depth_format": (str, "of the model: what its depth buffer holds"),
    "fill_rule": (str, "of the model: who owns samples on edges, top-left or bottom-left"),
}
"""Each limit, how its text is read, and what it says."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options, and the same keys for ini files."""
    group = parser.getgroup("hsr", "visibility")
    group.addoption("--hsr-update", choices=UPDATES, default="", help="write baselines; tests still fail")
    group.addoption("--hsr-results", metavar="DIR", help=f"folder of results, {RESULTS} by default")
    group.addoption("--hsr-selfcheck", action="store_true", help="try every check on planted mistakes")
    group.addoption("--hsr-require-gl", action="store_true", help="fail, not skip, where OpenGL is missing")
    group.addoption("--hsr-unused", choices=UNUSED, default="warn", help="what unused baselines do")
    parser.addini("hsr_results", f"folder of results, {RESULTS} by default", default="")
    parser.addini("hsr_baselines", "what baselines keep: maps, or hashes alone", default="maps")
    for name, (_, about) in LIMITS.items():
        group.addoption(f"--hsr-{name.replace('_', '-')}", metavar="VALUE", help=about)
        parser.addini(f"hsr_{name}", about, default="")


def pytest_configure(config: pytest.Config) -> None:
    """Check the options; let the process that starts the others gather the results."""
    config.addinivalue_line("markers", f"{FIXTURE}({', '.join(f'{name}=' for name in LIMITS)}): limits")
    if config.getoption("hsr_update") and os.environ.get("CI"):
        raise pytest.UsageError("--hsr-update is refused where CI is set: write baselines where you can look")
    keep = config.getini("hsr_baselines")
    if keep not in ("maps", "hashes"):
        raise pytest.UsageError(f"hsr_baselines: expected maps or hashes, got {keep!r}")
    list(_limits(config))
    kind = _Worker if hasattr(config, "workerinput") else _Gatherer
    config.pluginmanager.register(kind(config), "hsr-gatherer")


# ---------------------------------------------------------------- the fixture


@pytest.fixture
def visibility(request: pytest.FixtureRequest) -> Iterator[Visibility]:
    """Check visibility by face id: ``agree``, ``equal``, ``check``, ``similar``."""
    from hsr.testing.recording import Visibility

    test, results = request.node, _results(request.config)
    markers = [("marker", mark.kwargs) for mark in test.iter_markers(FIXTURE)]
    checks = Visibility(test, results, partial(_prepare, results), [*markers, *_limits(request.config)])
    yield checks
    checks.finish()


def _limits(config: pytest.Config) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield the limits of the command line, then those of the ini file, and who says so."""
    file = config.inipath.name if config.inipath else "ini"
    for who, given in (("command line", config.getoption), (file, config.getini)):
        texts = {name: given(f"hsr_{name}") for name in LIMITS}
        yield who, {name: _read(who, name, text) for name, text in texts.items() if text}


def _read(who: str, name: str, text: str) -> Any:
    try:
        return LIMITS[name][0](text)
    except ValueError:
        raise pytest.UsageError(f"{who}: {name}={text!r} is no number") from None


def _results(config: pytest.Config) -> Path:
    option = config.getoption("hsr_results")
    folder = config.invocation_params.dir if option else config.rootpath
    return Path(folder, option or config.getini("hsr_results") or RESULTS).resolve()


def _check_results(results: Path) -> None:
    """Refuse a folder of results that holds what is not ours."""
    if results.exists() and not results.is_dir():
        raise pytest.UsageError(f"{results}: results need a folder, and this is a file")
    # The mark is written before anything else, so whoever sees more sees the mark, too. Its name is another
    # as long as it is unfinished, see write_whole.
    marks = MARK, f".{MARK}."
    strange = results.is_dir() and any(not file.name.startswith(marks) for file in results.iterdir())
    if strange and not _ours(results):
        raise pytest.UsageError(f"{results}: not empty, and no results of checks; name another folder")


def _prepare(results: Path) -> None:
    """Make the folder of results, and say that it is ours."""
    make_folder(results)
    if not _ours(results):  # whoever else says so at the same time
        write_whole(results / MARK, OURS, "the mark of the results")


def _ours(results: Path) -> bool:
    mark = results / MARK
    return mark.is_file() and mark.read_text(encoding="utf-8", errors="replace") == OURS


# ---------------------------------------------------------------- what this machine lacks


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, None, None]:
    """Skip a test that needs what this machine lacks, by itself or by its fixtures."""
    __tracebackhide__ = True
    try:
        yield
    except UnavailableError as error:
        ours = FIXTURE in getattr(item, "fixturenames", ()) or item.get_closest_marker(FIXTURE)
        required = isinstance(error, NoOpenGLError) and item.config.getoption("hsr_require_gl")
        if required or not ours:
            raise
        pytest.skip(str(error))


pytest_runtest_setup = pytest_runtest_call


# ---------------------------------------------------------------- the results of a run


class _Worker:
    """In a process that runs tests for another: tells it whether some were left out."""

    def __init__(self, config: Any) -> None:
        self._output = config.workeroutput
        self._output["hsr_deselected"] = False

    def pytest_deselected(self, items: Sequence[pytest.Item]) -> None:
        self._output["hsr_deselected"] |= bool(items)


class _Gatherer:
    """In the one process that reports: gathers what the tests recorded, wherever they ran."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._results = _results(config)
        self._partial = any("::" in argument for argument in config.args)
        self._passed: dict[str, bool] = {}
        self._lines: list[str] = []
        self._lost, self._stale = "", False

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionstart(self) -> None:
        """Forget the last run."""
        _check_results(self._results)
        if _ours(self._results) and not self._config.option.collectonly:
            try:
                for entry in self._results.iterdir():
                    if entry.is_dir():
                        shutil.rmtree(entry)
                    elif entry.name != MARK:
                        entry.unlink()
            except OSError as error:
                self._lost = f"{self._results}: those of the last run are still there: {error.strerror}"
                self._stale = True

    def pytest_deselected(self, items: Sequence[pytest.Item]) -> None:
        self._partial |= bool(items)

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        """Take over what another process left out; one that died says nothing."""
        self._partial |= getattr(node, "workeroutput", {}).get("hsr_deselected", True)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Remember of each module whether all its tests ran and passed: then they used what they need."""
        module, passed = report.nodeid.partition("::")[0], report.passed and not hasattr(report, "wasxfail")
        self._passed[module] = self._passed.get(module, True) and passed
        self._lost = self._lost or str(dict(report.user_properties).get(LOST, ""))

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Write the results, if there are any."""
        option = self._config.option
        recorded = not self._stale and any(self._results.glob("*/*/checks.json"))
        if option.collectonly or not (recorded or self._lost or option.hsr_selfcheck):
            return
        fails = option.hsr_selfcheck
        if recorded:
            self._lines, fails = self._gathered(session)
        elif fails:
            self._lines = ["no check was tried on planted mistakes: there is none"]
        if self._lost:
            self._lines.append(f"the results are not whole: {self._lost}")
        if fails and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def _gathered(self, session: pytest.Session) -> tuple[list[str], bool]:
        """Gather the results; where they cannot be, that is said, and tests are judged all the same."""
        from hsr.testing.results import gather

        option, root = self._config.option, self._config.rootpath
        partial = self._partial or session.shouldstop or session.shouldfail
        whole = [root / module for module, passed in self._passed.items() if passed and not partial]
        try:
            return gather(self._results, root, whole, option.hsr_unused, option.hsr_selfcheck)
        except HsrError as error:
            fails = option.hsr_selfcheck or option.hsr_unused == "fail"
            return [f"the results are not whole: {error}"], fails

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Say where the results are, and what no test used."""
        if self._lines:
            terminalreporter.section("visibility")
            terminalreporter.write_line("\n".join(self._lines))
