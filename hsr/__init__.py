"""A hidden-surface comparison lab: every classic visibility method, compared sample by sample."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hsr import testing as testing
    from hsr.algorithms.registry import Method as Method
    from hsr.algorithms.registry import methods as methods
    from hsr.algorithms.registry import render as render
    from hsr.base.errors import HsrError as HsrError
    from hsr.difference.cause import causes as causes
    from hsr.difference.classes import Difference as Difference
    from hsr.difference.classes import compare as compare
    from hsr.difference.diagnosis import diagnose as diagnose
    from hsr.difference.history import history as history
    from hsr.lab.named import load as load
    from hsr.pages.notebook import report as report
    from hsr.problem.map import VisibilityMap as VisibilityMap
    from hsr.problem.map import load_map as load_map
    from hsr.problem.view import View as View
    from hsr.problem.view import view as view
    from hsr.scene.model import MatrixCamera as MatrixCamera
    from hsr.scene.model import Orthographic as Orthographic
    from hsr.scene.model import Perspective as Perspective
    from hsr.scene.model import Scene as Scene

__version__ = "0.2.0"

# Imported on first use: `hsr --help` must not wait for numba or scipy. What makes scenes comes by way of
# those who give them what notebooks show and, through the view, their geometry.
_HOME = {
    "Difference": "hsr.difference.classes",
    "HsrError": "hsr.base.errors",
    "MatrixCamera": "hsr.problem.view",
    "Method": "hsr.algorithms.registry",
    "Orthographic": "hsr.problem.view",
    "Perspective": "hsr.problem.view",
    "Scene": "hsr.pages.notebook",
    "View": "hsr.problem.view",
    "VisibilityMap": "hsr.problem.map",
    "causes": "hsr.difference.cause",
    "compare": "hsr.difference.classes",
    "diagnose": "hsr.difference.diagnosis",
    "history": "hsr.difference.history",
    "load": "hsr.pages.notebook",
    "load_map": "hsr.problem.map",
    "methods": "hsr.algorithms.registry",
    "render": "hsr.algorithms.registry",
    "report": "hsr.pages.notebook",
    "view": "hsr.problem.view",
}

__all__ = [*sorted(_HOME), "__version__", "testing"]


def __getattr__(name: str) -> Any:
    if name == "testing":
        return importlib.import_module("hsr.testing")
    if name not in _HOME:
        raise AttributeError(f"module 'hsr' has no attribute {name!r}")
    return getattr(importlib.import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
