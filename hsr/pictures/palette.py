"""Colours: of the classes and causes of differences, and of faces. All are sRGB, from 0 to 255."""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array, Pixels

CLASS_COLOURS = {
    "missing": (0, 114, 178),
    "extra": (230, 159, 0),
    "wrong face": (204, 32, 38),
    "depth only": (150, 176, 168),
    "tie": (204, 121, 167),
}
"""By the label of a class; told apart by people who see no red or no green as well."""

CAUSE_COLOURS = {
    "tessellation": (0, 114, 178),
    "input rounding": (230, 159, 0),
    "transform": (0, 158, 115),
    "clipping": (86, 180, 233),
    "vertex snapping": (204, 32, 38),
    "fill rule": (240, 228, 66),
    "depth arithmetic": (204, 121, 167),
    "depth format": (119, 61, 160),
    "traversal": (140, 86, 40),
    "intersector": (66, 66, 170),
    "no depth test": (120, 120, 120),
    "unexplained": (0, 0, 0),
}
"""By the label of a cause; letters tell them apart as well."""

COVERED = (128, 128, 128, 56)
"""Colour and opacity of what a face covers, beneath the classes."""

NEUTRAL = 236
"""Grey of the background in a picture of faces, which no face is painted with."""

PLASTIC = 1.324717957244746
"""The plastic number, the real root of x^3 = x + 1."""


def face_colours(face: Array) -> Pixels:
    """Colour of each face id, such that ids near each other look unlike.

    Neighbouring faces mostly have ids that differ by little, or by the length of a mesh's row. Hue
    and brightness follow the additive recurrence of the plastic number in two dimensions: like the
    golden angle in one, it keeps any k multiples in a row about as far apart as k points can be. A
    golden angle alone would paint ids 13 or 21 apart almost alike. The background is a neutral grey.

    Parameters
    ----------
    face : (n,) int
        A negative id is the background.

    Returns
    -------
    (n, 3) uint8
        sRGB.
    """
    from skimage.color import hsv2rgb

    hue = face / PLASTIC**2 % 1.0
    value = 0.55 + 0.4 * (face / PLASTIC % 1.0)
    colours = hsv2rgb(np.stack([hue, np.full_like(hue, 0.5), value], axis=-1))
    return np.where((face < 0)[:, None], np.uint8(NEUTRAL), to_bytes(colours))


def to_bytes(values: Array) -> Pixels:
    """Round values from 0 to 1 to bytes from 0 to 255."""
    return np.rint(255.0 * values).astype(np.uint8)
