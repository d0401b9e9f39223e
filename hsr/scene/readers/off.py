"""The Object File Format of Geomview (OFF), as text: also with colours or normals after each vertex.

Source: The Geometry Center, Geomview Manual, section 4.2.5 (OFF files).
"""

from __future__ import annotations

import re
from array import array

import numpy as np

from hsr.base.errors import SceneError
from hsr.scene.meshes import Faces
from hsr.scene.readers.source import bare, decimal, lines, plain, unreadable, whole

FIRST = re.compile(rb"(?:ST)?C?N?(?P<w>4?)(?P<n>n?)OFF(?P<counts>.*)", re.DOTALL)
"""The first word; ModelNet's files have the number of vertices glued to it."""


def read_off(content: bytes) -> Faces:
    """Read an OFF file.

    Raises
    ------
    SceneError
        With the line that does not follow the format.
    """
    rows = ((number, line, words) for number, line in lines(plain(content)) if (words := bare(line).split()))
    number, line, words = next(rows, (1, b"", [b""]))
    head = FIRST.fullmatch(words[0])
    if head is None:
        raise SceneError("an OFF file starts with the word OFF")
    if words[1:2] == [b"BINARY"] or head["n"]:
        raise unreadable(number, line, "only text of points in 3D is read; write it so")
    counts = [word for word in [head["counts"], *words[1:]] if word]
    if not counts:
        number, line, counts = next(rows, (number, line, []))
    try:
        vertex_count, face_count = map(whole, counts[:2])
        if min(vertex_count, face_count) < 0:
            raise ValueError
    except ValueError:
        raise unreadable(number, line, "expected how many vertices and faces there are") from None

    wide = 4 if head["w"] else 3
    values, corner, sides = array("d"), array("q"), array("q")
    for k in range(vertex_count + face_count):
        number, line, words = next(rows, (0, b"", []))
        if not words:
            raise SceneError(f"it ends before its {vertex_count} vertices and {face_count} faces")
        try:
            if k < vertex_count:
                values.extend(map(decimal, words[:wide]))
            else:
                sides.append(whole(words[0]))
                corner.extend(map(whole, words[1 : 1 + sides[-1]]))
        except ValueError:
            raise unreadable(number, line) from None
        if len(words) < (wide if k < vertex_count else 1 + sides[-1]):
            raise unreadable(number, line, "it has fewer numbers than it announces")
    points = np.reshape(values, (-1, wide))
    # Of 4OFF the fourth coordinate divides the others.
    return Faces.of(points[:, :3] / points[:, 3:] if wide == 4 else points, corner, sides)
