"""Wavefront OBJ: the lines ``v`` and ``f``; of the rest only free-form surfaces bear on visibility."""

from __future__ import annotations

from array import array
from collections.abc import Iterator

from hsr.scene.meshes import Faces
from hsr.scene.readers.source import bare, decimal, lines, plain, unreadable, whole

UNREAD = {b"surf": "export its surfaces as polygons", b"call": "put that file's lines in its place"}
"""What brings faces that are not read."""


def read_obj(content: bytes) -> Faces:
    """Read a Wavefront OBJ file.

    Raises
    ------
    SceneError
        With the line that does not follow the format.
    """
    vertices, corner, sides = array("d"), array("q"), array("q")
    for number, line in _joined(plain(content)):
        key, *words = line.split() or [b""]
        try:
            if key == b"v":
                x, y, z = words[:3]
                vertices.extend((decimal(x), decimal(y), decimal(z)))
            elif key in (b"f", b"fo"):
                corner.extend([_index(word, len(vertices) // 3) for word in words])
                sides.append(len(words))
        except ValueError:
            raise unreadable(number, line) from None
        if key in UNREAD:
            raise unreadable(number, line, UNREAD[key])
    return Faces.of(vertices, corner, sides)


def _joined(content: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield lines without comments, those that end in a backslash with the next.

    Only lists of numbers are continued: a name or a comment may be a path that ends in a backslash.
    """
    begun: list[bytes] = []
    start = 0
    for number, line in lines(content):
        text = bare(line).strip()
        start = start if begun else number
        if text.endswith(b"\\") and (begun or text.startswith((b"v", b"f"))):
            begun.append(text[:-1])
        else:
            yield start, b" ".join([*begun, text])
            begun = []
    if begun:
        yield start, b" ".join(begun)


def _index(word: bytes, vertices: int) -> int:
    """Return the vertex index, from 0, of a corner written ``v``, ``v/vt``, ``v//vn`` or ``v/vt/vn``.

    OBJ counts from 1; a negative index counts back from the last vertex read so far.
    """
    index = whole(word.partition(b"/")[0])
    return max(index + vertices, -1) if index < 0 else index - 1
