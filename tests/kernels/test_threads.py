"""Where threads may run."""

from __future__ import annotations

import ctypes
import os
import threading

import numba
import numpy as np
import pytest

from hsr.kernels import threads

LINUX = hasattr(os, "sched_getaffinity")


@pytest.mark.jit
@pytest.mark.skipif(not LINUX, reason="only Linux binds threads")
def test_helpers_stay_off_the_processor_of_their_caller_meanwhile() -> None:
    own = os.sched_getaffinity(0)
    helpers = threads._helpers()
    assert len(helpers) == numba.get_num_threads() - 1
    with threads.threads_apart():
        for helper in helpers:
            assert len(own - os.sched_getaffinity(helper)) == (1 if len(own) > 1 else 0)
        assert os.sched_getaffinity(0) == own
    assert all(os.sched_getaffinity(helper) == own for helper in helpers)


@pytest.mark.jit
def test_each_share_is_run_by_a_thread_of_its_own() -> None:
    ids = np.zeros(numba.get_num_threads(), np.int32)
    threads.note_ids(ids)
    assert len(set(ids.tolist())) == len(ids) and ids[0] == threading.get_native_id()


@pytest.mark.parametrize("where", ["sched_getaffinity", "sched_setaffinity", "CDLL"])
@pytest.mark.parametrize("error", [OSError, AttributeError, TypeError])
def test_what_the_system_does_not_offer_is_left_alone(
    error: type[Exception], where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise error

    monkeypatch.setattr(ctypes if where == "CDLL" else os, where, refuse, raising=False)
    with threads.threads_apart():
        pass
