"""Pictures as PNG: files of their own, and within a page.

A picture is an array of ``uint8``: grey (H, W), sRGB (H, W, 3), or sRGB and opacity (H, W, 4). Row 0 is the
top row.
"""

from __future__ import annotations

import base64
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

from hsr.base.arrays import Pixels
from hsr.base.files import write_whole


def png(picture: Pixels) -> bytes:
    """Encode a picture as PNG with opacity, with a palette where 256 colours suffice."""
    image = Image.fromarray(picture).convert("RGBA")
    colours, index = np.unique(np.asarray(image).view(np.uint32), return_inverse=True)
    if len(colours) <= 256:
        image = Image.frombytes("P", image.size, index.astype(np.uint8).tobytes())
        image.putpalette(colours.view(np.uint8).tobytes(), "RGBA")
    return _encoded(image)


def data_uri(picture: Pixels) -> str:
    """Return a picture as a data URI; see :func:`png`."""
    return f"data:image/png;base64,{base64.b64encode(png(picture)).decode('ascii')}"


def save_picture(picture: Pixels, path: str | Path) -> None:
    """Write a picture as a PNG file with the channels it has.

    Raises
    ------
    HsrError
        If the file cannot be written.
    """
    write_whole(path, _encoded(Image.fromarray(picture)), "the picture")


def _encoded(image: Image.Image) -> bytes:
    file = BytesIO()
    image.save(file, format="PNG", optimize=True)
    return file.getvalue()
