"""Affine transforms: named steps composed exactly and rounded once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
from flint import arb, arb_mat, ctx, fmpq

from hsr.base.arrays import Floats
from hsr.base.errors import SceneError
from hsr.scene.model import Object, Scatter, Step
from hsr.scene.values import exact_determinant

PRECISION = 256
"""Bits carried while composing; the result is rounded to the 53 of float64 once."""

AXES = {"rotate_x": 0, "rotate_y": 1, "rotate_z": 2}


def compose(steps: Sequence[Step]) -> Floats:
    """Compose steps, the first applied first, into one matrix.

    Parameters
    ----------
    steps : sequence of Step

    Returns
    -------
    (4, 4) float64
        ``world_from_object``: sines and cosines included, every entry is the float64 nearest to
        the true one; what ``PRECISION`` bits cannot tell from 0 is 0. No steps give the identity.

    Raises
    ------
    SceneError
        If an entry leaves the range of float64 so that the matrix is infinite or singular.
    """
    return _composed(tuple(steps)).copy()


@lru_cache(maxsize=1 << 16)
def _composed(steps: tuple[Step, ...]) -> Floats:
    """Compose; a scene asks several times for the matrix of every object."""
    if not steps:
        return np.eye(4)
    with ctx.workprec(PRECISION):
        product = _matrix_of(steps[0])
        for step in steps[1:]:
            product = _matrix_of(step) * product
        matrix = np.array([[_rounded(product[i, j]) for j in range(4)] for i in range(4)])
    if not np.isfinite(matrix).all() or exact_determinant(matrix[:3, :3]) == 0:
        raise SceneError("the steps together over- or underflow float64; use less extreme numbers")
    return matrix


def _rounded(entry: arb) -> float:
    return 0.0 if entry.contains(0) else float(entry.mid())


def placed(points: Floats, matrix: Floats) -> Floats:
    """Return points moved by an affine matrix, each coordinate a sum of three products and an offset.

    Not a matrix product: for many points that of BLAS takes threads, which go on spinning for some 20 ms
    beside what comes next, and fused operations, which round otherwise on other processors.

    Parameters
    ----------
    points : (n, 3) float64
    matrix : (m, 4) float64
        A row for each coordinate of the result.

    Returns
    -------
    (n, m) float64
    """
    x, y, z = np.ascontiguousarray(points.T)
    return np.stack([a * x + b * y + c * z + d for a, b, c, d in matrix], axis=1)


def copies(thing: Object) -> Iterator[tuple[str, Floats]]:
    """Yield the name and ``world_from_object`` (4, 4) of every copy of an object.

    An object that is not scattered is its own only copy; the k-th of several is called ``name.k``.

    Raises
    ------
    SceneError
        As :func:`compose`, with the name of the object.
    """
    try:
        own = compose(thing.transform)
    except SceneError as error:
        raise SceneError(f"object {thing.name!r}: {error}") from None
    if thing.scatter is None:
        yield thing.name, own
        return
    for k, placing in enumerate(_scattered(thing.scatter)):
        yield f"{thing.name}.{k}", placing @ own


def _scattered(scatter: Scatter) -> Floats:
    """Random matrices (count, 4, 4): scale, turn about y, move on the ground."""
    random = np.random.default_rng(scatter.seed)
    scale = random.uniform(*scatter.scale, scatter.count)
    angle = random.uniform(0.0, 2.0 * np.pi, scatter.count)
    matrices = np.zeros((scatter.count, 4, 4))
    matrices[:, 0, 0] = matrices[:, 2, 2] = scale * np.cos(angle)
    matrices[:, 0, 2] = scale * np.sin(angle)
    matrices[:, 2, 0] = -matrices[:, 0, 2]
    matrices[:, 1, 1], matrices[:, 3, 3] = scale, 1.0
    matrices[:, 0, 3] = random.uniform(*scatter.x, scatter.count)
    matrices[:, 2, 3] = random.uniform(*scatter.z, scatter.count)
    return matrices


def _matrix_of(step: Step) -> arb_mat:
    ((key, value),) = step.given.items()
    if key == "matrix":
        return arb_mat([list(row) for row in value])
    matrix = arb_mat(4, 4, [int(i == j) for i in range(4) for j in range(4)])
    if key in AXES:
        _rotate(matrix, AXES[key], value)
    else:
        for i in range(3):
            matrix[i, 3 if key == "translate" else i] = arb(value[i])
    return matrix


def _rotate(matrix: arb_mat, axis: int, degrees: float) -> None:
    """Turn counter-clockwise about a coordinate axis, in the plane of the two axes that follow."""
    half_turns = fmpq(*degrees.as_integer_ratio()) / 180
    sine, cosine = arb.sin_cos_pi_fmpq(half_turns)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[i, i] = matrix[j, j] = cosine
    matrix[i, j], matrix[j, i] = -sine, sine
