"""The hard cases, a file a theme. Whatever a file of this folder calls a hard case takes part."""

from __future__ import annotations

import pkgutil
from functools import cache
from importlib import import_module

from hsr.base.errors import named
from hsr.lab.stability.family import GROUPS, Family


@cache
def families() -> dict[str, Family]:
    """Return all families by name, in the order of their groups."""
    modules = [import_module(f"{__name__}.{found.name}") for found in pkgutil.iter_modules(__path__)]
    found = {it.name: it for module in modules for it in vars(module).values() if isinstance(it, Family)}
    groups = list(GROUPS)
    return dict(sorted(found.items(), key=lambda item: (groups.index(item[1].group), item[0])))


def family_named(name: str) -> Family:
    """Return one family.

    Raises
    ------
    HsrError
        If no family has that name.
    """
    return named(name, families(), "no family is named")
