"""Arrays and texts as short text in a page: differences along axes, deflated, in base64.

A browser takes them apart by ``atob`` and ``DecompressionStream``, and sums the differences up again.
Histories are kept as facts: their words once, and in columns what stands in the gaps between.
"""

from __future__ import annotations

import base64
import json
import math
import zlib
from collections import defaultdict
from collections.abc import Iterable, Sequence
from string import Formatter
from typing import Any

import numpy as np

from hsr.base.arrays import Array
from hsr.difference.telling import Said

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


def pack_told(histories: Iterable[Iterable[tuple[str, Said]]]) -> str:
    """Pack the lines of histories as their facts, in columns: each form once, and what stands in its gaps.

    Parameters
    ----------
    histories : iterable of iterable of (str, Said)
        By :meth:`hsr.difference.history.History.lines`.

    Returns
    -------
    str
        By :func:`pack_json`: ``forms``, each a kind of line and a form; ``columns``, for each form and
        each of its gaps the texts or numbers, to the digits that the form shows, in the order of the lines;
        ``lines``, for each history the places of its lines' forms.
    """
    rows: dict[tuple[str, str], list[tuple[Any, ...]]] = defaultdict(list)
    order: list[list[tuple[str, str]]] = []
    for lines in histories:
        order.append([])
        for kind, said in lines:
            order[-1].append((kind, said.form))
            rows[kind, said.form].append(said.values)
    place = {form: k for k, form in enumerate(rows)}
    packed = {
        "forms": list(rows),
        "columns": [_columns(form, values) for (_, form), values in rows.items()],
        "lines": [[place[form] for form in lines] for lines in order],
    }
    return pack_json(packed)


def _columns(form: str, rows: Sequence[tuple[Any, ...]]) -> list[list[Any]]:
    """Return what stands in each gap of a form, line by line, numbers rounded as the form rounds them."""
    specs = [spec for _, gap, spec, _ in Formatter().parse(form) if gap is not None]
    columns = zip(specs, zip(*rows, strict=True), strict=True)
    return [[_shown(spec or "", value) for value in column] for spec, column in columns]


def _shown(spec: str, value: Any) -> Any:
    if not isinstance(value, float):
        return value
    return float(format(value, spec)) if math.isfinite(value) else format(value, spec)


def _deflated(data: bytes) -> str:
    return base64.b64encode(zlib.compress(data, LEVEL)).decode("ascii")
