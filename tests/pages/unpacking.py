"""Takes apart what the page packs, in another way than the page does."""

from __future__ import annotations

import base64
import json
import re
import zlib
from itertools import repeat
from typing import Any

import numpy as np


def unpack(packed: dict[str, Any]) -> Any:
    """Return the array that was packed."""
    data = zlib.decompress(base64.b64decode(packed["data"]))
    array = np.frombuffer(data, packed["type"]).reshape(packed["shape"])
    for axis in reversed(packed["axes"]):
        array = np.cumsum(array, axis=axis, dtype=array.dtype)
    return array


def unpack_json(packed: str) -> Any:
    """Return the JSON values that were packed."""
    return json.loads(zlib.decompress(base64.b64decode(packed)))


def unpack_told(packed: str) -> list[list[tuple[str, str]]]:
    """Return the lines that were packed, each with what it is."""
    kept = unpack_json(packed)
    rows = [zip(*columns, strict=True) if columns else repeat(()) for columns in kept["columns"]]
    forms = kept["forms"]

    def filled(form: str, values: Any) -> str:
        gaps = iter(values)
        return re.sub(r"{(.*?)}", lambda gap: shown(gap[0], next(gaps)), form)

    def shown(gap: str, value: Any) -> str:
        return value if isinstance(value, str) else gap.format(value)

    return [[(forms[k][0], filled(forms[k][1], next(rows[k]))) for k in lines] for lines in kept["lines"]]


def stories_of(scene: Any) -> dict[int, list[tuple[str, str]]]:
    """Return the histories of a scene by the numbers of their samples."""
    return dict(zip(unpack(scene["told"]).tolist(), unpack_told(scene["stories"]), strict=True))


def scene_of(page: str, number: int = 0) -> Any:
    """Return the data of a scene within a page."""
    found = re.search(rf'<script type="application/json" id="data-{number}">(.*?)</script>', page, re.DOTALL)
    assert found
    return json.loads(found[1])
