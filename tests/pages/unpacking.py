"""Takes apart what the page packs, in another way than the page does."""

from __future__ import annotations

import base64
import json
import re
import zlib
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


def unpack_alike(packed: str) -> list[Any]:
    """Return the values that were packed."""
    kept = unpack_json(packed)
    numbers = [[iter(column.split(" ")) for column in columns] for columns in kept["columns"]]

    def filled(form: Any) -> Any:
        if isinstance(form, bool):
            return form
        if isinstance(form, int):
            row = map(next, numbers[form])
            return re.sub("\0", lambda _: next(row), kept["texts"][form])
        if isinstance(form, dict):
            return {key: filled(part) for key, part in form.items()}
        return [filled(part) for part in form]

    return [filled(kept["forms"][place]) for place in kept["values"]]


def stories_of(scene: Any) -> dict[int, Any]:
    """Return the histories of a scene by the numbers of their samples."""
    return dict(zip(unpack(scene["told"]).tolist(), unpack_alike(scene["stories"]), strict=True))


def scene_of(page: str, number: int = 0) -> Any:
    """Return the data of a scene within a page."""
    found = re.search(rf'<script type="application/json" id="data-{number}">(.*?)</script>', page, re.DOTALL)
    assert found
    return json.loads(found[1])
