"""Arrays as short text in a page: differences along axes, deflated, in base64.

A browser takes them apart by ``atob`` and ``DecompressionStream``, and sums the differences up again.
"""

from __future__ import annotations

import base64
import json
import zlib
from typing import Any

import numpy as np

from hsr.arrays import Array

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


def _deflated(data: bytes) -> str:
    return base64.b64encode(zlib.compress(data, LEVEL)).decode("ascii")
