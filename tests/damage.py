"""Damage to what a file tells, of every kind that JSON allows; seeded."""

from __future__ import annotations

import copy
import random
from collections.abc import Iterator
from typing import Any

STRANGE = [
    None,
    True,
    -1,
    0,
    7,
    10**30,
    1e308,
    -0.5,
    float("nan"),
    float("inf"),
    "",
    "a\nb",
    "\ud800",
    [],
    {},
]
STRANGE += [[[]], {"a": 1}, [{}], [None]]


def damaged(value: Any, count: int) -> Iterator[Any]:
    """Yield ``count`` copies of a JSON value with something in it replaced, left out, or doubled."""
    chance = random.Random(0)
    for _ in range(count):
        whole = [copy.deepcopy(value)]
        for _ in range(chance.choice((1, 1, 1, 2, 4))):
            holder, key = chance.choice([*_places(whole)])
            what = chance.randrange(6)
            if what == 0 and holder is not whole:
                del holder[key]
            elif what == 1 and isinstance(holder, list) and holder is not whole:
                holder.append(copy.deepcopy(holder[key]))
            else:
                holder[key] = copy.deepcopy(chance.choice(STRANGE))
        yield whole[0]


def _places(value: Any) -> Iterator[tuple[Any, Any]]:
    keys = list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    for key in keys:
        yield value, key
        yield from _places(value[key])
