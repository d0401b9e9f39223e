"""The kernels as the Python functions they are written as, so that a trace function sees their lines."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numba.core.dispatcher import Dispatcher

KERNELS = "hsr.kernels."


def python_of(kernel: Callable[..., Any]) -> Callable[..., Any]:
    """Return the Python function of a kernel, compiled or not."""
    return getattr(kernel, "py_func", kernel)


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
        if isinstance(value, Dispatcher) and value.py_func.__module__.startswith(KERNELS)
    ]
    try:
        for names, name, kernel in compiled:
            names[name] = kernel.py_func
        with np.errstate(over="ignore"):
            yield
    finally:
        for names, name, kernel in compiled:
            names[name] = kernel
