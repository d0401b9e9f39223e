"""The threads that share the iterations of parallel loops."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from typing import Any

import numba
import numpy as np

from hsr.base.arrays import Ints
from hsr.base.jit import parallel_jit, prange, thread_count

thread_id: Any = numba.types.ExternalFunction("gettid", numba.types.int32())
"""The C library's, of Linux."""


@contextmanager
def threads_apart() -> Iterator[None]:
    """Keep the threads that help the calling one in loops off its processor, within the ``with`` block.

    On a virtual machine an idle processor may look busy to the system, which then wakes a thread on the
    processor of its waker, where it has to wait until that has done its own share: of two threads that had
    slept, seven in ten ran one after the other. Where else they run is left to the system; so is all where it
    is not Linux, or forbids it. For the first thread of a program that asks.
    """
    allowed: dict[int, set[int]] = {}
    # Windows answers the question for the C library with a TypeError.
    with suppress(AttributeError, OSError, TypeError):
        here = {ctypes.CDLL(None).sched_getcpu()}
        for helper in _helpers():
            before = os.sched_getaffinity(helper)
            if before & here and before - here:
                os.sched_setaffinity(helper, before - here)
                allowed[helper] = before
    try:
        yield
    finally:
        with suppress(OSError):
            for helper, before in allowed.items():
                os.sched_setaffinity(helper, before)


@cache
def _helpers() -> tuple[int, ...]:
    """Return the ids of the threads that help the calling one."""
    # Without the JIT there is one thread.
    if not hasattr(note_ids, "py_func") or not hasattr(ctypes.CDLL(None), "gettid"):
        return ()
    ids = np.zeros(thread_count(), np.int32)
    note_ids(ids)
    return tuple(set(ids.tolist()) - {ids[0]})


@parallel_jit
def note_ids(ids: Ints) -> None:
    """Note by which thread each iteration runs."""
    for k in prange(len(ids)):
        ids[k] = thread_id()
