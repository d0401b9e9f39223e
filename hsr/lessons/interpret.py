"""The kernels as the Python functions they are written as, so that a trace function sees their lines."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

KERNELS = "hsr.kernels."


def python_of(kernel: Callable[..., Any]) -> Callable[..., Any]:
    """Return the Python function of a kernel, compiled or not."""
    return getattr(kernel, "py_func", kernel)


@contextmanager
def interpreted() -> Iterator[None]:
    """Let the kernels call each other's Python functions instead of the compiled ones.

    Only names within the kernels' modules change, and only until the end of the ``with`` block. Keys of depth
    buffers are unsigned and wrap around on purpose, of which NumPy would warn.
    """
    modules = [module for name, module in sys.modules.items() if name.startswith(KERNELS)]
    compiled = [
        (vars(module), name, value)
        for module in modules
        for name, value in vars(module).items()
        if hasattr(value, "py_func")
    ]
    try:
        for names, name, kernel in compiled:
            names[name] = kernel.py_func
        with np.errstate(over="ignore"):
            yield
    finally:
        for names, name, kernel in compiled:
            names[name] = kernel
