"""What a notebook shows of a map or a difference: one small picture and its figures, nothing that moves."""

from __future__ import annotations

import numpy as np
from markupsafe import Markup

from hsr.base.arrays import Floats, Ints, Pixels
from hsr.pictures.maps import SMALL, depth_span, face_picture
from hsr.pictures.png import data_uri

FIGURE = Markup(
    '<figure style="margin: 0; display: flex; gap: 1em; align-items: center">'
    '<img src="{}" alt="{}" style="image-rendering: pixelated; border: 1px solid #8888">'
    '<figcaption style="white-space: pre-wrap; font-family: monospace">{}</figcaption></figure>'
)


def figure(picture: Pixels, about: str, text: str) -> str:
    """Return HTML that needs nothing else: a picture, what it is, and text beside it."""
    return FIGURE.format(data_uri(picture), about, text)


def map_figure(method: str, face: Ints, depth: Floats) -> str:
    """Show a map: its faces, each in a colour of its own, and how many there are; see :func:`figure`."""
    height, width = face.shape
    covered = face >= 0
    seen, share = len(np.unique(face[covered])), covered.sum() / max(face.size, 1)
    text = f"{method}  {width}x{height}\n{seen:,} faces on {share:.1%} of the samples"
    if seen:
        nearest, farthest = depth_span(depth)
        text += f"\ndepth {nearest:.6g} to {farthest:.6g}"
    side = -(-max(face.shape) // SMALL)
    return figure(face_picture(face[::side, ::side]), f"faces that {method} shows", text)
