"""Triangles that cannot be set up from projected corners: one is at or behind the eye, or all but there.

Their homogeneous edges need no projected corners, nor any clipping (Olano & Greer, "Triangle Scan Conversion
Using 2D Homogeneous Coordinates", 1997). They are few, and set up exactly; each coefficient is rounded once.
"""

from __future__ import annotations

import numpy as np

from hsr.base.arrays import Array, Bools, Floats, Ints
from hsr.certify import facets_at
from hsr.kernels.zbuffer import setup
from hsr.kernels.zbuffer.setup import CLUSTER, ERROR, NEARNESS, PRECISE, TABLE, Eye, U
from hsr.problem.view import View

ROUNDED = 16.0 * U
"""Bound of the error of an edge function of which no term is above 1 on the image: three coefficients, a
quotient each, and fewer than ten roundings of numbers below 1."""


def crossing_triangles(screen: Floats, corner: Ints, eye: Eye) -> Array:
    """Return the triangles (t,) that ``setup.set_up`` leaves out because a corner is not certain.

    Parameters
    ----------
    screen : (V, 4) float64
        Projected vertices.
    corner : (n, 3) int32
    eye : Eye
    """
    certain = screen[:, ERROR] <= PRECISE
    if certain.all():
        return np.empty(0, np.int64)
    ahead = _may_be_ahead(screen[:, NEARNESS], eye)
    return np.flatnonzero(~certain[corner].all(axis=1) & ahead[corner].any(axis=1))


def crossing_tables(view: View, clip: Floats, piece: Ints, number: Array, eye: Eye) -> Floats:
    """Set up crossing triangles.

    Parameters
    ----------
    view : View
    clip : (t, 3, 3) float64
        Clip coordinates (x, y, d) of their corners, with the errors that the eye says.
    piece : (t,) int
        Their numbers among the pieces of the view, see :func:`hsr.certify.first_pieces`.
    number : (t,) int
        The numbers that they get.
    eye : Eye

    Returns
    -------
    (tables, TABLE) float64
        Tables; in the last one, places without a triangle have no scan lines.
    """
    if not len(clip):
        return np.empty((0, TABLE))
    box = boxes(clip, view.near, eye)
    crossed = np.flatnonzero((box[:, 0] < box[:, 1]) & (box[:, 2] < box[:, 3]))
    if not len(crossed):
        return np.empty((0, TABLE))
    columns = np.zeros((TABLE // CLUSTER, -(-len(crossed) // CLUSTER) * CLUSTER))
    columns[:, : len(crossed)] = _columns(view, piece[crossed], box[crossed], eye)
    columns[setup.NUMBER // CLUSTER, : len(crossed)] = number[crossed]
    return columns.reshape(len(columns), -1, CLUSTER).swapaxes(0, 1).reshape(-1, TABLE)


def _may_be_ahead(nearness: Floats, eye: Eye) -> Bools:
    """Tell which vertices may be in front of the eye."""
    if not eye.perspective:
        return np.ones(len(nearness), np.bool_)
    with np.errstate(divide="ignore"):
        return np.asarray(~(1.0 / nearness < -eye.error_d))


def boxes(clip: Floats, near: float, eye: Eye) -> Floats:
    """Bound the samples that triangles may cover.

    Parameters
    ----------
    clip : (n, 3, 3) float64
        Clip coordinates (x, y, d) of the corners.
    near : float
        Depth of the near plane.
    eye : Eye

    Returns
    -------
    (n, 4) float64
        First and end column, first and end line.

    Notes
    -----
    Under perspective, what is seen is the hull of the corners beyond a depth just below near, and of the
    points in which the sides cross it. Projected, each is off by at most what
    :func:`hsr.kernels.zbuffer.setup.projected` says, and a point of a side by some roundings of the
    ends' coordinates.
    """
    whole = np.array([0.0, eye.width, 0.0, eye.height])
    least = near - 2.0 * eye.error_d
    if not eye.perspective or least <= 2.0 * eye.error_d:
        return np.broadcast_to(whole, (len(clip), 4))
    following = np.roll(clip, -1, axis=1)
    d, next_d = clip[..., 2], following[..., 2]
    crosses = (d >= least) != (next_d >= least)
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.where(crosses, (least - d) / (next_d - d), 0.0)[..., None]
        crossing = (clip + part * (following - clip))[..., :2] / least
        corners = clip[..., :2] / d[..., None]
    points = np.concatenate([corners, crossing], axis=1)
    seen = np.concatenate([d >= least, crosses], axis=1)[..., None]
    low, high = np.where(seen, points, np.inf).min(axis=1), np.where(seen, points, -np.inf).max(axis=1)
    size = np.abs(clip).max(axis=(1, 2))
    error = (2.0 * (max(eye.error_x, eye.error_y) + 2.0 * eye.error_d) + 64.0 * U * size)[:, None] / least
    # Farther out than 2 an error of the depth counts for more, but does not bring a point onto the image.
    # The difference of two numbers that overflowed may be anything.
    low, high = np.fmax(low - error, -2.0), np.fmin(high + error, 2.0)
    low, high = np.minimum(low, 2.0), np.maximum(high, -2.0)
    left, right = (1.0 + low[:, 0]) * 0.5 * eye.width, (1.0 + high[:, 0]) * 0.5 * eye.width
    top, bottom = (1.0 - high[:, 1]) * 0.5 * eye.height, (1.0 - low[:, 1]) * 0.5 * eye.height
    sides = [np.floor(left - 1.0), np.ceil(right + 1.0), np.floor(top - 1.0), np.ceil(bottom + 1.0)]
    empty = ~seen.any(axis=(1, 2))
    box = np.clip(np.stack(sides, axis=1), 0.0, np.array([eye.width, eye.width, eye.height, eye.height]))
    box[empty] = 0.0
    return np.asarray(box)


def _columns(view: View, piece: Ints, box: Floats, eye: Eye) -> Floats:
    """Return the parts (TABLE / CLUSTER, n) of a table of pieces, relative to their boxes."""
    frame, facets = facets_at(view, piece)
    columns = np.zeros((TABLE // CLUSTER, len(piece)))
    left, right, top, bottom = box.T
    # The place of a sample in the frame: two units to the next, the second one running up.
    i = (2 * left + 1 - view.width).astype(np.int64).astype(object)
    j = (view.height - 1 - 2 * top).astype(np.int64).astype(object)

    # Scale each edge function so that nowhere on the image a term of it is above 1.
    for edge in range(3):
        a, b, c = np.array([facet.inside[edge] for facet in facets], object).T
        value, to_right, down = a * i + b * j + c, 2 * a, -2 * b
        size = np.maximum(abs(value) + abs(to_right) * view.width + abs(down) * view.height, 1)
        for part, number in ((setup.E0, value), (setup.ACROSS0, to_right), (setup.BELOW0, down)):
            columns[part // CLUSTER + edge] = number / size

    # Nearness is affine on the screen, too. That w is taken for depth is an error such as vertices have.
    a, b, c, s = np.array([facet.plane for facet in facets], object).T
    s = np.maximum(s, 1)
    above, below = (frame.unit, 1) if view.perspective else (1, frame.unit)
    share = w_at_depth_1(view)
    value, to_right, down = (
        -share * _quotient(number * above, s * below) for number in (a * i + b * j + c, 2 * a, -2 * b)
    )
    z, z_x, z_y = setup.CLOSEST + (eye.closest - value) * eye.scale, -to_right * eye.scale, -down * eye.scale
    # A value is rounded three times, and as often when it becomes a key depth.
    slack = setup.nearness_error(eye.closest, eye) + 8.0 * U * (abs(eye.closest) + abs(value))
    growth = abs(z_x) * view.width + abs(z_y) * view.height
    error = slack * eye.scale + 64.0 * U * (1.0 + growth)
    bounded = np.isfinite(error)
    z, z_x, z_y = (np.where(bounded, number, 0.0) for number in (z, z_x, z_y))
    parts: dict[int, Floats | float] = dict.fromkeys((setup.AREA, setup.NEAREST, setup.CUT), 1.0)
    parts |= {setup.Z: z, setup.Z_X: z_x, setup.Z_Y: z_y, setup.Z_ERROR: np.where(bounded, error, np.inf)}
    parts[setup.BOUND] = ROUNDED
    bottom = np.where([facet.drawn for facet in facets], bottom, top)
    parts |= {setup.LEFT: left, setup.RIGHT: right, setup.TOP: top, setup.BOTTOM: bottom}
    for part, number in parts.items():
        columns[part // CLUSTER] = number
    return columns


def _quotient(above: Array, below: Array) -> Floats:
    """Return quotients (n,) of whole numbers, ``below`` positive; infinity for what float64 cannot hold."""
    beyond = abs(above) >= below << 1023
    return np.where(beyond, np.inf, np.where(beyond, 0, above) / below).astype(np.float64)


def w_at_depth_1(view: View) -> float:
    """Return the clip coordinate w of a point at depth 1 under perspective; 1 for a parallel view."""
    if not view.perspective:
        return 1.0
    largest = np.abs(view.depth_row[:3]).argmax()
    return float(view.clip_from_world[3, largest] / view.depth_row[largest])
