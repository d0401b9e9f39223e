"""What goes with the next version, and warns until then."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from operator import index
from typing import Any, ParamSpec, TypeVar
from warnings import warn

Given = ParamSpec("Given")
Answer = TypeVar("Answer")


def sample_by_name(function: Callable[Given, Answer]) -> Callable[Given, Answer]:
    """Take row and column, after the first argument or by those names, for ``y`` and ``x``; warn of it."""

    @wraps(function)
    def named(*given: Any, **keys: Any) -> Answer:
        before = len(given) > 2 and all(hasattr(one, "__index__") for one in given[1:3])
        if before or "row" in keys:
            told = f"{function.__name__}: name the sample, x= its column, y= its row"
            warn(told, DeprecationWarning, stacklevel=2)
            row, column = given[1:3] if before else (keys.pop("row"), keys.pop("column"))
            given = given[:1] + given[3 if before else 1 :]
            keys |= {"x": index(column), "y": index(row)}
        return function(*given, **keys)

    return named
