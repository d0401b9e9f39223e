"""What an option of a method may be."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from hsr.base.errors import MethodError, nearest


def check(method: str, options: Any, choices: Mapping[str, Collection[Any]]) -> None:
    """Refuse options of a method that are none of their choices.

    Raises
    ------
    MethodError
        The first of them, and what it may be.
    """
    for name, known in choices.items():
        value = getattr(options, name)
        if value not in known:
            near, told = nearest(value, map(str, known)), ", ".join(str(choice).lower() for choice in known)
            raise MethodError(f"{method} has no {name} {value!r}; {near}choose from {told}")
