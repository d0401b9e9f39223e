"""The arrays of glTF files: buffers, views of them, and accessors, whole or sparse.

Source: Khronos Group, glTF 2.0 Specification, sections 3.6 (binary data storage) and 4.4 (GLB).
"""

from __future__ import annotations

import struct
from base64 import b64decode
from pathlib import Path
from typing import Any
from urllib.parse import unquote, unquote_to_bytes

import numpy as np

from hsr.base.arrays import Array
from hsr.base.errors import SceneError

MAGIC = b"glTF"
COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def chunks(content: bytes) -> list[bytes]:
    """Return the text of a GLB file and, if there is one, its binary chunk.

    Raises
    ------
    SceneError
        If it is no GLB file of version 2, or was cut off.
    """
    magic, version, length = struct.unpack_from("<4sII", content.ljust(12))
    if (magic, version) != (MAGIC, 2):
        raise SceneError("it does not start as a GLB file of version 2 does")
    found, place = [], 12
    for kind in (b"JSON", b"BIN\0"):
        size, name = struct.unpack_from("<I4s", content[place : place + 8].ljust(8))
        if name == kind and place + 8 + size <= len(content):
            found.append(content[place + 8 : place + 8 + size])
        elif not found or place < length:
            raise SceneError(f"byte {place}: it has no whole chunk {kind.strip(bytes(1)).decode()}")
        place += 8 + size
    if length > len(content):
        raise SceneError(f"byte {len(content)}: it ends before the {length} bytes that it announces")
    return found


def entry(tree: dict[str, Any], key: str, index: Any) -> dict[str, Any]:
    """Return what an index into a list of a document names.

    Raises
    ------
    SceneError
        If the list has nothing there.
    """
    listed = tree.get(key, [])
    if not isinstance(index, int) or not 0 <= index < len(listed):
        raise SceneError(f"{key}[{index}] does not exist; there are {len(listed)}")
    found: dict[str, Any] = listed[index]
    return found


class Arrays:
    """The arrays of a document.

    Parameters
    ----------
    tree : dict
        The document.
    folder : Path
        Where files of buffers are.
    chunk : list of bytes
        The binary chunk of a GLB file, if there is one.

    Raises
    ------
    SceneError
        If a file of a buffer cannot be read, or has fewer bytes than the document says.

    Attributes
    ----------
    bytes : int
        Of all buffers.
    """

    def __init__(self, tree: dict[str, Any], folder: Path, chunk: list[bytes]) -> None:
        self._tree, self._folder = tree, folder
        self._buffers = [self._load(k, table, chunk) for k, table in enumerate(tree.get("buffers", []))]
        self.bytes = sum(len(buffer or b"") for buffer in self._buffers)

    def _load(self, k: int, table: dict[str, Any], chunk: list[bytes]) -> bytes | None:
        """Return the bytes of a buffer; None if it only stands for what a compressed one would unpack to."""
        uri = table.get("uri")
        if uri is None:
            if k > 0 or not chunk or any(own.get("fallback") for own in table.get("extensions", {}).values()):
                return None
            content = chunk[0]
        elif uri.startswith("data:"):
            head, _, text = uri.partition(",")
            content = b64decode(text) if head.endswith(";base64") else unquote_to_bytes(text)
        else:
            file = self._folder / unquote(uri)
            if not file.is_file():
                raise SceneError(f"buffers[{k}] is in a file that does not exist: {unquote(uri)!r}")
            content = file.read_bytes()
        if len(content) < table["byteLength"]:
            raise SceneError(f"buffers[{k}] has {len(content)} bytes, not {table['byteLength']} as announced")
        return content

    def has_data(self, index: Any) -> bool:
        """Whether an accessor says where its data are."""
        return bool({"bufferView", "sparse"} & entry(self._tree, "accessors", index).keys())

    def read(self, index: Any, kind: str, size: int | None = None) -> Array:
        """Return the array (count, width) of an accessor; normalised whole numbers as float64.

        Parameters
        ----------
        index : int
        kind : str
            What it should be: ``"VEC3"``.
        size : int, optional
            How many there should be.

        Raises
        ------
        SceneError
            If it is something else, or there are fewer bytes than it takes.
        """
        table = entry(self._tree, "accessors", index)
        if table["type"] != kind:
            raise SceneError(f"accessors[{index}] has the type {table['type']}, not {kind}")
        if size not in (None, table["count"]):
            raise SceneError(f"accessors[{index}] has {table['count']} values, not {size}")
        component, count, width = COMPONENTS[table["componentType"]], table["count"], WIDTHS[kind]
        if "bufferView" in table:
            found = self._view(table, component, count, width)
        elif count <= self.bytes:
            found = np.zeros((count, width), component)
        else:
            raise SceneError(f"accessors[{index}] announces {count} values, more than there are bytes")
        if "sparse" in table:
            found = self._filled(found, table["sparse"], component)
        if table.get("normalized") and found.dtype.kind != "f":
            found = np.maximum(found.astype(np.float64) / np.iinfo(found.dtype).max, -1.0)
        return found

    def _filled(self, found: Array, sparse: dict[str, Any], component: str) -> Array:
        """Return an array with some of its rows replaced."""
        where, what = sparse["indices"], sparse["values"]
        rows = self._view(where, COMPONENTS[where["componentType"]], sparse["count"], 1)[:, 0]
        if len(rows) and rows.max() >= len(found):
            raise SceneError(f"a sparse accessor of {len(found)} values replaces number {rows.max()}")
        found = found.copy()
        found[rows] = self._view(what, component, sparse["count"], found.shape[1])
        return found

    def _view(self, place: dict[str, Any], component: str, count: int, width: int) -> Array:
        index = place["bufferView"]
        view = entry(self._tree, "bufferViews", index)
        entry(self._tree, "buffers", view["buffer"])
        content = self._buffers[view["buffer"]]
        if content is None:
            how = ", ".join(view.get("extensions", ()))
            how = f"is compressed by {how}; export it uncompressed" if how else "has no data"
            raise SceneError(f"bufferViews[{index}] {how}")
        size = np.dtype(component).itemsize
        start, stride = view.get("byteOffset", 0), view.get("byteStride") or size * width
        offset, length = place.get("byteOffset", 0), view["byteLength"]
        end = offset + (count - 1) * stride + size * width if count else offset
        if min(offset, start, stride, count) < 0 or end > length or start + length > len(content):
            there = min(length, len(content) - start)
            raise SceneError(f"bufferViews[{index}] has {there} bytes, not the {end} announced")
        return np.ndarray((count, width), component, content, start + offset, (stride, size))
