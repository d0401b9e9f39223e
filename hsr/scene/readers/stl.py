"""Stereolithography files (STL), binary and text, of one or several solids.

Every facet has three vertices of its own. Normals and the names of solids bear on nothing.
Source: 3D Systems, StereoLithography Interface Specification (1989).
"""

from __future__ import annotations

import re
from array import array

import numpy as np

from hsr.base.arrays import Array
from hsr.base.errors import SceneError
from hsr.scene.meshes import Faces
from hsr.scene.readers.source import decimal, plain, unreadable

HEADER = 84
FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])

TEXT = re.compile(rb"\s*solid\b[^\r\n]*[\r\n]\s*(facet|end)", re.IGNORECASE)
"""How a text file starts; the header of a binary one may begin with the same word."""

SOLID = re.compile(rb"\s*solid\b[^\r\n]*", re.IGNORECASE)
TRIANGLE = re.compile(
    rb"\s*facet\s+(?:(?!outer)\S+\s+){0,4}outer\s+loop"
    + rb"\s+vertex\s+(\S+)\s+(\S+)\s+(\S+)" * 3
    # Some write "end facet".
    + rb"\s+end\s*loop\s+end\s*facet(?!\S)",
    re.IGNORECASE,
)
END = re.compile(rb"\s*end\s*solid\b[^\r\n]*", re.IGNORECASE)
REST = re.compile(rb"[\s\0\x1a]*\Z")
"""What may follow the last solid: white space, and what fills blocks or ends files of old systems."""


def read_stl(content: bytes) -> Faces:
    """Read an STL file.

    Raises
    ------
    SceneError
        With the line or the byte that does not follow the format.
    """
    text = plain(content)
    count = int.from_bytes(content[80:HEADER], "little")
    if len(content) != HEADER + count * FACET.itemsize and TEXT.match(text):
        corners = _text(text)
    elif len(content) >= HEADER:
        corners = _binary(content, count)
    else:
        raise SceneError("it is neither text that starts as an STL file does, nor as long as a binary header")
    return Faces.of_rows(corners.reshape(-1, 3), np.arange(len(corners) * 3).reshape(-1, 3))


def _binary(content: bytes, count: int) -> Array:
    """Return the corners (count, 3, 3)."""
    there = (len(content) - HEADER) // FACET.itemsize
    if there < count:
        raise SceneError(f"byte {len(content)}: facet {there} (counted from 0) of {count} is not whole")
    if there > count and content[HEADER + count * FACET.itemsize :].strip(b"\0"):
        raise SceneError(f"byte {HEADER}: its header announces {count} facets, and there are {there}")
    return np.frombuffer(content, FACET, count, HEADER)["corners"]


def _text(content: bytes) -> Array:
    """Return the corners (n, 3, 3) of the facets of all solids; the last may lack its end."""
    corners, place = array("d"), 0
    while not REST.match(content, place):
        found = SOLID.match(content, place)
        if not found:
            raise _stray(content, place, "solid")
        start = place = found.end()
        while found := TRIANGLE.match(content, place):
            try:
                corners.extend(map(decimal, found.groups()))
            except ValueError:
                raise _stray(content, place, "numbers") from None
            place = found.end()
        found = END.match(content, place)
        if not found and (place == start or not REST.match(content, place)):
            raise _stray(content, place, "a facet of three vertices, or endsolid")
        place = found.end() if found else place
    return np.reshape(corners, (-1, 3, 3))


def _stray(content: bytes, place: int, expected: str) -> SceneError:
    """Return the error that names the line after a place that is read."""
    place += len(content[place:]) - len(content[place:].lstrip())
    before = content[:place].replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    line = re.split(rb"[\r\n]", content[place:], maxsplit=1)[0]
    if not line:
        return SceneError(f"it ends where {expected} is expected")
    return unreadable(before.count(b"\n") + 1, line, f"expected {expected}")
