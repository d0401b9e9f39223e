"""The one Numba decorator of the package.

No ``fastmath``, not even contraction of ``a * b + c``: the signs that decide visibility must be
those of plain IEEE arithmetic, on every processor. ``error_model="numpy"`` makes a division by
zero an infinity instead of an exception. Compiled kernels are cached on disk.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, TypeVar, cast

# An idle thread of GNU OpenMP spins at its barrier: on a busy machine a 2 ms kernel takes 24 ms.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
os.environ.setdefault("GOMP_SPINCOUNT", "0")

import numba

Function = TypeVar("Function", bound=Callable[..., Any])

prange = numba.prange


def jit(function: Function) -> Function:
    """Compile a kernel of numbers and arrays for one thread."""
    return cast(Function, numba.njit(cache=True, error_model="numpy", nogil=True)(function))


def parallel_jit(function: Function) -> Function:
    """Compile a kernel whose ``prange`` loops run on all threads.

    The result must not depend on how the iterations are shared out among the threads.
    """
    return cast(Function, numba.njit(cache=True, error_model="numpy", parallel=True)(function))
