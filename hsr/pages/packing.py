"""Arrays and texts as short text in a page: differences along axes, deflated, in base64.

A browser takes them apart by ``atob`` and ``DecompressionStream``, and sums the differences up again.
Texts that differ in their numbers alone are kept once, and the numbers in columns, whose digits are much
alike.
"""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections.abc import Iterable
from typing import Any

import numpy as np

from hsr.base.arrays import Array

LEVEL = 9
"""Of deflate: a page is written once and kept."""


def pack(array: Array, *axes: int) -> dict[str, Any]:
    """Pack an array as JSON values.

    Parameters
    ----------
    array : array
        One- or two-dimensional, of ``uint8``, ``uint16``, ``uint32``, ``int32`` or ``float32``.
    *axes : int
        Along these, one after the other, each number is replaced by its difference from the one
        before. Integers wrap around, and so do the sums that undo it.

    Returns
    -------
    dict
        ``type``, the name of the array's type; ``shape``; ``axes``; ``data``, the little-endian numbers
        deflated, in base64.
    """
    packed = array
    for axis in axes:
        packed = np.diff(packed, axis=axis, prepend=packed.dtype.type(0))
    data = packed.astype(packed.dtype.newbyteorder("<")).tobytes()
    return {"type": array.dtype.name, "shape": list(array.shape), "axes": list(axes), "data": _deflated(data)}


def pack_json(value: Any) -> str:
    """Pack JSON values as deflated UTF-8, in base64."""
    return _deflated(json.dumps(value, ensure_ascii=False, separators=(",", ":")).encode("utf-8"))


NUMBER = re.compile(r"[0-9]+")
"""What is taken out of texts: digits in a row."""

GAP = "\0"
"""Stands in their place."""


def pack_alike(values: Iterable[Any]) -> str:
    """Pack JSON values that are alike: lists and objects of many texts, few of them new but for numbers.

    Parameters
    ----------
    values : iterable of JSON values
        Of lists, objects, texts and truth values, but no numbers.

    Returns
    -------
    str
        By :func:`pack_json`: ``texts``, each once, with gaps for numbers; ``columns``, for each text and each
        of its gaps the numbers, in the order in which the texts are come to; ``forms``, each once, with
        places among the texts in place of texts; ``values``, the place of each one's form.
    """
    texts: dict[str, int] = {}
    rows: list[list[list[str]]] = []
    forms: dict[str, int] = {}

    def formed(value: Any) -> Any:
        if isinstance(value, str):
            place = texts.setdefault(NUMBER.sub(GAP, value), len(texts))
            rows.extend([] for _ in range(len(texts) - len(rows)))
            rows[place].append(NUMBER.findall(value))
            return place
        if isinstance(value, dict):
            return {key: formed(part) for key, part in value.items()}
        return [formed(part) for part in value] if isinstance(value, list) else value

    places = [forms.setdefault(json.dumps(formed(value)), len(forms)) for value in values]
    columns = [[" ".join(column) for column in zip(*row, strict=True)] for row in rows]
    kept = {"texts": list(texts), "columns": columns, "forms": list(map(json.loads, forms)), "values": places}
    return pack_json(kept)


def digits(value: Any) -> int:
    """Count the digits in JSON values; packed alike, a text takes 0.4 bytes for each, and little more."""
    return sum(map(len, NUMBER.findall(json.dumps(value, ensure_ascii=False))))


def _deflated(data: bytes) -> str:
    return base64.b64encode(zlib.compress(data, LEVEL)).decode("ascii")
