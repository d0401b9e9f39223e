"""The Polygon File Format (PLY), text and binary, with any elements and properties.

Source: Turk, The PLY Polygon File Format, Stanford University (1994). Triangle strips are those of the
Stanford scans: an element ``tristrips`` of lists in which -1 begins another strip.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from struct import Struct
from typing import Any, Literal, NamedTuple

import numpy as np

from hsr.base.arrays import Array
from hsr.base.errors import SceneError
from hsr.scene.meshes import Faces, strip_triangles
from hsr.scene.readers.source import LINE, decimal, lines, plain, unreadable, whole

OLD = ("char", "uchar", "short", "ushort", "int", "uint", "float", "double")
NEW = ("int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64")
CODES = ("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")
TYPES = {name.encode(): code for names in (OLD, NEW) for name, code in zip(names, CODES, strict=True)}
COUNTERS = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I"}
"""Types of the numbers that say how long a list is, as ``struct`` calls them."""

ORDERS = {b"ascii": "", b"binary_little_endian": "<", b"binary_big_endian": ">"}
BYTES: dict[str, Literal["little", "big"]] = {"<": "little", ">": "big"}
AXES, LISTS = ("x", "y", "z"), ("vertex_indices", "vertex_index")


class Column(NamedTuple):
    """All values of a property, row after row, and how many each row has."""

    values: Array
    sides: Array


class Property(NamedTuple):
    """One property of an element, a list if there is a type that counts it; types as NumPy writes them."""

    name: str
    type: str
    counted: str = ""

    @property
    def wanted(self) -> bool:
        """Whether it bears on the mesh."""
        return self.name in (LISTS if self.counted else AXES)

    def column(self, values: Any, sides: Any) -> Column:
        """Return its column, of the type that the header says; text may say more digits than that has."""
        found = np.asarray(values)
        return Column(found.astype("f4") if self.type == "f4" else found, np.asarray(sides))


class Element(NamedTuple):
    """What the header says of vertices, faces, or whatever else there is."""

    name: str
    size: int
    properties: list[Property]

    def cut_off(self, row: int) -> str:
        """Say which row is not whole."""
        return f"row {row} (counted from 0) of the {self.size} of element {self.name} is not whole"


Columns = dict[str, Column]


def read_ply(content: bytes) -> Faces:
    """Read a PLY file.

    Raises
    ------
    SceneError
        With the line or the byte where it does not follow its header.
    """
    content = plain(content)
    order, elements, start, line = _header(content)
    rows = _rows(content, start, line)
    found: dict[str, Columns] = {}
    for element in elements:
        if order:
            found[element.name], start = _binary(content, start, element, order)
        else:
            found[element.name] = _text(rows, element)
    vertex = found.get("vertex", {})
    if not vertex.keys() >= {*AXES}:
        raise SceneError("its header announces no vertices with x, y and z")
    vertices = np.stack([vertex[axis].values for axis in AXES], axis=1)
    corner, sides = _lists(found, "face")
    strips = _lists(found, "tristrips")
    # Some write the -1 that begins another strip as an unsigned number.
    triangles = strip_triangles(np.where(strips.values == 2**32 - 1, -1, strips.values), strips.sides)
    return Faces.of(vertices, np.append(corner, triangles), np.append(sides, np.full(len(triangles), 3)))


def _lists(found: dict[str, Columns], name: str) -> Column:
    """Return the vertex indices of an element; none if there is no such element."""
    columns = found.get(name, {LISTS[0]: Column(np.empty(0, np.int64), np.empty(0, np.int64))})
    lists = [column for key, column in columns.items() if key in LISTS]
    if len(lists) != 1:
        raise SceneError(f"its element {name} has {len(lists)} lists {' or '.join(LISTS)}; it needs one")
    return Column(lists[0].values.astype(np.int64), lists[0].sides)


# ---------------------------------------------------------------- header


def _header(content: bytes) -> tuple[str, list[Element], int, int]:
    """Return the order of bytes, empty for text; the elements; the byte and the line after the header."""
    order, elements, ending = None, list[Element](), b""
    taken: set[tuple[int, bytes]] = set()  # names of elements, of number 0, and of properties of each
    for number, found in enumerate(LINE.finditer(content), 1):
        words, ending = found[1].split(), ending or found[2]
        if number == 1 and words != [b"ply"]:
            raise SceneError("a PLY file starts with the word ply")
        if not found[2]:
            raise SceneError(f"line {number}: its header ends without end_header")
        try:
            match words:
                case [] | [b"ply" | b"comment" | b"obj_info", *_]:
                    pass
                case [b"format", form, _]:
                    order = ORDERS[form]
                case [b"element", name, count] if count.isdigit() and (0, name) not in taken:
                    taken.add((0, name))
                    elements.append(Element(name.decode("latin-1"), whole(count), []))
                case [b"property", *types, name] if (len(elements), name) not in taken:
                    taken.add((len(elements), name))
                    elements[-1].properties.append(_property(name.decode("latin-1"), types))
                case [b"end_header"] if order is not None:
                    # Where lines end in CR alone, a byte of 10 is the first of what follows.
                    end = found.start(2) + 1 if ending == b"\r" else found.end()
                    return order, [other for other in elements if other.properties], end, number + 1
                case _:
                    raise ValueError
        except (ValueError, KeyError, IndexError):
            raise unreadable(number, found[1]) from None
    raise AssertionError


def _property(name: str, types: list[bytes]) -> Property:
    """Return a property; lists are counted in whole numbers, and name vertices by them."""
    if types[0] != b"list":
        (kind,) = types
        return Property(name, TYPES[kind])
    _, counted, kind = types
    if TYPES[counted] not in COUNTERS or (name in LISTS and TYPES[kind] not in COUNTERS):
        raise ValueError
    return Property(name, TYPES[kind], TYPES[counted])


# ---------------------------------------------------------------- text


def _rows(content: bytes, start: int, first: int) -> Iterator[tuple[int, bytes, list[bytes]]]:
    """Yield the lines with words, except comments."""
    for number, line in lines(content, start, first):
        words = line.split()
        if words and words[0] != b"comment":
            yield number, line, words


def _text(rows: Iterator[tuple[int, bytes, list[bytes]]], element: Element) -> Columns:
    """Read the rows of an element, a line each."""
    wanted = [key for key in element.properties if key.wanted]
    values: dict[str, array[Any]] = {key.name: array("q" if key.counted else "d") for key in wanted}
    sides = {key.name: array("q") for key in wanted}
    for k in range(element.size):
        number, line, words = next(rows, (0, b"", []))
        if not words:
            raise SceneError(element.cut_off(k))
        place = 0
        try:
            for name, _, counted in element.properties:
                count = whole(words[place]) if counted else 1
                place += bool(counted)
                if name in values:
                    values[name].extend(map(whole if counted else decimal, words[place : place + count]))
                    sides[name].append(count)
                place += max(count, 0)
        except (ValueError, IndexError):
            raise unreadable(number, line) from None
        if place != len(words):
            raise unreadable(number, line, f"its header announces {place} numbers, it has {len(words)}")
    return {key.name: key.column(values[key.name], sides[key.name]) for key in wanted}


# ---------------------------------------------------------------- binary


def _binary(content: bytes, start: int, element: Element, order: str) -> tuple[Columns, int]:
    """Read the rows of an element; return where they end, too."""
    rows = _alike(content, start, element, order)
    if rows is None:
        return _one_by_one(content, start, element, order)
    columns = {
        key.name: Column(rows[key.name].reshape(-1), np.full(len(rows), rows[key.name].shape[1]))
        for key in element.properties
        if key.wanted
    }
    return columns, start + rows.nbytes


def _alike(content: bytes, start: int, element: Element, order: str) -> Array | None:
    """Return all rows as one array, if their lists are as long as those of the first row."""
    fields: list[tuple[str, str] | tuple[str, str, tuple[int]]] = []
    counters, place = [], start
    for name, kind, counted in element.properties if element.size else ():
        length = 1
        if counted:
            counters.append(f"{name} #")
            fields.append((counters[-1], order + counted))
            told = content[place : place + int(counted[1])]
            length = int.from_bytes(told, BYTES[order], signed=counted[0] == "i")
            if length < 0:
                return None
            place += int(counted[1])
        fields.append((name, order + kind, (length,)))
        place += length * int(kind[1])
    if not element.size or (place - start) * element.size > len(content) - start:
        return None
    rows = np.frombuffer(content, fields, element.size, start)
    return rows if all((rows[name] == rows[name][0]).all() for name in counters) else None


def _one_by_one(content: bytes, start: int, element: Element, order: str) -> tuple[Columns, int]:
    """Walk through rows whose lists differ in length."""
    values = {key.name: bytearray() for key in element.properties if key.wanted}
    sides = {name: array("q") for name in values}
    plan = [
        (name, int(kind[1]), Struct(order + COUNTERS[counted]) if counted else None)
        for name, kind, counted in element.properties
    ]
    place = start
    for k in range(element.size):
        for name, size, counter in plan:
            count, first = 1, place
            if counter:
                first += counter.size
                (count,) = counter.unpack_from(content, place) if first <= len(content) else (0,)
            place = first + count * size
            if count < 0 or max(first, place) > len(content):
                raise SceneError(f"byte {min(first, len(content))}: {element.cut_off(k)}")
            if name in values:
                values[name] += content[first:place]
                sides[name].append(count)
    kinds = {key.name: order + key.type for key in element.properties}
    return {
        name: Column(np.frombuffer(values[name], kinds[name]), np.asarray(sides[name])) for name in values
    }, place
