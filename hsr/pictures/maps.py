"""Pictures of visibility maps and of where two differ, from their arrays; row 0 is the top row."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hsr.base.arrays import Bools, Floats, Ints, Pixels
from hsr.pictures.palette import COVERED, face_colours, to_bytes

SMALL = 192
"""Longer side of a small picture in pixels, at most."""


def face_picture(face: Ints) -> Pixels:
    """Paint every face in a colour of its own; see :func:`hsr.pictures.palette.face_colours`.

    Parameters
    ----------
    face : (H, W) int32
        Face ids, -1 for the background.

    Returns
    -------
    (H, W, 3) uint8
        sRGB.
    """
    seen, which = np.unique(face, return_inverse=True)
    return face_colours(seen)[which.reshape(face.shape)]


def depth_picture(depth: Floats) -> Pixels:
    """Paint depths as greys: the nearest light, the farthest dark, the background black.

    Parameters
    ----------
    depth : (H, W) float64
        In scene units; not finite for the background.

    Returns
    -------
    (H, W) uint8
        Grey.
    """
    share = depth_shares(depth, depth_span(depth))
    return np.where(np.isnan(share), np.uint8(0), to_bytes(0.95 - 0.75 * np.nan_to_num(share)))


def depth_span(depth: Floats) -> tuple[float, float]:
    """Return the least and the greatest finite depth; (0, 1) if there is none."""
    seen = depth[np.isfinite(depth)]
    return (float(seen.min()), float(seen.max())) if len(seen) else (0.0, 1.0)


def depth_shares(depth: Floats, span: tuple[float, float]) -> Floats:
    """Tell how far depths lie from the nearest, 0, toward the farthest, 1; NaN where there is none."""
    nearest, farthest = span
    extent = max(farthest - nearest, np.finfo(np.float64).tiny)
    seen = np.isfinite(depth)
    share = np.clip((np.where(seen, depth, nearest) - nearest) / extent, 0.0, 1.0)
    return np.where(seen, share, np.nan)


def class_picture(classes: Pixels, covered: Bools, colours: Mapping[int, tuple[int, int, int]]) -> Pixels:
    """Paint the classes of samples, small, and so that a single sample can be seen.

    Every pixel stands for a square of samples, and shows the class of the greatest number among them.

    Parameters
    ----------
    classes : (H, W) uint8
    covered : (H, W) bool
        Where a face is seen, which shows beneath the classes.
    colours : mapping of int to (int, int, int)
        sRGB of the classes to be painted, by their numbers; all others are left out.

    Returns
    -------
    (h, w, 4) uint8
        sRGB and opacity; at most SMALL pixels a side.
    """
    from skimage.measure import block_reduce

    side = -(-max(classes.shape) // SMALL)
    palette = np.zeros((256, 4), dtype=np.uint8)
    for number, colour in colours.items():
        palette[number] = (*colour, 255)
    painted = np.where(np.isin(classes, list(colours)), classes, 0)
    picture: Pixels = palette[block_reduce(painted, side, np.max)]
    picture[(picture[..., 3] == 0) & block_reduce(covered, side, np.max)] = COVERED
    return picture
