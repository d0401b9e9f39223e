"""Points and vectors of three numbers, in the type that they are given in."""

from __future__ import annotations

from hsr.base.arrays import Array
from hsr.base.jit import jit

Vector = tuple[float, float, float]


@jit
def point(row: Array) -> Vector:
    """Return an array of three numbers as a point."""
    return row[0], row[1], row[2]


@jit
def copy(row: Array, to: Array) -> None:
    """Copy numbers, where assigning a row would compile a test of shapes and its words for a failure."""
    for k in range(len(row)):
        to[k] = row[k]


@jit
def like(numbers: Array, vector: Vector) -> Vector:
    """Round a vector to the type of an array."""
    real = numbers.dtype.type
    return real(vector[0]), real(vector[1]), real(vector[2])


@jit
def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@jit
def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@jit
def dot(a: Vector, b: Vector) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
