"""The renderer under test: it reads a picture of letters, face 0 is ``a``, the background ``.``."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hsr.problem.map import VisibilityMap

LETTERS = ".abcdefgh"


def paint(name: str, method: str = "painter") -> VisibilityMap:
    rows = Path(__file__).with_name(f"{name}.txt").read_text(encoding="ascii").split()
    face = np.array([[LETTERS.index(letter) - 1 for letter in row] for row in rows], dtype=np.int32)
    return VisibilityMap(face, np.where(face < 0, np.inf, 2.0), method)
