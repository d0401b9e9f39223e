"""The still pictures of pages: small PNG files within the page."""

from __future__ import annotations

import base64
import io

import numpy as np
from PIL import Image

from hsr.base.arrays import Pixels
from hsr.difference.classes import OTHER_OWNER, Difference, SampleClass
from hsr.models.stages import Cause
from hsr.problem.map import BACKGROUND

CLASS_COLOURS = {
    SampleClass.MISSING: (0, 114, 178),
    SampleClass.EXTRA: (230, 159, 0),
    SampleClass.WRONG_FACE: (204, 32, 38),
    SampleClass.DEPTH_ONLY: (150, 176, 168),
    SampleClass.TIE: (204, 121, 167),
}
"""sRGB of the classes, told apart by people who see no red or no green as well."""

CAUSE_COLOURS = {
    Cause.TESSELLATION: (0, 114, 178),
    Cause.INPUT_ROUNDING: (230, 159, 0),
    Cause.TRANSFORM: (0, 158, 115),
    Cause.CLIPPING: (86, 180, 233),
    Cause.VERTEX_SNAPPING: (204, 32, 38),
    Cause.FILL_RULE: (240, 228, 66),
    Cause.DEPTH_ARITHMETIC: (204, 121, 167),
    Cause.DEPTH_FORMAT: (119, 61, 160),
    Cause.TRAVERSAL: (140, 86, 40),
    Cause.INTERSECTOR: (66, 66, 170),
    Cause.NO_DEPTH_TEST: (120, 120, 120),
    Cause.UNEXPLAINED: (0, 0, 0),
}
"""sRGB of the causes; letters tell them apart as well."""

COVERED = (128, 128, 128, 56)
"""sRGB and opacity of what a face covers, beneath the classes."""

SMALL = 192
"""Longer side of a small picture in pixels, at most."""


def png(pixels: Pixels) -> bytes:
    """Encode a picture as PNG, with a palette where 256 colours suffice.

    Parameters
    ----------
    pixels : (H, W, 4) uint8
        sRGB and opacity, row 0 at the top.
    """
    height, width = pixels.shape[:2]
    colours, index = np.unique(np.ascontiguousarray(pixels).view(np.uint32), return_inverse=True)
    if len(colours) <= 256:
        image = Image.frombytes("P", (width, height), index.astype(np.uint8).tobytes())
        image.putpalette(colours.view(np.uint8).tobytes(), "RGBA")
    else:
        image = Image.fromarray(pixels)
    file = io.BytesIO()
    image.save(file, format="PNG", optimize=True)
    return file.getvalue()


def data_uri(pixels: Pixels) -> str:
    """Return a picture as a data URI; see :func:`png`."""
    return f"data:image/png;base64,{base64.b64encode(png(pixels)).decode('ascii')}"


def opaque(picture: Pixels) -> Pixels:
    """Turn a grey (H, W) or coloured (H, W, 3) picture into one with opacity, (H, W, 4)."""
    height, width = picture.shape[:2]
    whole = np.full((height, width, 4), 255, dtype=np.uint8)
    whole[..., :3] = picture.reshape(height, width, -1)
    return whole


def class_picture(difference: Difference) -> Pixels:
    """Paint where two maps differ, small, and so that a single sample can be seen.

    Every pixel stands for a square of samples. It shows a difference if any of them has one, a wrong face
    before what is missing or extra; ties and depths are left out.

    Returns
    -------
    (h, w, 4) uint8
        sRGB and opacity; at most SMALL pixels a side.
    """
    side = -(-max(difference.classes.shape) // SMALL)
    counts = np.where(np.isin(difference.classes, OTHER_OWNER), difference.classes, SampleClass.SAME)
    palette = np.zeros((len(SampleClass), 4), dtype=np.uint8)
    for kind in OTHER_OWNER:
        palette[kind] = (*CLASS_COLOURS[kind], 255)
    picture = palette[_greatest(counts, side)]
    covered = _greatest((difference.b.face != BACKGROUND).astype(np.uint8), side)
    picture[(picture[..., 3] == 0) & (covered > 0)] = COVERED
    return picture


def _greatest(values: Pixels, side: int) -> Pixels:
    """Return the greatest value of every square of ``side`` samples."""
    height, width = values.shape
    padded = np.pad(values, [(0, -height % side), (0, -width % side)])
    greatest: Pixels = padded.reshape(-(-height // side), side, -1, side).max(axis=(1, 3))
    return greatest
