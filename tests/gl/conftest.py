"""Contexts for the tests, or the reason why there are none."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from hsr.base.errors import UnavailableError
from hsr.gl.backends import BACKENDS, open_context
from hsr.gl.context import Context


def opened(backend: str) -> Context:
    """Open a context, or skip where there is none; one that draws wrongly may be our own mistake."""
    try:
        return open_context(backend)
    except UnavailableError as error:
        if "test picture" in str(error):
            raise
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def context() -> Iterator[Context]:
    context = opened("auto")
    yield context
    context.release()


@pytest.fixture(params=sorted(BACKENDS))
def backend(request: pytest.FixtureRequest) -> str:
    opened(request.param).release()
    return str(request.param)
