"""What a notebook shows of a map or a difference: one small picture and its figures, nothing that moves."""

from __future__ import annotations

import numpy as np
from markupsafe import Markup

from hsr.base.arrays import Pixels
from hsr.difference.classes import Difference
from hsr.pages.pictures import SMALL, class_picture, data_uri, opaque
from hsr.pages.shading import depth_span, face_colours
from hsr.problem.map import BACKGROUND, VisibilityMap

FIGURE = Markup(
    '<figure style="margin: 0; display: flex; gap: 1em; align-items: center">'
    '<img src="{}" alt="{}" style="image-rendering: pixelated; border: 1px solid #8888">'
    '<figcaption style="white-space: pre-wrap; font-family: monospace">{}</figcaption></figure>'
)


def map_html(map: VisibilityMap) -> str:
    """Show a map: its faces, each in a colour of its own, and how many there are.

    Parameters
    ----------
    map : VisibilityMap

    Returns
    -------
    str
        HTML that needs nothing else.
    """
    seen = np.unique(map.face[map.face != BACKGROUND])
    nearest, farthest = depth_span(map)
    covered = np.count_nonzero(map.face != BACKGROUND) / max(map.face.size, 1)
    lines = [
        f"{map.method}  {map.width}x{map.height}",
        f"{len(seen):,} faces on {covered:.1%} of the samples",
    ]
    if len(seen):
        lines.append(f"depth {nearest:.6g} to {farthest:.6g}")
    return FIGURE.format(data_uri(_small_faces(map)), f"faces that {map.method} shows", "\n".join(lines))


def difference_html(difference: Difference) -> str:
    """Show a difference: where another face is shown, and the figures that ``print`` gives.

    Parameters
    ----------
    difference : Difference

    Returns
    -------
    str
        HTML that needs nothing else.
    """
    about = f"where {difference.a.method} differs from {difference.b.method}"
    return FIGURE.format(data_uri(class_picture(difference)), about, str(difference))


def _small_faces(map: VisibilityMap) -> Pixels:
    """Paint every so many samples of a map."""
    side = -(-max(map.face.shape) // SMALL)
    faces = map.face[::side, ::side]
    seen, which = np.unique(faces, return_inverse=True)
    return opaque(face_colours(seen)[which.reshape(faces.shape)])
