"""Pictures as files of their own, PNG, and within a page, WebP, which takes half the room and loses nothing.

A picture is an array of ``uint8``: grey (H, W), sRGB (H, W, 3), or sRGB and opacity (H, W, 4). Row 0 is the
top row.
"""

from __future__ import annotations

import base64
from io import BytesIO
from pathlib import Path

from PIL import Image

from hsr.base.arrays import Pixels
from hsr.base.files import write_whole


def data_uri(picture: Pixels) -> str:
    """Return a picture as a data URI."""
    encoded = _encoded(Image.fromarray(picture), "WEBP", lossless=True, exact=True)
    return f"data:image/webp;base64,{base64.b64encode(encoded).decode('ascii')}"


def save_picture(picture: Pixels, path: str | Path) -> None:
    """Write a picture as a PNG file with the channels it has.

    Raises
    ------
    HsrError
        If the file cannot be written.
    """
    write_whole(path, png_of(picture), "the picture")


def png_of(picture: Pixels) -> bytes:
    """Return a picture as what a PNG file holds, with the channels it has."""
    return _encoded(Image.fromarray(picture), "PNG", optimize=True)


def _encoded(image: Image.Image, kind: str, **how: bool) -> bytes:
    file = BytesIO()
    image.save(file, kind, **how)
    return file.getvalue()
